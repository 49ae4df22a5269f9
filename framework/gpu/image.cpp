// SPDX-License-Identifier: Apache-2.0
#include "framework/gpu/image.hpp"

#include "framework/core/error.hpp"
#include "framework/gpu/device.hpp"

#include <glm/gtc/packing.hpp>

#include <algorithm>
#include <cstring>
#include <map>
#include <mutex>
#include <utility>

namespace ockham::gpu {

namespace {

constexpr FormatInfo kFormats[] = {
    {VK_FORMAT_R8_UNORM, "R8_UNORM", 1, ChannelType::unorm8, 1},
    {VK_FORMAT_R8G8_UNORM, "RG8_UNORM", 2, ChannelType::unorm8, 2},
    {VK_FORMAT_R8G8B8A8_UNORM, "RGBA8_UNORM", 4, ChannelType::unorm8, 4},
    {VK_FORMAT_R8G8B8A8_SRGB, "RGBA8_SRGB", 4, ChannelType::srgb8, 4},
    {VK_FORMAT_R8_UINT, "R8_UINT", 1, ChannelType::uint8, 1},
    {VK_FORMAT_R8G8_UINT, "RG8_UINT", 2, ChannelType::uint8, 2},
    {VK_FORMAT_R8G8B8A8_UINT, "RGBA8_UINT", 4, ChannelType::uint8, 4},
    {VK_FORMAT_R16_UNORM, "R16_UNORM", 1, ChannelType::unorm16, 2},
    {VK_FORMAT_R16G16_UNORM, "RG16_UNORM", 2, ChannelType::unorm16, 4},
    {VK_FORMAT_R16G16B16A16_UNORM, "RGBA16_UNORM", 4, ChannelType::unorm16, 8},
    {VK_FORMAT_R16_UINT, "R16_UINT", 1, ChannelType::uint16, 2},
    {VK_FORMAT_R16G16_UINT, "RG16_UINT", 2, ChannelType::uint16, 4},
    {VK_FORMAT_R16G16B16A16_UINT, "RGBA16_UINT", 4, ChannelType::uint16, 8},
    {VK_FORMAT_R16_SFLOAT, "R16_SFLOAT", 1, ChannelType::float16, 2},
    {VK_FORMAT_R16G16_SFLOAT, "RG16_SFLOAT", 2, ChannelType::float16, 4},
    {VK_FORMAT_R16G16B16A16_SFLOAT, "RGBA16_SFLOAT", 4, ChannelType::float16, 8},
    {VK_FORMAT_R32_UINT, "R32_UINT", 1, ChannelType::uint32, 4},
    {VK_FORMAT_R32G32_UINT, "RG32_UINT", 2, ChannelType::uint32, 8},
    {VK_FORMAT_R32G32B32A32_UINT, "RGBA32_UINT", 4, ChannelType::uint32, 16},
    {VK_FORMAT_R32_SFLOAT, "R32_SFLOAT", 1, ChannelType::float32, 4},
    {VK_FORMAT_R32G32_SFLOAT, "RG32_SFLOAT", 2, ChannelType::float32, 8},
    {VK_FORMAT_R32G32B32A32_SFLOAT, "RGBA32_SFLOAT", 4, ChannelType::float32, 16},
    {VK_FORMAT_D32_SFLOAT, "D32_SFLOAT", 1, ChannelType::float32, 4},
    {VK_FORMAT_S8_UINT, "S8_UINT", 1, ChannelType::uint8, 1},
};

bool is_depth(VkFormat format) { return format == VK_FORMAT_D32_SFLOAT; }
bool is_stencil(VkFormat format) { return format == VK_FORMAT_S8_UINT; }

VkImageCreateInfo create_info(const Device& device, const ImageInfo& info) {
    const VkImageCreateInfo create{.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
        .flags = info.aliased ? VkImageCreateFlags{VK_IMAGE_CREATE_ALIAS_BIT} : 0,
        .imageType = info.depth > 1 ? VK_IMAGE_TYPE_3D : VK_IMAGE_TYPE_2D,
        .format = info.format,
        .extent = {info.width, info.height, info.depth},
        .mipLevels = info.mips,
        .arrayLayers = info.layers,
        .samples = VK_SAMPLE_COUNT_1_BIT,
        .tiling = VK_IMAGE_TILING_OPTIMAL,
        .usage = info.usage,
        .sharingMode =
            info.families.empty() ? VK_SHARING_MODE_EXCLUSIVE : VK_SHARING_MODE_CONCURRENT,
        .queueFamilyIndexCount = static_cast<std::uint32_t>(info.families.size()),
        .pQueueFamilyIndices = info.families.data()};
    const VkPhysicalDeviceImageFormatInfo2 query{
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_IMAGE_FORMAT_INFO_2,
        .format = create.format,
        .type = create.imageType,
        .tiling = create.tiling,
        .usage = create.usage,
        .flags = create.flags};
    VkImageFormatProperties2 found{.sType = VK_STRUCTURE_TYPE_IMAGE_FORMAT_PROPERTIES_2};
    const VkResult result =
        vkGetPhysicalDeviceImageFormatProperties2(device.physical(), &query, &found);
    if (result == VK_ERROR_FORMAT_NOT_SUPPORTED) {
        fail_device("image '{}': '{}' does not support format {} with usage {:#x}; choose another "
                    "format or device",
            info.name, device.info().name, name_of(info.format), info.usage);
    }
    expect(result, fmt::format("asking about the format of image '{}'", info.name));
    const VkExtent3D& max = found.imageFormatProperties.maxExtent;
    if (info.width > max.width || info.height > max.height || info.depth > max.depth ||
        info.layers > found.imageFormatProperties.maxArrayLayers ||
        info.mips > found.imageFormatProperties.maxMipLevels) {
        fail_device(
            "image '{}' of {} x {} x {}, {} layers, {} mips is too large: the device allows "
            "{} x {} x {}, {} layers, {} mips",
            info.name, info.width, info.height, info.depth, info.layers, info.mips, max.width,
            max.height, max.depth, found.imageFormatProperties.maxArrayLayers,
            found.imageFormatProperties.maxMipLevels);
    }
    return create;
}

} // namespace

/// The views made so far, by type and range.
class Image::Views {
public:
    Views() = default;
    Views(const Views&) = delete;
    Views& operator=(const Views&) = delete;

