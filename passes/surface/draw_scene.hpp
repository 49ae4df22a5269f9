// SPDX-License-Identifier: Apache-2.0
// What every pass that touches the scene's geometry or materials takes, and how the raster passes
// declare and record the scene's draws.
#pragma once

#include "framework/runtime/commands.hpp"
#include "framework/scene_gpu/scene_gpu.hpp"

namespace ockham {

/// A scene in a graph. `scene` must outlive the graph.
struct SceneInputs {
    const SceneGpu* scene = nullptr;
    SceneHandles handles;
    BufferHandle frame; ///< shader::FrameData
};

/// Declares the frame, and the buffers that shaders/surface/vertex.glsl pulls from.
void read_vertices(PassBuilder& pass, const SceneInputs& in);
/// The same where the shader looks indices up itself.
void read_triangles(PassBuilder& pass, const SceneInputs& in);
/// Specialisation of shaders/surface/vertex.glsl for the scene's vertices.
Specialization vertex_specialization(const VertexLayout& layout);
/// Which sides of single-sided materials are drawn.
enum class Sides { front, both };
/// Draws what is opaque with one pipeline, then what is masked with the other.
void record_draws(Commands& commands, const SceneInputs& in, const RasterCall& opaque,
    const RasterCall& masked, Sides sides);
/// The same without an index buffer, three vertices a triangle, for
/// shaders/surface/visibility.vert. `snap`: shader::VisibilityPush.
void record_triangle_draws(Commands& commands, const SceneInputs& in, const RasterCall& opaque,
    const RasterCall& masked, glm::vec2 steps);

} // namespace ockham
