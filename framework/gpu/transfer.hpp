// SPDX-License-Identifier: Apache-2.0
// Bytes between host and device, outside graphs: uploads of scenes and textures in batches, and
// reading results back. Everything here waits; inside a graph, passes copy.
#pragma once

#include "framework/gpu/buffer.hpp"
#include "framework/gpu/image.hpp"

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

namespace ockham::gpu {

class Device;

/// Collects uploads and submits them together: uploader.add(...) as often as needed, then finish().
/// Holds at most about 64 MiB of copies at a time, and submits early beyond that.
class Uploader {
public:
    explicit Uploader(Device& device);
    /// finish() must have been called after the last add(), unless an error is under way.
    ~Uploader();
    Uploader(const Uploader&) = delete;
    Uploader& operator=(const Uploader&) = delete;

    /// Copies `bytes` to `offset` in the buffer, which needs VK_BUFFER_USAGE_TRANSFER_DST.
    void add(const Buffer& buffer, std::span<const std::byte> bytes, std::uint64_t offset = 0);
    /// Copies all texels of one mip of one layer, rows tight; the image needs
    /// VK_IMAGE_USAGE_TRANSFER_DST. What the image held before its first add() is lost.
    void add(const Image& image, std::uint32_t layer, std::uint32_t mip,
        std::span<const std::byte> bytes);
    /// Submits and waits. Buffers can then be read by anything; images are in
    /// SHADER_READ_ONLY_OPTIMAL, mips and layers that were not added with undefined content.
    void finish();

private:
    class Impl;
    std::unique_ptr<Impl> impl_;
};

void upload(Device& device, const Buffer& buffer, std::span<const std::byte> bytes);
void upload(Device& device, const Image& image, std::uint32_t layer, std::uint32_t mip,
    std::span<const std::byte> bytes);

/// `bytes` bytes from `offset`; the buffer needs VK_BUFFER_USAGE_TRANSFER_SRC.
std::vector<std::byte> download(
    Device& device, const Buffer& buffer, std::uint64_t offset, std::uint64_t bytes);
/// One mip of one layer, rows tight. `layout` is the image's layout, and stays. The image needs
/// VK_IMAGE_USAGE_TRANSFER_SRC and a format of find_format().
std::vector<std::byte> download(Device& device, const Image& image, VkImageLayout layout,
    std::uint32_t layer = 0, std::uint32_t mip = 0);

} // namespace ockham::gpu
