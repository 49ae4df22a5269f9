// SPDX-License-Identifier: Apache-2.0
// The bridge between C++ and GLSL: one set of type names, so that a struct that both see is written
// once. Include it first, as "shared/types.h"; put structs between OCKHAM_SHARED_BEGIN and _END, and
// use them in blocks with layout(scalar), which lays them out as C++ does. No bool in shared structs.
// Only this file asks which language it is.
#ifndef OCKHAM_SHADERS_SHARED_TYPES_H
#define OCKHAM_SHADERS_SHARED_TYPES_H

#ifdef __cplusplus

#include <glm/glm.hpp>

#include <cstdint>

namespace ockham::shader {
using uint = std::uint32_t;
using glm::ivec2, glm::ivec3, glm::ivec4;
using glm::mat2, glm::mat3, glm::mat4, glm::mat4x3;
using glm::uvec2, glm::uvec3, glm::uvec4;
using glm::vec2, glm::vec3, glm::vec4;
} // namespace ockham::shader

/// Shared structs live in namespace ockham::shader.
#define OCKHAM_SHARED_BEGIN namespace ockham::shader {
#define OCKHAM_SHARED_END }
/// States the size of a shared struct; the build fails where C++ disagrees.
#define OCKHAM_SHARED_SIZE(Type, bytes) static_assert(sizeof(Type) == (bytes))

#else

#extension GL_EXT_scalar_block_layout : require

#define OCKHAM_SHARED_BEGIN
#define OCKHAM_SHARED_END
#define OCKHAM_SHARED_SIZE(Type, bytes)

#endif
#endif
