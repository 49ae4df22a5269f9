// SPDX-License-Identifier: Apache-2.0
// A Vulkan image with its memory and its views, and what the project knows about texel formats.
// Holds no layout: that is the graph's business, or transfer's.
#pragma once

#include "framework/gpu/memory.hpp"

#include <array>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace ockham::gpu {

class Device;

struct ImageInfo {
    VkFormat format = VK_FORMAT_UNDEFINED;
    std::uint32_t width = 1;
    std::uint32_t height = 1;
    std::uint32_t depth = 1; ///< > 1: a 3D image
    std::uint32_t layers = 1;
    std::uint32_t mips = 1;
    VkImageUsageFlags usage = 0;
    std::string name = {};
    bool aliased = false;                     ///< shares its memory with other images over time
    std::vector<std::uint32_t> families = {}; ///< that share it at a time; empty: one owns it
};

/// Mips and layers of an image, all by default.
struct ImageRange {
    std::uint32_t first_mip = 0, mips = VK_REMAINING_MIP_LEVELS;
    std::uint32_t first_layer = 0, layers = VK_REMAINING_ARRAY_LAYERS;

    auto operator<=>(const ImageRange&) const = default;
};

class Image {
public:
    /// Content is undefined, layout UNDEFINED. Throws Error(device) naming the image where memory
    /// is short or the device does not support format, size and usage together.
    Image(Device& device, const ImageInfo& info);
    /// The same on memory of somebody else, which must outlive it, at `offset` bytes inside.
    Image(Device& device, const ImageInfo& info, const Memory& memory, std::uint64_t offset);
    /// An image of somebody else, who created it as `info` says and destroys it.
    Image(Device& device, const ImageInfo& info, VkImage existing);
    ~Image();
    Image(Image&& other) noexcept;
    Image& operator=(Image&& other) noexcept;

    VkImage handle() const { return image_; }
    const ImageInfo& info() const { return info_; }
    const std::string& name() const { return info_.name; }
    VkImageAspectFlags aspect() const;
    VkImageSubresourceRange subresources(const ImageRange& range = {}) const;
    /// Made when first asked for; safe to call from several threads. A 2D view has one layer.
    VkImageView view(VkImageViewType type, const ImageRange& range = {}) const;

private:
    class Views;
    Image(Device* device, const ImageInfo& info); // no memory yet

    Device* device_ = nullptr;
    ImageInfo info_;
    VkImage image_ = VK_NULL_HANDLE;
    bool owned_ = true;
    Memory memory_;
    std::unique_ptr<Views> views_;
};

/// What an image like this takes on this device. Throws as the constructor does.
VkMemoryRequirements memory_requirements(const Device& device, const ImageInfo& info);

/// How one channel is stored.
enum class ChannelType { unorm8, srgb8, uint8, unorm16, float16, uint16, uint32, float32 };

struct FormatInfo {
    VkFormat format;
    const char* name;
    std::uint32_t channels;
    ChannelType type;
    std::uint32_t texel_bytes;
};

/// Null for formats that the project does not read or write on the host.
const FormatInfo* find_format(VkFormat format);
/// "RGBA8_UNORM", or the number where there is no name.
std::string name_of(VkFormat format);

/// Four channels, converted to the format's kind of number, or depth from the first.
VkClearValue clear_value(VkFormat format, const std::array<float, 4>& value);
/// The range must be in TRANSFER_DST_OPTIMAL.
void clear(VkCommandBuffer commands, const Image& image, const std::array<float, 4>& value,
    const ImageRange& range = {});
/// Size of a mip, >= 1 in each axis.
VkExtent3D mip_extent(const ImageInfo& info, std::uint32_t mip);

/// Texels of one mip of one layer as floats, channels interleaved: unorm in [0,1], integers by
/// value (32-bit ones rounded to float), halves exactly, sRGB left encoded.
std::vector<float> decode_texels(const FormatInfo& format, std::span<const std::byte> texels);

} // namespace ockham::gpu
