// SPDX-License-Identifier: Apache-2.0
#include "tests/support/pass_bench.hpp"

#include "framework/core/error.hpp"
#include "framework/gpu/transfer.hpp"
#include "framework/runtime/commands.hpp"

namespace ockham::test {

BufferHandle PassBench::add_buffer(const std::string& name, std::span<const std::byte> bytes) {
    const BufferHandle handle = graph.import_buffer(name, {bytes.size()}, {});
    gpu::Buffer buffer(
        device_, gpu::BufferInfo{.bytes = bytes.size(),
                     .usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
                              VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                     .name = name});
    gpu::upload(device_, buffer, bytes);
    buffers_.push_back({handle, std::move(buffer)});
    return handle;
}

ImageHandle PassBench::add_image(const std::string& name, VkFormat format, std::uint32_t width,
    std::uint32_t height, std::span<const std::byte> texels) {
    const AccessState state{.layout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
    const ImageHandle handle = graph.import_image(
        name, {.format = format, .width = width, .height = height}, state, state);
    images_.push_back({handle,
        gpu::Image(device_, gpu::ImageInfo{.format = format,
                                .width = width,
                                .height = height,
                                .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_STORAGE_BIT |
                                         VK_IMAGE_USAGE_TRANSFER_DST_BIT,
                                .name = name})});
    set_bytes(handle, texels);
    return handle;
}

void PassBench::set_bytes(ImageHandle image, std::span<const std::byte> texels) {
    for (const OwnImage& own : images_) {
        if (own.handle.resource != image.resource) continue;
        gpu::upload(device_, own.image, 0, 0, texels);
        return;
    }
    check(false, "the bench has no such image");
}

ImageHandle PassBench::keep(ImageHandle image) {
    const ImageDesc desc = graph.desc(image);
    const std::string name = fmt::format("kept_{}", images_.size());
    ImageHandle copy = graph.import_image(
        name, desc, {}, AccessState{.layout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL});
    images_.push_back({copy, gpu::Image(device_, gpu::ImageInfo{.format = desc.format,
                                                     .width = desc.width,
                                                     .height = desc.height,
                                                     .usage = VK_IMAGE_USAGE_TRANSFER_SRC_BIT |
                                                              VK_IMAGE_USAGE_TRANSFER_DST_BIT,
                                                     .name = name})});
    PassBuilder pass = graph.add_transfer_pass(name);
    pass.copy_from(image);
    const ImageHandle kept = pass.copy_to(copy);
    pass.record([image, kept](Commands& commands) { commands.copy(image, kept); });
    return kept;
}

std::vector<std::byte> PassBench::download(ImageHandle kept) {
    for (const OwnImage& own : images_) {
        if (own.handle.resource == kept.resource)
            return gpu::download(device_, own.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    }
    check(false, "the bench has no such image");
    return {};
}

void PassBench::execute() {
    if (!executor_) {
        executor_.emplace(device_, std::move(graph));
        for (const OwnBuffer& own : buffers_) executor_->bind(own.handle, own.buffer);
        for (const OwnImage& own : images_) executor_->bind(own.handle, own.image);
        for (const auto& bind : binders_) bind(*executor_);
    }
    executor_->execute();
}

std::vector<float> interleaved(const Image& image) {
    const std::size_t channels = image.channels().size();
    std::vector<float> values(image.pixels() * channels);
    for (std::size_t c = 0; c < channels; ++c) {
        const std::span<const float> plane = image.plane(static_cast<int>(c));
        for (std::size_t i = 0; i < plane.size(); ++i) values[i * channels + c] = plane[i];
    }
    return values;
}

} // namespace ockham::test
