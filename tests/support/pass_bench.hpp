// SPDX-License-Identifier: Apache-2.0
// Runs single passes on inputs given as arrays: imports them into a graph, executes, reads back.
// For tests of passes; whole pictures are tested through passes/pipelines.
#pragma once

#include "framework/gpu/buffer.hpp"
#include "framework/gpu/image.hpp"
#include "framework/runtime/executor.hpp"

#include <cstdint>
#include <cstring>
#include <deque>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace ockham::test {

class PassBench {
public:
    /// `device` must outlive the bench.
    explicit PassBench(gpu::Device& device) : device_(device) {}

    /// Declare passes here until the first execute().
    Graph graph{"test"};

    /// An imported storage buffer with this content, at least one element.
    template <class T>
    BufferHandle buffer(const std::string& name, std::span<const T> values) {
        return add_buffer(name, std::as_bytes(values));
    }
    template <class T>
    BufferHandle buffer(const std::string& name, const std::vector<T>& values) {
        return buffer(name, std::span<const T>(values));
    }

    /// An imported image with these texels (rows tight, format's layout).
    template <class T>
    ImageHandle image(const std::string& name, VkFormat format, std::uint32_t width,
        std::uint32_t height, const std::vector<T>& texels) {
        return add_image(name, format, width, height, std::as_bytes(std::span(texels)));
    }
    /// Gives an imported image new texels, between executions too.
    template <class T>
    void set(ImageHandle image, const std::vector<T>& texels) {
        set_bytes(image, std::as_bytes(std::span(texels)));
    }

    /// Keeps an image of the graph for texels<T>(): Image rounds 32-bit integers to floats.
    ImageHandle keep(ImageHandle image);
    /// All texels of a kept image, rows tight.
    template <class T>
    std::vector<T> texels(ImageHandle kept) {
        const std::vector<std::byte> bytes = download(kept);
        std::vector<T> values(bytes.size() / sizeof(T));
        std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
        return values;
    }

    /// Runs before the first execution: binds what was imported elsewhere.
    void on_bind(std::function<void(Executor&)> bind) { binders_.push_back(std::move(bind)); }

    /// The first one compiles the graph. What is read must have been exported.
    void execute();
    Executor& executor() { return *executor_; }
    Image read(ImageHandle image) { return executor_->read(image); }
    template <class T>
    std::vector<T> read(BufferHandle buffer) {
        const std::vector<std::byte> bytes = executor_->read(buffer);
        std::vector<T> values(bytes.size() / sizeof(T));
        std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
        return values;
    }

private:
    BufferHandle add_buffer(const std::string& name, std::span<const std::byte> bytes);
    ImageHandle add_image(const std::string& name, VkFormat format, std::uint32_t width,
        std::uint32_t height, std::span<const std::byte> texels);
    std::vector<std::byte> download(ImageHandle kept);
    void set_bytes(ImageHandle image, std::span<const std::byte> texels);

    gpu::Device& device_;
    struct OwnBuffer {
        BufferHandle handle;
        gpu::Buffer buffer;
    };
    struct OwnImage {
        ImageHandle handle;
        gpu::Image image;
    };
    std::deque<OwnBuffer> buffers_;
    std::deque<OwnImage> images_;
    std::vector<std::function<void(Executor&)>> binders_;
    std::optional<Executor> executor_;
};

/// One picture in whole pixels of `channels` interleaved floats from an Image's planes.
std::vector<float> interleaved(const Image& image);

} // namespace ockham::test
