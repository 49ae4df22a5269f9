// SPDX-License-Identifier: Apache-2.0
// The bytes of small volumes in each format, written here and not by the libraries that read them.
#pragma once

#include <fmt/format.h>
#include <zlib.h>

#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <map>
#include <string>
#include <string_view>
#include <utility>

namespace ockham::test {

/// The bytes of `count` values first, first + 1, ...
template <class T>
std::string ramp(std::size_t count, T first) {
    std::string bytes(count * sizeof(T), '\0');
    for (std::size_t i = 0; i < count; ++i) {
        const T value = static_cast<T>(first + static_cast<T>(i));
        std::memcpy(bytes.data() + i * sizeof(T), &value, sizeof(T));
    }
    return bytes;
}

/// A gzip stream, or with `bits` of 15 a zlib stream.
inline std::string gzip(std::string_view bytes, int bits = 15 + 16) {
    std::string packed(bytes.size() + 100, '\0');
    z_stream stream{};
    deflateInit2(&stream, 9, Z_DEFLATED, bits, 8, Z_DEFAULT_STRATEGY);
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
    stream.avail_in = static_cast<uInt>(bytes.size());
    stream.next_out = reinterpret_cast<Bytef*>(packed.data());
    stream.avail_out = static_cast<uInt>(packed.size());
    deflate(&stream, Z_FINISH);
    packed.resize(stream.total_out);
    deflateEnd(&stream);
    return packed;
}

/// 24 voxels of int16, -5 upwards.
inline const std::string kVoxels = ramp<std::int16_t>(24, -5);

using Fields = std::map<std::string, std::string>;

inline std::string nrrd(Fields change = {}, const std::string& voxels = kVoxels) {
    Fields fields{{"type", "short"}, {"dimension", "3"}, {"space", "left-posterior-superior"},
        {"sizes", "2 3 4"}, {"space directions", "(0,0.5,0) (-1,0,0) (0,0,2.25)"},
        {"space origin", "(10,-20,0.125)"}, {"endian", "little"}, {"encoding", "raw"}};
    change.merge(fields);
    // "dimension" must come before what it counts.
    std::string text = "NRRD0004\ndimension: " + change["dimension"] + "\n";
    for (const char* early : {"type", "space"}) {
        if (!change[early].empty()) text += fmt::format("{}: {}\n", early, change[early]);
        change.erase(early);
    }
    change.erase("dimension");
    for (const auto& [key, value] : change) {
        if (!value.empty()) text += key + ": " + value + "\n";
    }
    return text + "\n" + voxels;
}

inline std::string meta(const Fields& change = {}, const std::string& voxels = kVoxels) {
    const std::pair<const char*, const char*> fields[] = {{"ObjectType", "Image"}, {"NDims", "3"},
        {"BinaryData", "True"}, {"BinaryDataByteOrderMSB", "False"}, {"CompressedData", "False"},
        {"CompressedDataSize", ""}, {"TransformMatrix", "0 1 0 -1 0 0 0 0 1"},
        {"Offset", "10 -20 0.125"}, {"ElementSpacing", "0.5 1 2.25"}, {"DimSize", "2 3 4"},
        {"ElementNumberOfChannels", "1"}, {"ElementType", "MET_SHORT"},
        {"ElementDataFile", "LOCAL"}};
    std::string text;
    for (const auto& [key, usual] : fields) {
        const auto changed = change.find(key);
        const std::string value = changed == change.end() ? usual : changed->second;
        if (!value.empty()) text += fmt::format("{} = {}\n", key, value);
    }
    return text + voxels;
}

template <class T>
void put(std::string& bytes, std::size_t at, std::initializer_list<T> values) {
    for (const T value : values) {
        std::memcpy(bytes.data() + at, &value, sizeof(T));
        at += sizeof(T);
    }
}

/// NIfTI-1: its world is right, anterior, superior; ours left, posterior, superior.
inline std::string nifti(float slope = 0, float intercept = 0) {
    std::string bytes(352, '\0');
    put<std::int32_t>(bytes, 0, {348});
    put<std::int16_t>(bytes, 40, {3, 2, 3, 4, 1, 1, 1, 1});
    put<std::int16_t>(bytes, 70, {4, 16}); // int16
    put<float>(bytes, 76, {1, 0.5f, 1, 2.25f, 1, 1, 1, 1});
    put<float>(bytes, 108, {352, slope, intercept});
    bytes[123] = 2;                     // mm
    put<std::int16_t>(bytes, 254, {1}); // the rows of the matrix count
    put<float>(bytes, 280, {0, 1, 0, -10});
    put<float>(bytes, 296, {-0.5f, 0, 0, 20});
    put<float>(bytes, 312, {0, 0, 2.25f, 0.125f});
    std::memcpy(bytes.data() + 344, "n+1", 4);
    return bytes + kVoxels;
}

// ---- DICOM

/// Explicit little endian (PS3.5, 7.1.2).
class Dicom {
public:
    Dicom& add(unsigned group, unsigned element, const char* type, std::string value) {
        if (value.size() % 2)
            value += type == std::string("UI") || type == std::string("OW") ? '\0' : ' ';
        put16(group);
        put16(element);
        bytes_ += type;
        if (type == std::string("OW") || type == std::string("OB")) {
            put16(0);
            put16(value.size() & 0xFFFF);
            put16(value.size() >> 16);
        } else {
            put16(value.size());
        }
        bytes_ += value;
        return *this;
    }
    Dicom& add(unsigned group, unsigned element, unsigned value) {
        return add(group, element, "US", ramp<std::uint16_t>(1, static_cast<std::uint16_t>(value)));
    }
    const std::string& bytes() const { return bytes_; }

private:
    void put16(std::size_t value) {
        bytes_ += static_cast<char>(value & 0xFF);
        bytes_ += static_cast<char>(value >> 8 & 0xFF);
    }
    std::string bytes_;
};

struct DicomSlice {
    std::string series = "1.2.3.1";
    int number = 1;
    std::string position = "0\\0\\0", orientation = "1\\0\\0\\0\\1\\0";
    unsigned columns = 4, rows = 3;
    double slope = 1, intercept = -1024;
    std::uint16_t first = 100;
    unsigned colours = 1;
};

inline std::string dicom(const DicomSlice& slice) {
    const char* ct = "1.2.840.10008.5.1.4.1.1.2";
    const std::string uid = fmt::format("{}.{}", slice.series, slice.number);
    Dicom meta;
    meta.add(2, 1, "OB", std::string("\0\1", 2)).add(2, 2, "UI", ct).add(2, 3, "UI", uid);
    meta.add(2, 0x10, "UI", "1.2.840.10008.1.2.1").add(2, 0x12, "UI", "1.2.3");
    Dicom file;
    file.add(2, 0, "UL", ramp<std::uint32_t>(1, static_cast<std::uint32_t>(meta.bytes().size())));
    const std::string head = std::string(128, '\0') + "DICM" + file.bytes() + meta.bytes();
    Dicom body;
    body.add(8, 0x16, "UI", ct).add(8, 0x18, "UI", uid).add(8, 0x60, "CS", "CT");
    body.add(0x18, 0x50, "DS", "2.5");
    body.add(0x20, 0x0D, "UI", "1.2.3").add(0x20, 0x0E, "UI", slice.series);
    body.add(0x20, 0x13, "IS", fmt::to_string(slice.number));
    body.add(0x20, 0x32, "DS", slice.position).add(0x20, 0x37, "DS", slice.orientation);
    body.add(0x20, 0x52, "UI", "1.2.3.9");
    body.add(0x28, 2, slice.colours).add(0x28, 4, "CS", slice.colours == 3 ? "RGB" : "MONOCHROME2");
    if (slice.colours == 3) body.add(0x28, 6, 0u);
    body.add(0x28, 0x10, slice.rows).add(0x28, 0x11, slice.columns);
    body.add(0x28, 0x30, "DS", "0.75\\0.5"); // between rows, between columns
    const unsigned bits = slice.colours == 3 ? 8 : 16;
    body.add(0x28, 0x100, bits).add(0x28, 0x101, bits == 16 ? 12u : 8u);
    body.add(0x28, 0x102, bits == 16 ? 11u : 7u).add(0x28, 0x103, 0u);
    if (slice.colours == 1) {
        body.add(0x28, 0x1052, "DS", fmt::to_string(slice.intercept));
        body.add(0x28, 0x1053, "DS", fmt::to_string(slice.slope));
    }
    const std::size_t pixels = slice.columns * slice.rows;
    body.add(0x7FE0, 0x10, "OW",
        slice.colours == 3 ? std::string(3 * pixels, 'x')
                           : ramp<std::uint16_t>(pixels, slice.first));
    return head + body.bytes();
}

} // namespace ockham::test
