// SPDX-License-Identifier: Apache-2.0
#include "framework/gpu/transfer.hpp"

#include "framework/core/error.hpp"
#include "framework/gpu/device.hpp"

#include <algorithm>
#include <cstring>
#include <exception>
#include <optional>
#include <set>

namespace ockham::gpu {

namespace {

constexpr std::uint64_t kChunkBytes = std::uint64_t{64} << 20;

std::uint64_t mip_bytes(const ImageInfo& info, std::uint32_t mip) {
    const FormatInfo* format = find_format(info.format);
    if (!format) {
        fail_input("image '{}' has format {}, which cannot be copied to or from the host",
            info.name, name_of(info.format));
    }
    const VkExtent3D extent = mip_extent(info, mip);
    return std::uint64_t{format->texel_bytes} * extent.width * extent.height * extent.depth;
}

/// From everything to everything: transfers are not worth finer ones.
void barrier(VkCommandBuffer commands) {
    const VkMemoryBarrier2 all{.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
        .srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
        .srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT,
        .dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT | VK_PIPELINE_STAGE_2_HOST_BIT,
        .dstAccessMask =
            VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT | VK_ACCESS_2_HOST_READ_BIT};
    const VkDependencyInfo info{.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
        .memoryBarrierCount = 1,
        .pMemoryBarriers = &all};
    vkCmdPipelineBarrier2(commands, &info);
}

void transition(VkCommandBuffer commands, const Image& image, VkImageLayout from, VkImageLayout to,
    const ImageRange& range = {}) {
    const VkImageMemoryBarrier2 all{.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
        .srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
        .srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT,
        .dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
        .dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT,
        .oldLayout = from,
        .newLayout = to,
        .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
        .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
        .image = image.handle(),
        .subresourceRange = image.subresources(range)};
    const VkDependencyInfo info{.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
        .imageMemoryBarrierCount = 1,
        .pImageMemoryBarriers = &all};
    vkCmdPipelineBarrier2(commands, &info);
}

} // namespace

class Uploader::Impl {
public:
    explicit Impl(Device& device) : device_(device) {}

    /// Appends to the staging bytes and returns where; submits first if they would become too many.
    std::uint64_t stage(std::span<const std::byte> bytes) {
        if (!staging_.empty() && staging_.size() + bytes.size() > kChunkBytes) submit(false);
        // 16: a multiple of every texel size.
        const std::uint64_t offset = (staging_.size() + 15) / 16 * 16;
        staging_.resize(offset);
        staging_.insert(staging_.end(), bytes.begin(), bytes.end());
        return offset;
    }

