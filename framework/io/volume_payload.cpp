// SPDX-License-Identifier: Apache-2.0
#include "framework/io/volume_payload.hpp"

#include "framework/core/file.hpp"
#include "framework/io/gzip.hpp"
#include "framework/io/volume_readers.hpp"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <map>
#include <span>
#include <string_view>

namespace ockham {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kNiftiHeader = 348;

[[noreturn]] void fail_short(
    const fs::path& path, const StatedVoxels& stated, std::uint64_t needed, std::uint64_t found) {
    fail_input("cannot load volume '{}': {} take {} bytes, but {} are there; it is damaged or cut "
               "off",
        path.string(), stated.text, needed, found);
}

/// Unpacks to see whether it works, and at least `needed` bytes come out.
void check_packed(const fs::path& path, const StatedVoxels& stated,
    std::span<const std::byte> packed, std::uint64_t needed) {
    if (needed / kMaxDeflateRatio > packed.size()) {
        fail_short(path, stated, needed, packed.size() * kMaxDeflateRatio);
    }
    std::uint64_t found = 0;
    try {
        found = inflated_size(packed, std::max(needed, 2 * stated.bytes + (1u << 20)));
    } catch (const Error& error) {
        fail_input("cannot load volume '{}': {}", path.string(), error.what());
    }
    if (found < needed) fail_short(path, stated, needed, found);
}

// ---- NRRD and MetaImage: lines of text, then voxels, or the names of files that have them.

struct TextHeader {
    std::map<std::string, std::string, std::less<>> values; ///< keys in lower case
    std::vector<std::string> rest;                          ///< lines after the last key
    std::uint64_t bytes = 0;                                ///< before the voxels

