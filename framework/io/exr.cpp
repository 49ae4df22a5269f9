// SPDX-License-Identifier: Apache-2.0
#include "framework/io/exr.hpp"

#include "framework/core/error.hpp"
#include "framework/core/file.hpp"
#include "framework/core/log.hpp"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfCompression.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <OpenEXR/ImfTileDescriptionAttribute.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <new>
#include <set>
#include <stdexcept>

namespace ockham {
namespace {

constexpr std::int64_t kMaxValues = std::int64_t{1} << 28;
constexpr float kMaxHalf = 65504.0f;

/// A file in memory that the library writes; core/file then puts it on the disk.
class MemoryWriter : public Imf::OStream {
public:
    MemoryWriter() : OStream("memory") {}
    void write(const char data[], int count) override {
        const std::size_t end = position_ + static_cast<std::size_t>(count);
        if (end > bytes.size()) bytes.resize(end);
        std::memcpy(bytes.data() + position_, data, static_cast<std::size_t>(count));
        position_ = end;
    }
    std::uint64_t tellp() override { return position_; }
    void seekp(std::uint64_t position) override { position_ = position; }

    std::vector<std::byte> bytes;

private:
    std::size_t position_ = 0;
};

/// A file in memory that the library reads.
class MemoryReader : public Imf::IStream {
public:
    explicit MemoryReader(std::span<const std::byte> bytes) : IStream("memory"), bytes_(bytes) {}
    bool read(char data[], int count) override {
        const auto wanted = static_cast<std::uint64_t>(count);
        if (position_ > bytes_.size() || wanted > bytes_.size() - position_) {
            throw std::runtime_error("the file ends too early");
        }
        std::memcpy(data, bytes_.data() + position_, wanted);
        position_ += wanted;
        return position_ < bytes_.size();
    }
    std::uint64_t tellg() override { return position_; }
    void seekg(std::uint64_t position) override { position_ = position; }

private:
    std::span<const std::byte> bytes_;
    std::uint64_t position_ = 0;
};

/// String attributes that describe the file itself and must not travel from one to the next.
bool is_structural(const std::string& key) {
    static const std::set<std::string, std::less<>> kNames{"type", "name", "view"};
    return kNames.contains(key);
}

Imf::Header make_header(const Image& image, Imf::PixelType type) {
    Imf::Header header(image.width(), image.height());
    header.compression() = Imf::ZIP_COMPRESSION;
    for (const auto& [key, text] : image.metadata) {
        if (key.empty() || is_structural(key) || header.find(key.c_str()) != header.end()) {
            throw std::runtime_error(fmt::format("the metadata key '{}' is reserved", key));
        }
        header.insert(key, Imf::StringAttribute(text));
    }
    for (const std::string& name : image.channels()) {
        header.channels().insert(name, Imf::Channel(type));
    }
    return header;
}

std::vector<Imath::half> to_half(std::span<const float> values, std::size_t& clamped) {
    std::vector<Imath::half> halves(values.size());
    std::transform(values.begin(), values.end(), halves.begin(), [&](float value) {
        const bool too_large = std::isfinite(value) && std::abs(value) > kMaxHalf;
        clamped += too_large;
        return Imath::half(too_large ? std::copysign(kMaxHalf, value) : value);
    });
    return halves;
}

std::vector<std::byte> encode(const Image& image, bool half, std::size_t& clamped) {
    const auto width = static_cast<std::size_t>(image.width());
    std::vector<std::vector<Imath::half>> halves; // must outlive the frame buffer
    Imf::FrameBuffer frame;
    for (int c = 0; c < static_cast<int>(image.channels().size()); ++c) {
        const std::span<const float> plane = image.plane(c);
        if (half) halves.push_back(to_half(plane, clamped));
        // The library reads through this pointer, although its type allows it to write.
        const void* values = half ? static_cast<const void*>(halves.back().data()) : plane.data();
        const std::size_t size = half ? sizeof(Imath::half) : sizeof(float);
        frame.insert(image.channels()[static_cast<std::size_t>(c)],
            Imf::Slice(half ? Imf::HALF : Imf::FLOAT, static_cast<char*>(const_cast<void*>(values)),
                size, size * width));
    }
    MemoryWriter writer;
    {
        Imf::OutputFile file(writer, make_header(image, half ? Imf::HALF : Imf::FLOAT));
        file.setFrameBuffer(frame);
        file.writePixels(image.height());
    }
    return std::move(writer.bytes);
}

struct Window {
    int width = 0, height = 0;
};

/// Sizes in 64 bits, because those of a damaged header overflow an int.
Window checked_window(const Imf::Header& header, std::int64_t channels) {
    const Imath::Box2i box = header.dataWindow();
    const std::int64_t width = std::int64_t{box.max.x} - box.min.x + 1;
    const std::int64_t height = std::int64_t{box.max.y} - box.min.y + 1;
    const auto too_large = [&](std::int64_t w, std::int64_t h) {
        return w < 1 || h < 1 || w > kMaxValues || h > kMaxValues || w * h > kMaxValues / channels;
    };
    if (too_large(width, height)) {
        throw std::runtime_error(fmt::format("its data window has {} x {} pixels of {} channels, "
                                             "the limit is {} values",
            width, height, channels, kMaxValues));
    }
    if (header.hasTileDescription()) {
        const Imf::TileDescription& tile = header.tileDescription();
        if (too_large(tile.xSize, tile.ySize)) {
            throw std::runtime_error(fmt::format("its tiles have {} x {} pixels of {} channels, "
                                                 "the limit is {} values",
                tile.xSize, tile.ySize, channels, kMaxValues));
        }
    }
    return {static_cast<int>(width), static_cast<int>(height)};
}

/// Values that a byte of the file may unpack to at most, of at least two bytes each. Deflate has the
/// ratio 1032; of the other methods that pack long runs this is a generous guess.
std::uint64_t most_values_per_byte(Imf::Compression method) {
    switch (method) {
    case Imf::NO_COMPRESSION:
    case Imf::B44_COMPRESSION:
        return 2;
    case Imf::RLE_COMPRESSION:
        return 64;
    case Imf::ZIPS_COMPRESSION:
    case Imf::ZIP_COMPRESSION:
    case Imf::PXR24_COMPRESSION:
        return 1032;
    default:
        return 1 << 17;
    }
}

/// Before room is made for what a small file cannot hold.
void refuse_too_few_bytes(
    const Imf::Header& header, Window window, std::uint64_t channels, std::uint64_t bytes) {
    const auto pixels = static_cast<std::uint64_t>(window.width) * window.height;
    if (pixels * channels / most_values_per_byte(header.compression()) <= bytes) return;
    throw std::runtime_error(fmt::format("its {} x {} pixels of {} channels cannot be in its {} "
                                         "bytes; it is damaged or cut off",
        window.width, window.height, channels, bytes));
}

/// R, G, B, A first, then the file's (alphabetical) order.
std::vector<std::string> channel_names(const Imf::ChannelList& list) {
    std::vector<std::string> names;
    for (const char* name : {"R", "G", "B", "A"}) {
        if (list.findChannel(name)) names.emplace_back(name);
    }
    const auto first_others = static_cast<std::ptrdiff_t>(names.size());
    for (auto it = list.begin(); it != list.end(); ++it) {
        if (it.channel().xSampling != 1 || it.channel().ySampling != 1) {
            throw std::runtime_error(
                fmt::format("its channel '{}' is subsampled, which is not supported", it.name()));
        }
        const auto colours = names.begin() + first_others;
        if (std::find(names.begin(), colours, it.name()) == colours) names.emplace_back(it.name());
    }
    if (names.empty()) throw std::runtime_error("it has no channels");
    return names;
}

Image decode(std::span<const std::byte> bytes, const std::string& path) {
    MemoryReader reader(bytes);
    Imf::MultiPartInputFile file(reader);
    const Imf::Header& header = file.header(0);
    if (header.hasType() && Imf::isDeepData(header.type())) {
        throw std::runtime_error("it holds deep data, which is not supported");
    }
    const std::vector<std::string> names = channel_names(header.channels());
    const Window window = checked_window(header, static_cast<std::int64_t>(names.size()));
    refuse_too_few_bytes(header, window, names.size(), bytes.size());
    const Imath::Box2i box = header.dataWindow();

    Image image(window.width, window.height, names);
    Imf::FrameBuffer frame;
    for (const std::string& name : names) {
        frame.insert(
            name, Imf::Slice::Make(Imf::FLOAT, image.plane(name).data(), box, sizeof(float),
                      sizeof(float) * static_cast<std::size_t>(window.width)));
    }
    Imf::InputPart part(file, 0);
    part.setFrameBuffer(frame);
    part.readPixels(box.min.y, box.max.y);

    for (auto it = header.begin(); it != header.end(); ++it) {
        const auto* text = dynamic_cast<const Imf::StringAttribute*>(&it.attribute());
        if (text && !is_structural(it.name())) image.metadata[it.name()] = text->value();
    }
    if (file.parts() > 1) {
        log::warning("'{}' has {} parts: only the first is read", path, file.parts());
    }
    if (box != header.displayWindow()) {
        log::warning("'{}': its display window differs from its data window, whose {} x {} pixels "
                     "are read",
            path, window.width, window.height);
    }
    return image;
}

} // namespace

void save_exr(const std::filesystem::path& path, const Image& image, bool half) {
    check(!image.empty() && !image.channels().empty(), "an image to save has pixels and channels");
    std::size_t clamped = 0;
    std::vector<std::byte> bytes;
    try {
        bytes = encode(image, half, clamped);
    } catch (const std::bad_alloc&) {
        fail_input("cannot write '{}': out of memory", path.string());
    } catch (const std::exception& error) {
        fail_input("cannot write '{}': {}", path.string(), error.what());
    }
    write_file(path, bytes);
    if (clamped > 0) {
        log::warning("'{}': {} values were beyond the largest half, 65504, and clamped to it",
            path.string(), clamped);
    }
}

Image load_exr(const std::filesystem::path& path) {
    const std::vector<std::byte> bytes = read_file(path);
    try {
        return decode(bytes, path.string());
    } catch (const std::bad_alloc&) {
        fail_input("cannot read '{}' as OpenEXR: out of memory", path.string());
    } catch (const std::exception& error) {
        fail_input("cannot read '{}' as OpenEXR: {}", path.string(), error.what());
    } catch (...) {
        fail_input("cannot read '{}' as OpenEXR: the decoder gave no reason", path.string());
    }
}

} // namespace ockham
