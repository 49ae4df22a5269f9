// SPDX-License-Identifier: Apache-2.0
// Reads JSON of unknown origin: every value is checked when it is read, and an error names the
// place. For plan_file.cpp and plan_diff.cpp.
#pragma once

#include "framework/core/error.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace ockham {

/// One value and its JSON pointer, "/passes/3/name". `json` must outlive it.
class JsonReader {
public:
    /// `code` is what error texts start with, in brackets.
    JsonReader(const nlohmann::json& json, const char* code, std::string path = "")
        : json_(&json), code_(code), path_(std::move(path)) {}

    template <class... Args>
    [[noreturn]] void fail(fmt::format_string<Args...> text, Args&&... args) const {
        fail_input("[{}] {}: {}", code_, path_.empty() ? "the whole" : path_,
            fmt::format(text, std::forward<Args>(args)...));
    }

    bool has(const char* key) const { return object().contains(key); }
    JsonReader operator[](const char* key) const {
        const auto found = object().find(key);
        if (found == json_->end()) fail("has no '{}'", key);
        return {*found, code_, path_ + "/" + key};
    }
    std::vector<JsonReader> items() const {
        if (!json_->is_array()) fail("found {}, expected an array", json_->type_name());
        std::vector<JsonReader> all;
        all.reserve(json_->size());
        for (const nlohmann::json& item : *json_)
            all.emplace_back(item, code_, fmt::format("{}/{}", path_, all.size()));
        return all;
    }
    const std::string& text() const {
        if (!json_->is_string()) fail("found {}, expected a string", json_->type_name());
        return json_->get_ref<const std::string&>();
    }
    bool yes() const {
        if (!json_->is_boolean()) fail("found {}, expected true or false", json_->type_name());
        return json_->get<bool>();
    }
    /// An integer from `least` to `most`.
    std::uint64_t number(std::uint64_t least = 0,
        std::uint64_t most = std::numeric_limits<std::uint64_t>::max()) const {
        const bool whole =
            json_->is_number_unsigned() || (json_->is_number_integer() && *json_ >= 0);
        if (!whole || json_->get<std::uint64_t>() < least || json_->get<std::uint64_t>() > most)
            fail("found {}, expected an integer from {} to {}", shown(), least, most);
        return json_->get<std::uint64_t>();
    }
    /// An index into a list of `size` elements.
    std::uint32_t index(std::size_t size) const {
        if (size == 0) fail("found {}, but there is nothing to refer to", shown());
        return static_cast<std::uint32_t>(number(0, size - 1));
    }
    /// A number, or one of the words "inf", "-inf" and "nan".
    double real() const {
        constexpr double infinity = std::numeric_limits<double>::infinity();
        if (json_->is_number()) return json_->get<double>();
        if (*json_ == "inf") return infinity;
        if (*json_ == "-inf") return -infinity;
        if (*json_ == "nan") return std::numeric_limits<double>::quiet_NaN();
        fail("found {}, expected a number", shown());
    }
    /// The enumerator whose place in `words` the text has.
    template <class Enum, class Words>
    Enum one_of(const Words& words) const {
        const auto found = std::find(words.begin(), words.end(), text());
        if (found == words.end())
            fail("found '{}', expected one of {}", text(), fmt::join(words, ", "));
        return static_cast<Enum>(found - words.begin());
    }

private:
    const nlohmann::json& object() const {
        if (!json_->is_object()) fail("found {}, expected an object", json_->type_name());
        return *json_;
    }
    std::string shown() const {
        return json_->is_primitive()
                   ? json_->dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)
                   : std::string(json_->type_name());
    }

    const nlohmann::json* json_;
    const char* code_;
    std::string path_;
};

} // namespace ockham
