// SPDX-License-Identifier: Apache-2.0
// Triangle meshes as arrays of attributes, and the completions that glTF asks of a client:
// flat normals where none are given, tangents where a normal map needs them.
#pragma once

#include <glm/glm.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace ockham {

/// Triangles of one material. Arrays of attributes are empty or as long as `positions`.
struct Primitive {
    std::vector<glm::vec3> positions;
    std::vector<glm::vec3> normals;            ///< unit length
    std::vector<glm::vec4> tangents;           ///< xyz unit, w = handedness of the bitangent, +-1
    std::array<std::vector<glm::vec2>, 2> uvs; ///< texture coordinate sets 0 and 1
    std::vector<glm::vec4> colors;             ///< linear RGBA factors
    std::vector<std::uint32_t> indices;        ///< 3 per triangle, counter-clockwise is front
    int material = 0;                          ///< index into Scene::materials

    std::size_t triangles() const { return indices.size() / 3; }
};

struct Mesh {
    std::string name;
    std::vector<Primitive> primitives;
};

/// Axis-aligned box; empty while low > high.
struct Bounds {
    glm::vec3 low{std::numeric_limits<float>::infinity()};
    glm::vec3 high{-std::numeric_limits<float>::infinity()};

    void add(glm::vec3 point) {
        low = glm::min(low, point);
        high = glm::max(high, point);
    }
    bool empty() const { return !(low.x <= high.x); }
    glm::vec3 center() const { return empty() ? glm::vec3(0.0f) : 0.5f * (low + high); }
    /// Half the diagonal; 0 when empty.
    float radius() const { return empty() ? 0.0f : 0.5f * glm::length(high - low); }
};

/// glTF 2.0, 3.7.2.1: flat normals. Un-indexes the triangles, so that each has its own vertices.
void generate_flat_normals(Primitive& primitive);

/// Makes all normals unit length; those that are zero or not finite become the area-weighted mean
/// of their vertex's triangles. Returns how many those were.
std::size_t repair_normals(Primitive& primitive);

/// Tangents from positions, normals and the given texture coordinates, averaged over the
/// triangles of a vertex that agree in handedness; vertices are split where they do not.
/// Degenerate coordinates get an arbitrary tangent perpendicular to the normal. Needs normals.
void generate_tangents(Primitive& primitive, int uv_set);

/// Drops triangles with an index beyond the vertices' end or two equal indices; returns how many.
std::size_t drop_degenerate_triangles(Primitive& primitive);

/// Drops vertices that no triangle uses, keeping the order of the others; returns how many. All
/// indices must be within the vertices.
std::size_t drop_unused_vertices(Primitive& primitive);

} // namespace ockham
