// SPDX-License-Identifier: Apache-2.0
#include "framework/app/checkpoint.hpp"

#include "framework/core/error.hpp"
#include "framework/core/file.hpp"
#include "framework/core/json_object.hpp"
#include "framework/graph/fingerprint.hpp"

#include <cstring>
#include <string>
#include <string_view>

namespace ockham {
namespace {

using nlohmann::ordered_json;

// The file: this line, the length of the header, the header as JSON, the bytes of the resources.
constexpr std::string_view kMagic = "Ockham checkpoint 1\n";

std::string checksum(std::span<const std::byte> bytes) {
    Fingerprint print;
    print.mix(std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
    return fmt::format("{:016x}{:016x}", print.high, print.low);
}

void append(std::vector<std::byte>& file, std::span<const std::byte> bytes) {
    file.insert(file.end(), bytes.begin(), bytes.end());
}

[[noreturn]] void refuse(const std::filesystem::path& path, const std::string& found) {
    fail_input("cannot resume '{}': {}", path.string(), found);
}

std::string value_text(const ordered_json& json, const std::string& key) {
    return json.contains(key) ? json[key].dump() : "nothing";
}

/// "albedo is 0.9 there and 1 here; seed ..." of the first few keys that differ.
std::string difference(const ordered_json& there, const ordered_json& here) {
    std::string text;
    int count = 0;
    const auto add = [&](const std::string& key) {
        if (count++ < 3) {
            text += fmt::format("{}{} is {} there and {} here", text.empty() ? "" : ", ", key,
                value_text(there, key), value_text(here, key));
        }
    };
    for (const auto& [key, value] : there.items())
        if (!here.contains(key) || here[key] != value) add(key);
    for (const auto& [key, value] : here.items())
        if (!there.contains(key)) add(key);
    if (count > 3) text += fmt::format(", and {} more", count - 3);
    return text;
}

} // namespace

void save_checkpoint(const std::filesystem::path& path, const Checkpoint& checkpoint) {
    std::size_t bytes = 0;
    ordered_json list = ordered_json::array();
    for (const SavedResource& resource : checkpoint.resources) {
        list.push_back({{"name", resource.name}, {"bytes", resource.bytes.size()},
            {"checksum", checksum(resource.bytes)}});
        bytes += resource.bytes.size();
    }
    const std::string header = ordered_json{{"identity", checkpoint.identity},
        {"progress", checkpoint.progress},
        {"resources", list}}.dump();
    const std::uint64_t length = header.size();
    std::vector<std::byte> file;
    file.reserve(kMagic.size() + sizeof(length) + header.size() + bytes);
    append(file, std::as_bytes(std::span(kMagic)));
    append(file, std::as_bytes(std::span(&length, 1)));
    append(file, std::as_bytes(std::span(header)));
    for (const SavedResource& resource : checkpoint.resources) append(file, resource.bytes);
    write_file(path, file);
}

Checkpoint load_checkpoint(const std::filesystem::path& path, const ordered_json& identity) {
    const std::vector<std::byte> file = read_file(path);
    std::span<const std::byte> rest = file;
    const auto take = [&](std::uint64_t bytes) {
        if (bytes > rest.size()) refuse(path, "it is cut off");
        const std::span<const std::byte> part = rest.first(bytes);
        rest = rest.subspan(bytes);
        return part;
    };
    const std::size_t magic = std::min(rest.size(), kMagic.size());
    if (magic == 0 || std::memcmp(take(magic).data(), kMagic.data(), magic) != 0)
        refuse(path, "it is no checkpoint of this version");
    std::uint64_t length = 0;
    std::memcpy(&length, take(sizeof(length)).data(), sizeof(length));
    const std::span<const std::byte> text = take(length);
    const auto* first = reinterpret_cast<const char*>(text.data());
    if (is_too_deep({first, text.size()})) refuse(path, "its header is damaged");
    const ordered_json header = ordered_json::parse(first, first + text.size(), nullptr, false);
    Checkpoint checkpoint;
    try {
        checkpoint.identity = header.at("identity");
        const std::string differs = difference(checkpoint.identity, identity);
        if (!differs.empty()) refuse(path, "it was written by another run: " + differs);
        checkpoint.progress = header.at("progress");
        for (const ordered_json& resource : header.at("resources")) {
            const std::span<const std::byte> bytes = take(resource.at("bytes"));
            if (checksum(bytes) != resource.at("checksum").get<std::string>())
                refuse(path, "its bytes are not those that were written");
            checkpoint.resources.push_back(
                {resource.at("name"), std::vector(bytes.begin(), bytes.end())});
        }
    } catch (const nlohmann::json::exception&) {
        refuse(path, "its header is damaged");
    }
    if (!rest.empty()) refuse(path, "it is longer than it says");
    return checkpoint;
}

} // namespace ockham
