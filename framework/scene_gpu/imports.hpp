// SPDX-License-Identifier: Apache-2.0
// Resources that an upload made, or did not because nothing needs them, in a graph and its
// executor. For SceneGpu and VolumeGpu.
#pragma once

#include "framework/gpu/buffer.hpp"
#include "framework/gpu/image.hpp"
#include "framework/runtime/executor.hpp"

#include <optional>

namespace ockham {

/// Under its own name; an empty handle where there is none.
inline BufferHandle import_buffer(Graph& graph, const std::optional<gpu::Buffer>& source) {
    return source ? graph.import_buffer(source->name(), {source->bytes()}, {}) : BufferHandle{};
}

/// The same, left by its upload in the layout that shaders read.
inline ImageHandle import_image(Graph& graph, const std::optional<gpu::Image>& source) {
    if (!source) return {};
    const gpu::ImageInfo& info = source->info();
    return graph.import_image(source->name(),
        {.format = info.format,
            .width = info.width,
            .height = info.height,
            .depth = info.depth,
            .layers = info.layers,
            .mips = info.mips},
        AccessState{.layout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL});
}

/// Gives it to the graph's executor, if there is one.
template <class HandleType, class Resource>
void bind_import(Executor& executor, HandleType handle, const std::optional<Resource>& source) {
    if (source) executor.bind(handle, *source);
}

} // namespace ockham