    std::mutex mutex;
    std::map<std::pair<VkImageViewType, ImageRange>, VkImageView> made;
};

Image::Image(Device* device, const ImageInfo& info)
    : device_(device), info_(info), views_(std::make_unique<Views>()) {
    const VkImageCreateInfo create = create_info(*device, info);
    expect(vkCreateImage(device->handle(), &create, nullptr, &image_),
        fmt::format(
            "creating image '{}' of {} x {} x {}", info.name, info.width, info.height, info.depth));
    set_name(*device, VK_OBJECT_TYPE_IMAGE, image_, info.name);
}

Image::Image(Device& device, const ImageInfo& info) : Image(&device, info) {
    memory_ = device.allocator().allocate(
        memory_requirements(device, info), MemoryUse::device, info.name);
    expect(vkBindImageMemory(device.handle(), image_, memory_.handle(), memory_.offset()),
        fmt::format("binding memory to image '{}'", info.name));
}

Image::Image(Device& device, const ImageInfo& info, const Memory& memory, std::uint64_t offset)
    : Image(&device, info) {
    expect(vkBindImageMemory(device.handle(), image_, memory.handle(), memory.offset() + offset),
        fmt::format("binding memory to image '{}'", info.name));
}

Image::Image(Device& device, const ImageInfo& info, VkImage existing)
    : device_(&device), info_(info), image_(existing), owned_(false),
      views_(std::make_unique<Views>()) {}

Image::~Image() {
    if (!views_) return; // moved from
    for (const auto& [key, view] : views_->made) {
        vkDestroyImageView(device_->handle(), view, nullptr);
    }
    if (image_ && owned_) vkDestroyImage(device_->handle(), image_, nullptr);
}

Image::Image(Image&& other) noexcept
    : device_(other.device_), info_(std::move(other.info_)),
      image_(std::exchange(other.image_, VK_NULL_HANDLE)), owned_(other.owned_),
      memory_(std::move(other.memory_)), views_(std::move(other.views_)) {}

Image& Image::operator=(Image&& other) noexcept {
    std::swap(device_, other.device_);
    std::swap(info_, other.info_);
    std::swap(image_, other.image_);
    std::swap(owned_, other.owned_);
    std::swap(memory_, other.memory_);
    std::swap(views_, other.views_);
    return *this;
}

VkImageAspectFlags Image::aspect() const {
    if (is_stencil(info_.format)) return VK_IMAGE_ASPECT_STENCIL_BIT;
    return is_depth(info_.format) ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT;
}

VkImageSubresourceRange Image::subresources(const ImageRange& range) const {
    return {.aspectMask = aspect(),
        .baseMipLevel = range.first_mip,
        .levelCount = std::min(range.mips, info_.mips - range.first_mip),
        .baseArrayLayer = range.first_layer,
        .layerCount = std::min(range.layers, info_.layers - range.first_layer)};
}

VkImageView Image::view(VkImageViewType type, const ImageRange& range) const {
    const std::lock_guard lock(views_->mutex);
    VkImageView& view = views_->made[{type, range}];
    if (view) return view;
    const VkImageViewCreateInfo create{.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
        .image = image_,
        .viewType = type,
        .format = info_.format,
        .subresourceRange = subresources(range)};
    expect(vkCreateImageView(device_->handle(), &create, nullptr, &view),
        fmt::format("creating a view of image '{}'", info_.name));
    set_name(*device_, VK_OBJECT_TYPE_IMAGE_VIEW, view, info_.name);
    return view;
}

VkMemoryRequirements memory_requirements(const Device& device, const ImageInfo& info) {
    const VkImageCreateInfo create = create_info(device, info);
    const VkDeviceImageMemoryRequirements query{
        .sType = VK_STRUCTURE_TYPE_DEVICE_IMAGE_MEMORY_REQUIREMENTS, .pCreateInfo = &create};
    VkMemoryRequirements2 result{.sType = VK_STRUCTURE_TYPE_MEMORY_REQUIREMENTS_2};
    vkGetDeviceImageMemoryRequirements(device.handle(), &query, &result);
    return result.memoryRequirements;
}

const FormatInfo* find_format(VkFormat format) {
    for (const FormatInfo& row : kFormats) {
        if (row.format == format) return &row;
    }
    return nullptr;
}

std::string name_of(VkFormat format) {
    const FormatInfo* row = find_format(format);
    return row ? row->name : fmt::format("VkFormat {}", static_cast<int>(format));
}

VkExtent3D mip_extent(const ImageInfo& info, std::uint32_t mip) {
    return {std::max(info.width >> mip, 1u), std::max(info.height >> mip, 1u),
        std::max(info.depth >> mip, 1u)};
}

VkClearValue clear_value(VkFormat format, const std::array<float, 4>& value) {
    VkClearValue result{};
    if (is_depth(format)) {
        result.depthStencil.depth = value[0];
        return result;
    }
    if (is_stencil(format)) {
        result.depthStencil.stencil = static_cast<std::uint32_t>(value[0]);
        return result;
    }
    const FormatInfo* info = find_format(format);
    const bool integer =
        info && (info->type == ChannelType::uint8 || info->type == ChannelType::uint16 ||
                    info->type == ChannelType::uint32);
    for (std::size_t i = 0; i < 4; ++i) {
        if (integer) {
            result.color.uint32[i] = static_cast<std::uint32_t>(value[i]);
        } else {
            result.color.float32[i] = value[i];
        }
    }
    return result;
}

void clear(VkCommandBuffer commands, const Image& image, const std::array<float, 4>& value,
    const ImageRange& part) {
    const VkImageSubresourceRange range = image.subresources(part);
    const VkClearValue converted = clear_value(image.info().format, value);
    constexpr VkImageLayout layout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
    if (image.aspect() != VK_IMAGE_ASPECT_COLOR_BIT) {
        vkCmdClearDepthStencilImage(
            commands, image.handle(), layout, &converted.depthStencil, 1, &range);
    } else {
        vkCmdClearColorImage(commands, image.handle(), layout, &converted.color, 1, &range);
    }
}

namespace {

template <class T, class Convert>
std::vector<float> decode(std::span<const std::byte> texels, Convert convert) {
    std::vector<float> values(texels.size() / sizeof(T));
    for (std::size_t i = 0; i < values.size(); ++i) {
        T value;
        std::memcpy(&value, texels.data() + i * sizeof(T), sizeof(T));
        values[i] = convert(value);
    }
    return values;
}

} // namespace

std::vector<float> decode_texels(const FormatInfo& format, std::span<const std::byte> texels) {
    const auto as_is = [](auto value) { return static_cast<float>(value); };
    switch (format.type) {
    case ChannelType::unorm8:
    case ChannelType::srgb8:
        return decode<std::uint8_t>(
            texels, [](std::uint8_t v) { return static_cast<float>(v) / 255.0f; });
    case ChannelType::unorm16:
        return decode<std::uint16_t>(
            texels, [](std::uint16_t v) { return static_cast<float>(v) / 65535.0f; });
    case ChannelType::float16:
        return decode<std::uint16_t>(
            texels, [](std::uint16_t v) { return glm::unpackHalf1x16(v); });
    case ChannelType::uint8:
        return decode<std::uint8_t>(texels, as_is);
    case ChannelType::uint16:
        return decode<std::uint16_t>(texels, as_is);
    case ChannelType::uint32:
        return decode<std::uint32_t>(texels, as_is);
    case ChannelType::float32:
        return decode<float>(texels, as_is);
    }
    return {};
}

} // namespace ockham::gpu
