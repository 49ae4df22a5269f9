// SPDX-License-Identifier: Apache-2.0
// What a pass may record: dispatches, draws and copies. Shader bindings are resolved by name from
// the uses that the pass declared, so a pass never sees a descriptor, a barrier or Vulkan.
#pragma once

#include "framework/graph/graph.hpp"

#include <glm/glm.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

namespace ockham {

/// Values of a shader's specialisation constants: (constant_id, 32-bit value).
using Specialization = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

/// How to run one compute shader.
struct ComputeCall {
    std::string_view shader; ///< name as in the tree: "surface/metrics.comp"
    Specialization specialization = {};
    std::span<const std::byte> push =
        {}; ///< push constants, at most 128 bytes; size as in the shader
};

/// Fixed-function state of one draw pipeline. Depth is reversed: greater is nearer.
struct RasterCall {
    std::string_view vertex_shader;
    std::string_view fragment_shader = {}; ///< empty: depth only
    Specialization specialization = {};    ///< applied to both stages
    bool depth_test = true;
    bool depth_write = true;
    bool depth_equal = false;   ///< passes where equal, not where greater
    bool stencil_write = false; ///< the stencil becomes what the fragment shader exports
    bool stencil_equal = false; ///< passes where the stencil equals set_stencil()
};

/// Any trivially copyable value as push constants.
template <class T>
std::span<const std::byte> as_push(const T& value) {
    return std::as_bytes(std::span(&value, 1));
}

class CommandsImpl;

/// Valid inside a pass's record function only. Every mistake (a binding that the pass did not
/// declare, a wrong push size, groups beyond the limit) is an Error naming pass and shader.
class Commands {
public:
    explicit Commands(CommandsImpl& impl) : impl_(&impl) {}

    /// Runs `groups` workgroups; a zero in any axis runs nothing.
    void dispatch(const ComputeCall& call, glm::uvec3 groups);
    /// Enough workgroups to cover `items` invocations per axis, by the shader's own local size.
    void dispatch_over(const ComputeCall& call, glm::uvec3 items);
    /// Group counts from a buffer that the pass declared with indirect(), at `offset_bytes`.
    void dispatch_indirect(
        const ComputeCall& call, BufferHandle arguments, std::uint64_t offset_bytes);

    /// Raster passes: bind state, then draw; push after bind where the shaders have push constants.
    /// Viewport and scissor cover the attachments, the viewport until set. Vertices are pulled from
    /// storage buffers by gl_VertexIndex, so there is no vertex layout.
    void bind(const RasterCall& call);
    enum class Cull { none, back };
    void set_cull(Cull mode, bool front_is_clockwise = false);
    void set_stencil(std::uint8_t reference); ///< 0 until then
    /// May reach beyond the attachments on all sides: they show part of a larger picture.
    void set_viewport(glm::ivec2 origin, glm::uvec2 extent);
    void push(std::span<const std::byte> values); ///< for the bound raster pipeline
    void bind_indices(const BufferPart& indices); ///< 32-bit
    void draw(std::uint32_t vertices, std::uint32_t instances = 1, std::uint32_t first_vertex = 0,
        std::uint32_t first_instance = 0);
    void draw_indexed(std::uint32_t indices, std::uint32_t instances, std::uint32_t first_index,
        std::int32_t vertex_offset, std::uint32_t first_instance);

    /// Of resources or parts that the pass declared with copy_to() and copy_from(), all of such a
    /// part or less.
    void fill(const BufferPart& buffer, std::uint32_t value);
    void clear(const ImagePart& image, const std::array<float, 4>& value);
    /// The first `bytes` of the parts; all of `from` by default.
    void copy(const BufferPart& from, const BufferPart& to, std::uint64_t bytes = kRest);
    /// Mips and layers one by one; both parts have as many, of equal size.
    void copy(const ImagePart& from, const ImagePart& to);

private:
    CommandsImpl* impl_;
};

} // namespace ockham
