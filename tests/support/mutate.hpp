// SPDX-License-Identifier: Apache-2.0
// Makes bad files out of good ones: cut off, flipped, with huge counts, paths that leave the
// folder, numbers that are none, deep nesting. The same seed gives the same files. Knows no format
// but JSON.
#pragma once

#include "framework/core/rng.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace ockham::test {

class Mutator {
public:
    explicit Mutator(std::uint64_t seed) : rng_(seed, 0x6d757461) {}

    /// One to four changes of `good`; with one in three of JSON a value is replaced by a wrong one.
    std::string change(const std::string& good) {
        std::string bytes = good;
        if (good.starts_with('{') && below(3) == 0) bytes = change_json(good);
        for (std::uint32_t i = 0, count = 1 + below(4); i < count; ++i) change_bytes(bytes);
        return bytes;
    }

    /// Every value of JSON in turn is replaced by each of several wrong ones, or taken away.
    static std::vector<std::string> all_of_json(const std::string& good) {
        const nlohmann::json root = nlohmann::json::parse(good);
        std::vector<std::string> result;
        for (const nlohmann::json::json_pointer& place : places(root)) {
            for (const nlohmann::json& value : wrong_values()) {
                nlohmann::json bad = root;
                bad[place] = value;
                result.push_back(bad.dump());
            }
            nlohmann::json bad = root;
            nlohmann::json& parent = bad[place.parent_pointer()];
            if (parent.is_array())
                parent.erase(std::stoul(place.back()));
            else
                parent.erase(place.back());
            result.push_back(bad.dump());
        }
        return result;
    }

private:
    std::uint32_t below(std::size_t count) { return rng_.below(static_cast<std::uint32_t>(count)); }

    static const std::vector<nlohmann::json>& wrong_values() {
        static const std::vector<nlohmann::json> kValues{nullptr, true, -1, 0, 1, 3, 255,
            2147483648, 4294967295, 9007199254740992, -9007199254740992, 0.5, 1e300, "",
            "../../etc/passwd", "/dev/zero", nlohmann::json::array(), nlohmann::json::object(),
            nlohmann::json::array({0, 0, 0}), nlohmann::json::array({nlohmann::json::object()})};
        return kValues;
    }

    static std::vector<nlohmann::json::json_pointer> places(const nlohmann::json& root) {
        std::vector<nlohmann::json::json_pointer> result;
        const nlohmann::json flat = root.flatten();
        for (const auto& [pointer, value] : flat.items()) {
            for (nlohmann::json::json_pointer at(pointer); !at.empty(); at.pop_back()) {
                if (std::find(result.begin(), result.end(), at) == result.end())
                    result.push_back(at);
            }
        }
        return result;
    }

    std::string change_json(const std::string& good) {
        nlohmann::json root = nlohmann::json::parse(good, nullptr, false);
        if (root.is_discarded()) return good;
        const auto all = places(root);
        if (!all.empty())
            root[all[below(all.size())]] = wrong_values()[below(wrong_values().size())];
        return root.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
    }

    void change_bytes(std::string& bytes) {
        if (bytes.empty()) {
            bytes = "x";
            return;
        }
        const std::size_t at = below(bytes.size());
        const std::size_t length = std::min<std::size_t>(1 + below(16), bytes.size() - at);
        switch (below(12)) {
        case 0: // cut off
            bytes.resize(at);
            break;
        case 1: // flip a bit
            bytes[at] = static_cast<char>(bytes[at] ^ 1 << below(8));
            break;
        case 2: // any byte
            bytes[at] = static_cast<char>(below(256));
            break;
        case 3: // take away
            bytes.erase(at, length);
            break;
        case 4: // twice
            bytes.insert(at, bytes.substr(at, length));
            break;
        case 5: // from elsewhere
            bytes.replace(at, length, bytes.substr(below(bytes.size()), length));
            break;
        case 6:
        case 7:
            write_binary_number(bytes, at);
            break;
        case 8:
        case 9:
            write_text_number(bytes, at);
            break;
        case 10:
            write_name(bytes, at);
            break;
        default: // nested
            bytes.insert(at, std::string(1 + below(100000), "[{("[below(3)]));
        }
    }

    /// Counts and offsets: huge, zero, negative, not finite, in either byte order.
    void write_binary_number(std::string& bytes, std::size_t at) {
        constexpr std::array<std::uint64_t, 14> kNumbers{0, 1, 0x7F, 0xFF, 0x7FFF, 0xFFFF,
            0x7FFFFFFF, 0x80000000, 0xFFFFFFFF, 0x7F800000, 0x7FC00000, 0x7FFFFFFFFFFFFFFF,
            0x8000000000000000, ~std::uint64_t{0}};
        const std::uint64_t number = kNumbers[below(kNumbers.size())];
        const std::size_t size = std::size_t{1} << below(4);
        const bool big = below(2) == 0;
        for (std::size_t i = 0; i < size && at + i < bytes.size(); ++i) {
            bytes[at + i] = static_cast<char>(number >> 8 * (big ? size - 1 - i : i));
        }
    }

    /// The next number that is written out.
    void write_text_number(std::string& bytes, std::size_t at) {
        constexpr std::array<std::string_view, 16> kNumbers{"0", "-1", "1", "nan", "inf", "-inf",
            "1e308", "1e-320", "1e999", "2147483647", "2147483648", "4294967296",
            "-9223372036854775808", "18446744073709551616", "99999999999999999999",
            "0.000000000001"};
        const std::size_t begin = bytes.find_first_of("0123456789", at);
        if (begin == std::string::npos) return;
        const std::size_t end =
            std::min(bytes.find_first_not_of("0123456789", begin), bytes.size());
        bytes.replace(begin, end - begin, kNumbers[below(kNumbers.size())]);
    }

    /// The next word, which may be the name of a file.
    void write_name(std::string& bytes, std::size_t at) {
        constexpr std::array<std::string_view, 8> kNames{"../../../etc/passwd", "/dev/zero",
            "/etc/passwd", "..", ".", "%2e%2e%2fsecret", "file:///etc/passwd", "a/../../b"};
        constexpr const char* kLetters = "abcdefghijklmnopqrstuvwxyz./_";
        const std::size_t begin = bytes.find_first_of(kLetters, at);
        if (begin == std::string::npos) return;
        const std::size_t end = std::min(bytes.find_first_not_of(kLetters, begin), bytes.size());
        bytes.replace(begin, end - begin, kNames[below(kNames.size())]);
    }

    Pcg32 rng_;
};

} // namespace ockham::test
