// SPDX-License-Identifier: Apache-2.0
#include "framework/core/params.hpp"

#include "framework/core/error.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace ockham {
namespace {

template <class... Fs>
struct Overload : Fs... {
    using Fs::operator()...;
};
template <class... Fs> // compilers before P1816 need it said
Overload(Fs...)->Overload<Fs...>;

std::string number_text(double value) {
    if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
    return fmt::format("{}", value);
}

std::string range_text(const Param& param, bool whole) {
    const char* number = whole ? "a whole number" : "a number";
    if (std::isinf(param.low) && std::isinf(param.high)) return number;
    if (std::isinf(param.high))
        return fmt::format("{} of at least {}", number, number_text(param.low));
    return fmt::format("{} from {} to {}", number, number_text(param.low), number_text(param.high));
}

/// The whole text as a number, or an error that names the flag.
template <class Number>
Number parse_number(const Param& param, const std::string& text) {
    Number value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    const bool whole = error == std::errc{} && end == text.data() + text.size();
    const double wide = static_cast<double>(value);
    if (!whole || std::isnan(wide) || wide < param.low || wide > param.high) {
        fail_input("--{}: found '{}', expected {}", param.name, text,
            range_text(param, std::is_integral_v<Number>));
    }
    return value;
}

std::string join(const std::vector<std::string>& words, const char* separator) {
    return fmt::format("{}", fmt::join(words, separator));
}

} // namespace

Param& Param::range(double new_low, double new_high) {
    low = new_low;
    high = new_high;
    return *this;
}
Param& Param::choices(std::vector<std::string> names) {
    allowed = std::move(names);
    return *this;
}
Param& Param::unit(std::string new_name) {
    unit_name = std::move(new_name);
    return *this;
}
Param& Param::on_off() {
    takes_on_off = true;
    default_text = text();
    return *this;
}
Param& Param::group(std::string new_name) {
    group_name = std::move(new_name);
    return *this;
}
Param& Param::letter(char new_name) {
    alias = new_name;
    return *this;
}
Param& Param::positional() {
    is_positional = true;
    return *this;
}
Param& Param::transient() {
    is_transient = true;
    return *this;
}

std::string Param::text() const {
    return std::visit(Overload{[&](const bool* v) -> std::string { return *v ? "on" : "off"; },
                          [](const int* v) { return fmt::format("{}", *v); },
                          [](const std::uint64_t* v) { return fmt::format("{}", *v); },
                          [](const float* v) -> std::string {
                              return std::isinf(*v) ? number_text(*v) : fmt::format("{}", *v);
                          },
                          [](const std::string* v) { return *v; },
                          [](const std::vector<std::string>* v) { return join(*v, " "); }},
        target);
}

void Param::set(const std::string& text) {
    if (!allowed.empty() && std::find(allowed.begin(), allowed.end(), text) == allowed.end()) {
        fail_input("--{}: found '{}', expected one of {}", name, text, join(allowed, ", "));
    }
    std::visit(Overload{[&](bool* v) {
                            if (text != "on" && text != "off")
                                fail_input("--{}: found '{}', expected on or off", name, text);
                            *v = text == "on";
                        },
                   [&](int* v) { *v = parse_number<int>(*this, text); },
                   [&](std::uint64_t* v) { *v = parse_number<std::uint64_t>(*this, text); },
                   [&](float* v) { *v = parse_number<float>(*this, text); },
                   [&](std::string* v) { *v = text; },
                   [&](std::vector<std::string>* v) { v->push_back(text); }},
        target);
    given = true;
}

Param& Params::add(std::string name, Param::Target target, std::string help) {
    check(find(name) == nullptr, "a parameter is declared once");
    params_.push_back(std::make_unique<Param>());
    Param& param = *params_.back();
    param.name = std::move(name);
    param.target = target;
    param.help = std::move(help);
    param.default_text = param.text();
    return param;
}

std::vector<Param*> Params::all() const {
    std::vector<Param*> list;
    for (const auto& param : params_) list.push_back(param.get());
    return list;
}

Param* Params::find(std::string_view name) const {
    for (const auto& param : params_) {
        if (param->name == name) return param.get();
    }
    return nullptr;
}

bool Params::given(std::string_view name) const {
    const Param* param = find(name);
    return param != nullptr && param->given;
}

nlohmann::json Params::to_json() const {
    nlohmann::json json = nlohmann::json::object();
    for (const auto& param : params_) {
        if (param->is_transient) continue;
        json[param->name] = std::visit(Overload{[](const float* v) -> nlohmann::json {
                                                    if (std::isinf(*v)) return number_text(*v);
                                                    return *v;
                                                },
                                           [](const auto* v) -> nlohmann::json { return *v; }},
            param->target);
    }
    return json;
}

void Params::from_json(const nlohmann::json& json, const std::string& where) {
    if (!json.is_object()) fail_input("{}: expected a JSON object of parameters", where);
    for (const auto& [key, value] : json.items()) {
        Param* param = find(key);
        if (param == nullptr || param->is_transient) {
            fail_input("{}: unknown parameter '{}'; --help lists them", where, key);
        }
        if (param->given) continue; // the command line wins
        const auto set_one = [&](const nlohmann::json& item) {
            if (item.is_boolean()) return param->set(item.get<bool>() ? "on" : "off");
            if (item.is_string()) return param->set(item.get<std::string>());
            if (item.is_number()) return param->set(item.dump());
            fail_input("parameter '{}' has a value of type {}", key, item.type_name());
        };
        try {
            if (param->is_list() && value.is_array()) {
                for (const auto& item : value) set_one(item);
            } else {
                set_one(value);
            }
        } catch (const Error& error) {
            throw Error(error.kind(), fmt::format("{}: {}", where, error.what()));
        }
    }
}

} // namespace ockham