    void submit(bool last) {
        if (staging_.empty() && (!last || open_.empty())) return;
        std::optional<Buffer> source;
        if (!staging_.empty()) {
            source.emplace(device_, BufferInfo{.bytes = staging_.size(),
                                        .usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT,
                                        .name = "upload",
                                        .memory = MemoryUse::upload});
            std::memcpy(source->mapped().data(), staging_.data(), staging_.size());
        }
        device_.run("upload", [&](VkCommandBuffer commands) {
            barrier(commands);
            for (const Image* image : fresh_) {
                transition(commands, *image, VK_IMAGE_LAYOUT_UNDEFINED,
                    VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
            }
            for (const BufferCopy& copy : buffer_copies_) {
                vkCmdCopyBuffer(commands, source->handle(), copy.to->handle(), 1, &copy.region);
            }
            for (const ImageCopy& copy : image_copies_) {
                vkCmdCopyBufferToImage(commands, source->handle(), copy.to->handle(),
                    VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &copy.region);
            }
            if (!last) return;
            for (const Image* image : open_) {
                transition(commands, *image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                    VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
            }
            barrier(commands);
        });
        staging_.clear();
        buffer_copies_.clear();
        image_copies_.clear();
        fresh_.clear();
        if (last) open_.clear();
    }

    struct BufferCopy {
        const Buffer* to;
        VkBufferCopy region;
    };
    struct ImageCopy {
        const Image* to;
        VkBufferImageCopy region;
    };

    Device& device_;
    std::vector<std::byte> staging_;
    std::vector<BufferCopy> buffer_copies_;
    std::vector<ImageCopy> image_copies_;
    std::set<const Image*> fresh_; ///< still in UNDEFINED
    std::set<const Image*> open_;  ///< in or on the way to TRANSFER_DST
};

Uploader::Uploader(Device& device) : impl_(std::make_unique<Impl>(device)) {}

Uploader::~Uploader() {
    check(std::uncaught_exceptions() > 0 || (impl_->staging_.empty() && impl_->open_.empty()),
        "an Uploader was destroyed before finish()");
}

void Uploader::add(const Buffer& buffer, std::span<const std::byte> bytes, std::uint64_t offset) {
    check(offset + bytes.size() <= buffer.bytes(), "an upload exceeds its buffer");
    while (!bytes.empty()) {
        const std::span<const std::byte> part =
            bytes.first(std::min<std::size_t>(bytes.size(), kChunkBytes));
        const std::uint64_t source = impl_->stage(part);
        impl_->buffer_copies_.push_back({&buffer, {source, offset, part.size()}});
        offset += part.size();
        bytes = bytes.subspan(part.size());
    }
}

void Uploader::add(
    const Image& image, std::uint32_t layer, std::uint32_t mip, std::span<const std::byte> bytes) {
    check(layer < image.info().layers && mip < image.info().mips,
        "an upload names a layer or mip that the image does not have");
    check(bytes.size() == mip_bytes(image.info(), mip), "an upload is not the size of its mip");
    if (impl_->open_.insert(&image).second) impl_->fresh_.insert(&image);
    const VkExtent3D extent = mip_extent(image.info(), mip);
    const std::size_t slice_bytes = bytes.size() / extent.depth;
    const auto slices = static_cast<std::uint32_t>(
        std::clamp<std::size_t>(kChunkBytes / slice_bytes, 1, extent.depth));
    for (std::uint32_t z = 0; z < extent.depth; z += slices) {
        const std::uint32_t count = std::min(slices, extent.depth - z);
        const std::uint64_t source =
            impl_->stage(bytes.subspan(z * slice_bytes, count * slice_bytes));
        impl_->image_copies_.push_back(
            {&image, {.bufferOffset = source,
                         .imageSubresource = {.aspectMask = image.aspect(),
                             .mipLevel = mip,
                             .baseArrayLayer = layer,
                             .layerCount = 1},
                         .imageOffset = {0, 0, static_cast<std::int32_t>(z)},
                         .imageExtent = {extent.width, extent.height, count}}});
    }
}

void Uploader::finish() { impl_->submit(true); }

void upload(Device& device, const Buffer& buffer, std::span<const std::byte> bytes) {
    Uploader uploader(device);
    uploader.add(buffer, bytes);
    uploader.finish();
}

void upload(Device& device, const Image& image, std::uint32_t layer, std::uint32_t mip,
    std::span<const std::byte> bytes) {
    Uploader uploader(device);
    uploader.add(image, layer, mip, bytes);
    uploader.finish();
}

namespace {

Buffer readback_buffer(Device& device, std::uint64_t bytes) {
    return Buffer(device, {.bytes = bytes,
                              .usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                              .name = "download",
                              .memory = MemoryUse::readback});
}

std::vector<std::byte> content(const Buffer& buffer) {
    return {buffer.mapped().begin(), buffer.mapped().end()};
}

} // namespace

std::vector<std::byte> download(
    Device& device, const Buffer& buffer, std::uint64_t offset, std::uint64_t bytes) {
    check(offset + bytes <= buffer.bytes(), "a download exceeds its buffer");
    if (bytes == 0) return {};
    const Buffer target = readback_buffer(device, bytes);
    device.run(fmt::format("download of {}", buffer.name()), [&](VkCommandBuffer commands) {
        barrier(commands);
        const VkBufferCopy region{offset, 0, bytes};
        vkCmdCopyBuffer(commands, buffer.handle(), target.handle(), 1, &region);
        barrier(commands);
    });
    return content(target);
}

std::vector<std::byte> download(Device& device, const Image& image, VkImageLayout layout,
    std::uint32_t layer, std::uint32_t mip) {
    check(layer < image.info().layers && mip < image.info().mips,
        "a download names a layer or mip that the image does not have");
    const Buffer target = readback_buffer(device, mip_bytes(image.info(), mip));
    device.run(fmt::format("download of {}", image.name()), [&](VkCommandBuffer commands) {
        // Other mips and layers may never have been written, and then have no layout.
        const ImageRange range{mip, 1, layer, 1};
        transition(commands, image, layout, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, range);
        const VkBufferImageCopy region{.imageSubresource = {.aspectMask = image.aspect(),
                                           .mipLevel = mip,
                                           .baseArrayLayer = layer,
                                           .layerCount = 1},
            .imageExtent = mip_extent(image.info(), mip)};
        vkCmdCopyImageToBuffer(commands, image.handle(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
            target.handle(), 1, &region);
        transition(commands, image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, layout, range);
        barrier(commands);
    });
    return content(target);
}

} // namespace ockham::gpu
