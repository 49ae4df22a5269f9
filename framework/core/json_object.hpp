// SPDX-License-Identifier: Apache-2.0
// An object of a JSON file that a user wrote, read key by key: what is missing, of another type or
// out of range is refused with the file, the key's place and what was found. For small files that
// configure; plans and glTF have readers of their own.
#pragma once

#include <nlohmann/json.hpp>

#include <array>
#include <cstddef>
#include <filesystem>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace ockham {

/// Refers to the JSON value that it was made of, which must outlive it. All that throw, throw
/// Error(input): "cannot load rig 'a.json': sun.irradiance is -1, expected ...".
class JsonObject {
public:
    /// `kind` is what the file is called in messages ("rig"), `file` its name. Throws unless
    /// `value` is an object.
    JsonObject(const nlohmann::json& value, std::string kind, std::string file);

    /// Logs a warning for each key that is not in `known`.
    void warn_unknown(std::initializer_list<std::string_view> known) const;

    bool has(const char* key) const;
    JsonObject object(const char* key) const;
    std::vector<JsonObject> objects(const char* key) const;
    std::string text(const char* key) const;
    bool boolean(const char* key, bool fallback) const;

    /// A number in [low, high]; `expected` says so in words, for the message.
    double number(const char* key, double low, double high, const char* expected) const;
    /// An array of Count such numbers.
    template <std::size_t Count>
    std::array<double, Count> numbers(
        const char* key, double low, double high, const char* expected) const {
        std::array<double, Count> result;
        read_numbers(key, result, low, high, expected);
        return result;
    }

    /// Throws: what is under `key` is not what is `expected`.
    [[noreturn]] void refuse(const char* key, const char* expected) const;

private:
    JsonObject(const nlohmann::json& value, const JsonObject& parent, std::string place);

    const nlohmann::json& get(const char* key) const;
    std::string name(const std::string& key) const;
    double number(const nlohmann::json& value, const std::string& place, double low, double high,
        const char* expected) const;
    void read_numbers(const char* key, std::span<double> result, double low, double high,
        const char* expected) const;
    [[noreturn]] void refuse(
        const std::string& place, const nlohmann::json& found, const char* expected) const;

    const nlohmann::json& value_;
    std::string kind_, file_;
    std::string place_; ///< in the file: "points[3]"; empty for its root
};

/// Deeper JSON is refused: what walks it calls itself once for each level.
constexpr int kMaxJsonDepth = 128;

/// True if the text nests deeper than kMaxJsonDepth. (The parser could tell in a callback, but
/// takes quadratic time then.)
bool is_too_deep(std::string_view text);

/// Parses a file of at most 64 MiB. Throws Error(input) naming `kind` and the path.
nlohmann::json parse_json(const std::filesystem::path& path, const std::string& kind);

} // namespace ockham