    std::string value(std::string_view key) const {
        const auto found = values.find(key);
        return found == values.end() ? "" : found->second;
    }
};

std::string trimmed(std::string text) {
    text.erase(0, std::min(text.find_first_not_of(" \t"), text.size()));
    text.erase(text.find_last_not_of(" \t\r") + 1);
    return text;
}

std::string lower(std::string text) {
    std::ranges::transform(text, text.begin(),
        [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
    return text;
}

bool is_list(const std::string& name) {
    return lower(name) == "list" || lower(name).starts_with("list ");
}

enum class Kind { nrrd, meta, nifti };

Kind kind_of(const fs::path& path) {
    const std::string extension = lower(path.extension().string());
    if (extension == ".mha" || extension == ".mhd") return Kind::meta;
    return extension == ".nrrd" || extension == ".nhdr" ? Kind::nrrd : Kind::nifti;
}

/// What makes the libraries write beyond their buffers, or count for minutes.
void refuse_dangerous_line(const fs::path& path, const std::string& line, bool is_meta) {
    constexpr std::size_t kMaxLine = 512;
    if (!is_meta && line.size() > kMaxLine && !line.starts_with('#')) {
        fail_input("cannot load volume '{}': its header has a line of {} characters, at most {} "
                   "are accepted",
            path.string(), line.size(), kMaxLine);
    }
    const std::size_t mark = line.find('=');
    if (!is_meta || lower(trimmed(line.substr(0, mark))) != "ndims") return;
    const std::string count = trimmed(line.substr(std::min(mark, line.size() - 1) + 1));
    if (count.size() == 1 && count[0] >= '1' && count[0] <= '9') return;
    fail_input("cannot load volume '{}': NDims is '{}', expected 1 to 9", path.string(),
        count.substr(0, 64));
}

TextHeader read_header(const fs::path& path, bool is_meta) {
    constexpr std::uint64_t kMaxHeader = std::uint64_t{1} << 20;
    std::ifstream stream(path, std::ios::binary);
    TextHeader header;
    std::string line;
    bool ended = false;
    while (header.bytes < kMaxHeader && std::getline(stream, line)) {
        header.bytes += line.size() + 1;
        line = trimmed(line);
        refuse_dangerous_line(path, line, is_meta);
        if (ended) {
            header.rest.push_back(line);
            continue;
        }
        if (line.empty() && !is_meta) break;
        const std::size_t mark = line.find(is_meta ? '=' : ':');
        if (line.starts_with('#') || mark == std::string::npos) continue;
        const std::string key = lower(trimmed(line.substr(0, mark)));
        header.values[key] = trimmed(line.substr(mark + 1));
        const bool is_data = key == "elementdatafile" || key == "data file" || key == "datafile";
        if (!is_data) continue;
        ended = is_list(header.values[key]);
        if (is_meta && !ended) break; // the last key
    }
    return header;
}

/// Files that hold the voxels; none if they follow the header.
std::vector<fs::path> data_files(const fs::path& path, const TextHeader& header) {
    std::string name;
    for (const char* key : {"elementdatafile", "data file", "datafile"}) {
        if (name.empty()) name = header.value(key);
    }
    if (name.empty() || lower(name) == "local") return {};
    std::vector<fs::path> files;
    if (!is_list(name)) files.push_back(path_beside(path, name));
    for (const std::string& line : header.rest) {
        if (!line.empty()) files.push_back(path_beside(path, line));
    }
    std::error_code ignored;
    for (const fs::path& file : files) {
        if (!fs::exists(file, ignored) || fs::is_regular_file(file, ignored)) continue;
        fail_input("cannot load volume '{}': '{}', which it names, is no file", path.string(),
            file.filename().string());
    }
    return files;
}

void check_text(const fs::path& path, const StatedVoxels& stated, bool is_meta,
    std::vector<std::string>& notes) {
    const TextHeader header = read_header(path, is_meta);
    if (header.value(is_meta ? "elementspacing" : "spacings").empty() &&
        header.value(is_meta ? "elementsize" : "space directions").empty()) {
        notes.push_back("it states no spacing: 1 mm along each axis is taken");
    }
    const std::vector<fs::path> files = data_files(path, header);
    std::error_code error;
    std::uint64_t stored = 0;
    for (const fs::path& file : files) stored += fs::file_size(file, error);
    if (error) return; // missing, or a pattern of names: the reader finds out
    if (files.empty()) {
        const std::uint64_t whole = fs::file_size(path, error);
        stored = whole - std::min(whole, header.bytes);
    }
    const std::string encoding = lower(header.value("encoding"));
    const bool is_text = is_meta ? lower(header.value("binarydata")) == "false"
                                 : encoding == "text" || encoding == "txt" || encoding == "ascii";
    const bool packed = is_meta ? lower(header.value("compresseddata")) == "true"
                                : encoding == "gz" || encoding == "gzip";
    const bool raw = is_meta ? !packed && !is_text : encoding == "raw";
    // Of text, each voxel takes a digit at least; of what is packed, ITK checks all but MetaImage.
    if (is_text && stored < stated.count) fail_short(path, stated, stated.count, stored);
    if (raw && stored < stated.bytes) fail_short(path, stated, stated.bytes, stored);
    if (packed && stored < stated.bytes / kMaxDeflateRatio) {
        fail_short(path, stated, stated.bytes, stored * kMaxDeflateRatio);
    }
    // What is skipped before the voxels (NRRD, section 5) may be anywhere: then ITK finds out
    // alone.
    const bool skips = !header.value("line skip").empty() || !header.value("byte skip").empty();
    if (!packed || skips || files.size() > 1) return;
    const std::vector<std::byte> bytes = read_file(files.empty() ? path : files[0]);
    const auto data = std::span(bytes).last(std::min<std::uint64_t>(stored, bytes.size()));
    std::uint64_t size = data.size();
    if (is_meta) {
        const std::string text = header.value("compresseddatasize");
        if (text.empty()) { // without it MetaIO unpacks from the start of the file, and reads zeros
            fail_input("cannot load volume '{}': its voxels are compressed, but CompressedDataSize "
                       "is missing; write it anew with that",
                path.string());
        }
        size = std::strtoull(text.c_str(), nullptr, 10);
    }
    if (size > data.size()) fail_short(path, stated, size, data.size());
    check_packed(path, stated, data.first(size), stated.bytes);
}

// ---- NIfTI-1 and 2: a binary header, in either byte order.

template <class T>
T value_at(std::span<const std::byte> bytes, std::size_t at, bool swapped) {
    std::byte raw[sizeof(T)];
    std::memcpy(raw, bytes.data() + at, sizeof(T));
    if (swapped) std::ranges::reverse(raw);
    T value;
    std::memcpy(&value, raw, sizeof(T));
    return value;
}

/// Bytes of the unpacked file, from its header; at least those of a header.
std::uint64_t nifti_size(std::span<const std::byte> head, std::uint64_t count) {
    for (const bool swapped : {false, true}) {
        if (head.size() < kNiftiHeader) break;
        const auto size = value_at<std::int32_t>(head, 0, swapped);
        if (size != 348 && size != 540) continue;
        if (head.size() < static_cast<std::size_t>(size)) break;
        const double offset = size == 348
                                  ? static_cast<double>(value_at<float>(head, 108, swapped))
                                  : static_cast<double>(value_at<std::int64_t>(head, 168, swapped));
        const auto bits = value_at<std::int16_t>(head, size == 348 ? 72 : 14, swapped);
        if (!(offset >= 0 && offset < 0x1p40) || bits < 0) break;
        return static_cast<std::uint64_t>(offset) + count * static_cast<std::uint64_t>(bits) / 8;
    }
    return kNiftiHeader; // if it is no header, the reader says so
}

void check_nifti(const fs::path& path, const StatedVoxels& stated) {
    const std::vector<std::byte> bytes = read_file(path, std::size_t{1} << 34);
    if (lower(path.extension().string()) != ".gz") {
        const std::uint64_t needed = nifti_size(bytes, stated.count);
        if (bytes.size() < needed) fail_short(path, stated, needed, bytes.size());
        return;
    }
    std::vector<std::byte> head(540);
    try {
        head.resize(std::min<std::uint64_t>(inflate(bytes, head), head.size()));
    } catch (const Error& error) {
        fail_input("cannot load volume '{}': {}", path.string(), error.what());
    }
    check_packed(path, stated, bytes, nifti_size(head, stated.count));
}

} // namespace

void check_references(const fs::path& path) {
    if (const Kind kind = kind_of(path); kind != Kind::nifti) {
        data_files(path, read_header(path, kind == Kind::meta));
    }
}

void check_payload(
    const fs::path& path, const StatedVoxels& stated, std::vector<std::string>& notes) {
    const Kind kind = kind_of(path);
    if (kind == Kind::nifti) {
        check_nifti(path, stated);
    } else {
        check_text(path, stated, kind == Kind::meta, notes);
    }
}

} // namespace ockham
