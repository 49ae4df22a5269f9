// SPDX-License-Identifier: Apache-2.0
#include "framework/core/json_object.hpp"

#include "framework/core/error.hpp"
#include "framework/core/file.hpp"
#include "framework/core/log.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ockham {

using nlohmann::json;

JsonObject::JsonObject(const json& value, std::string kind, std::string file)
    : value_(value), kind_(std::move(kind)), file_(std::move(file)) {
    if (!value_.is_object()) refuse("the " + kind_, value_, "an object");
}

JsonObject::JsonObject(const json& value, const JsonObject& parent, std::string place)
    : value_(value), kind_(parent.kind_), file_(parent.file_), place_(std::move(place)) {
    if (!value_.is_object()) refuse(place_, value_, "an object");
}

void JsonObject::warn_unknown(std::initializer_list<std::string_view> known) const {
    for (const auto& [key, value] : value_.items()) {
        if (std::find(known.begin(), known.end(), key) != known.end()) continue;
        log::warning("{} '{}': unknown key '{}' is ignored", kind_, file_, name(key));
    }
}

bool JsonObject::has(const char* key) const { return value_.contains(key); }

JsonObject JsonObject::object(const char* key) const { return {get(key), *this, name(key)}; }

std::vector<JsonObject> JsonObject::objects(const char* key) const {
    const json& list = get(key);
    if (!list.is_array()) refuse(name(key), list, "an array of objects");
    std::vector<JsonObject> result;
    for (const json& item : list)
        result.push_back({item, *this, fmt::format("{}[{}]", name(key), result.size())});
    return result;
}

std::string JsonObject::text(const char* key) const {
    const json& value = get(key);
    if (!value.is_string()) refuse(name(key), value, "a string");
    return value.get<std::string>();
}

bool JsonObject::boolean(const char* key, bool fallback) const {
    if (!has(key)) return fallback;
    const json& value = get(key);
    if (!value.is_boolean()) refuse(name(key), value, "true or false");
    return value.get<bool>();
}

double JsonObject::number(const char* key, double low, double high, const char* expected) const {
    return number(get(key), name(key), low, high, expected);
}

void JsonObject::refuse(const char* key, const char* expected) const {
    refuse(name(key), get(key), expected);
}

const json& JsonObject::get(const char* key) const {
    const auto found = value_.find(key);
    if (found == value_.end())
        fail_input("cannot load {} '{}': {} is missing", kind_, file_, name(key));
    return *found;
}

std::string JsonObject::name(const std::string& key) const {
    return place_.empty() ? key : place_ + "." + key;
}

double JsonObject::number(const json& value, const std::string& place, double low, double high,
    const char* expected) const {
    const double found = value.is_number() ? value.get<double>() : NAN;
    if (!(found >= low && found <= high)) refuse(place, value, expected);
    return found;
}

void JsonObject::read_numbers(const char* key, std::span<double> result, double low, double high,
    const char* expected) const {
    const json& list = get(key);
    if (!list.is_array() || list.size() != result.size()) refuse(name(key), list, expected);
    for (std::size_t i = 0; i < result.size(); ++i)
        result[i] = number(list[i], name(key), low, high, expected);
}

void JsonObject::refuse(const std::string& place, const json& found, const char* expected) const {
    const std::string text = found.dump(-1, ' ', true, json::error_handler_t::replace);
    fail_input("cannot load {} '{}': {} is {}, expected {}", kind_, file_, place,
        text.substr(0, 64), expected);
}

bool is_too_deep(std::string_view text) {
    int depth = 0;
    bool in_string = false;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (in_string && c == '\\') {
            ++i;
        } else if (c == '"') {
            in_string = !in_string;
        } else if (!in_string && (c == '{' || c == '[')) {
            if (++depth > kMaxJsonDepth) return true;
        } else if (!in_string && (c == '}' || c == ']')) {
            --depth;
        }
    }
    return false;
}

json parse_json(const std::filesystem::path& path, const std::string& kind) {
    constexpr std::size_t kMaxBytes = std::size_t{64} << 20;
    const std::string text = read_text(path, kMaxBytes);
    if (is_too_deep(text)) {
        fail_input("cannot load {} '{}': its JSON is nested deeper than {} levels", kind,
            path.string(), kMaxJsonDepth);
    }
    try {
        return json::parse(text);
    } catch (const json::exception& error) {
        const std::string reason = error.what();
        fail_input("cannot load {} '{}': not valid JSON: {}", kind, path.string(),
            reason.substr(0, std::min<std::size_t>(reason.find('\n'), 160)));
    }
}

} // namespace ockham
