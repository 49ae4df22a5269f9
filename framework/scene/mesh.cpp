// SPDX-License-Identifier: Apache-2.0
#include "framework/scene/mesh.hpp"

#include "framework/core/error.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

namespace ockham {
namespace {

constexpr glm::vec3 kAnyNormal{0.0f, 0.0f, 1.0f};

/// attribute[i] becomes the old attribute[sources[i]]; an absent attribute stays absent.
template <class T>
void gather(std::vector<T>& attribute, std::span<const std::uint32_t> sources) {
    if (attribute.empty()) return;
    std::vector<T> gathered(sources.size());
    for (std::size_t i = 0; i < sources.size(); ++i) gathered[i] = attribute[sources[i]];
    attribute = std::move(gathered);
}

void gather_vertices(Primitive& primitive, std::span<const std::uint32_t> sources) {
    gather(primitive.positions, sources);
    gather(primitive.normals, sources);
    gather(primitive.tangents, sources);
    for (auto& uvs : primitive.uvs) gather(uvs, sources);
    gather(primitive.colors, sources);
}

/// Unit vector along `v`, or `fallback` where `v` has no direction.
glm::vec3 direction_or(glm::vec3 v, glm::vec3 fallback) {
    // Scaled first: the square of a small or large length would leave the range of a float.
    const float largest = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
    if (!(largest > 0.0f) || !std::isfinite(largest)) return fallback;
    return glm::normalize(v / largest);
}

glm::vec3 any_perpendicular(glm::vec3 unit) {
    const glm::vec3 axis =
        std::abs(unit.x) < 0.5f ? glm::vec3(1.0f, 0.0f, 0.0f) : glm::vec3(0.0f, 1.0f, 0.0f);
    return glm::normalize(glm::cross(unit, axis));
}

float angle_between(glm::vec3 a, glm::vec3 b) {
    const glm::vec3 none(0.0f);
    const float cosine = glm::dot(direction_or(a, none), direction_or(b, none));
    return std::acos(std::clamp(cosine, -1.0f, 1.0f));
}

/// How texture coordinates run over a triangle.
struct TriangleTangent {
    glm::vec3 along_u{0.0f}; ///< not normalised; zero where the coordinates are degenerate
    int handedness = 0;      ///< +1, -1, or 0 where the coordinates are degenerate
};

TriangleTangent triangle_tangent(
    const std::array<glm::vec3, 3>& positions, const std::array<glm::vec2, 3>& uvs) {
    const glm::vec3 edge1 = positions[1] - positions[0], edge2 = positions[2] - positions[0];
    const glm::vec2 uv1 = uvs[1] - uvs[0], uv2 = uvs[2] - uvs[0];
    const float area = uv1.x * uv2.y - uv2.x * uv1.y;
    if (area == 0.0f || !std::isfinite(area)) return {};
    // Dividing by the area would only scale: its sign is what counts. v runs down in glTF, so that
    // a picture that is not mirrored has negative area on a counter-clockwise triangle.
    const glm::vec3 along_u = (edge1 * uv2.y - edge2 * uv1.y) * (area > 0.0f ? 1.0f : -1.0f);
    return {along_u, area < 0.0f ? 1 : -1};
}

} // namespace

void generate_flat_normals(Primitive& primitive) {
    const std::vector<std::uint32_t> sources = std::move(primitive.indices);
    primitive.normals.clear();
    primitive.tangents.clear();
    gather_vertices(primitive, sources);
    const std::size_t count = primitive.positions.size();
    primitive.indices.resize(count);
    primitive.normals.resize(count);
    for (std::size_t i = 0; i < count; ++i) primitive.indices[i] = static_cast<std::uint32_t>(i);
    for (std::size_t i = 0; i + 2 < count; i += 3) {
        const glm::vec3 edge1 = primitive.positions[i + 1] - primitive.positions[i];
        const glm::vec3 edge2 = primitive.positions[i + 2] - primitive.positions[i];
        const glm::vec3 across =
            glm::cross(direction_or(edge1, glm::vec3(0.0f)), direction_or(edge2, glm::vec3(0.0f)));
        const glm::vec3 normal = direction_or(across, kAnyNormal);
        std::fill_n(primitive.normals.begin() + static_cast<std::ptrdiff_t>(i), 3, normal);
    }
}

std::size_t repair_normals(Primitive& primitive) {
    const auto has_direction = [](glm::vec3 v) {
        return std::isfinite(v.x + v.y + v.z) && v != glm::vec3(0.0f);
    };
    const auto bad = static_cast<std::size_t>(std::count_if(primitive.normals.begin(),
        primitive.normals.end(), [&](glm::vec3 normal) { return !has_direction(normal); }));
    std::vector<glm::vec3> sums(bad != 0 ? primitive.positions.size() : 0, glm::vec3(0.0f));
    for (std::size_t i = 0; bad != 0 && i < primitive.indices.size(); i += 3) {
        const std::uint32_t* corner = &primitive.indices[i];
        const glm::vec3 origin = primitive.positions[corner[0]];
        const glm::vec3 across = glm::cross(
            primitive.positions[corner[1]] - origin, primitive.positions[corner[2]] - origin);
        for (int k = 0; k < 3; ++k) sums[corner[k]] += across;
    }
    for (std::size_t i = 0; i < primitive.normals.size(); ++i) {
        glm::vec3& normal = primitive.normals[i];
        normal = has_direction(normal) ? direction_or(normal, kAnyNormal)
                                       : direction_or(sums[i], kAnyNormal);
    }
    return bad;
}

void generate_tangents(Primitive& primitive, int uv_set) {
    check(uv_set == 0 || uv_set == 1, "generate_tangents: uv_set must be 0 or 1");
    check(primitive.normals.size() == primitive.positions.size(), "generate_tangents: no normals");
    check(primitive.uvs[uv_set].size() == primitive.positions.size(),
        "generate_tangents: no texture coordinates in that set");
    const std::size_t count = primitive.positions.size();

    // One sum per vertex and handedness: [0] for +1, [1] for -1.
    std::vector<std::array<glm::vec3, 2>> sums(count, {glm::vec3(0.0f), glm::vec3(0.0f)});
    std::vector<std::array<bool, 2>> present(count, {false, false});
    std::vector<int> handedness(primitive.triangles(), 0);
    for (std::size_t triangle = 0; triangle < primitive.triangles(); ++triangle) {
        const std::uint32_t* corner = &primitive.indices[3 * triangle];
        std::array<glm::vec3, 3> positions;
        std::array<glm::vec2, 3> uvs;
        for (int i = 0; i < 3; ++i) {
            positions[i] = primitive.positions[corner[i]];
            uvs[i] = primitive.uvs[uv_set][corner[i]];
        }
        const TriangleTangent tangent = triangle_tangent(positions, uvs);
        handedness[triangle] = tangent.handedness;
        if (tangent.handedness == 0) continue;
        const int side = tangent.handedness > 0 ? 0 : 1;
        for (int i = 0; i < 3; ++i) {
            const glm::vec3 normal = primitive.normals[corner[i]];
            const glm::vec3 in_plane = tangent.along_u - normal * glm::dot(normal, tangent.along_u);
            const float angle = angle_between(
                positions[(i + 1) % 3] - positions[i], positions[(i + 2) % 3] - positions[i]);
            sums[corner[i]][side] += angle * direction_or(in_plane, glm::vec3(0.0f));
            present[corner[i]][side] = true;
        }
    }

    // Vertices that have both get a twin for -1 at the end.
    std::vector<std::uint32_t> sources(count), twin(count);
    for (std::size_t i = 0; i < count; ++i) sources[i] = twin[i] = static_cast<std::uint32_t>(i);
    for (std::size_t i = 0; i < count; ++i) {
        if (!present[i][0] || !present[i][1]) continue;
        twin[i] = static_cast<std::uint32_t>(sources.size());
        sources.push_back(static_cast<std::uint32_t>(i));
    }
    for (std::size_t i = 0; i < primitive.indices.size(); ++i) {
        if (handedness[i / 3] < 0) primitive.indices[i] = twin[primitive.indices[i]];
    }
    primitive.tangents.clear();
    gather_vertices(primitive, sources);
    primitive.tangents.resize(sources.size());
    for (std::size_t i = 0; i < sources.size(); ++i) {
        const std::uint32_t source = sources[i];
        const int side = present[source][1] && (i >= count || !present[source][0]) ? 1 : 0;
        const glm::vec3 normal = primitive.normals[i];
        const glm::vec3 sum = sums[source][side] - normal * glm::dot(normal, sums[source][side]);
        const glm::vec3 tangent = direction_or(sum, any_perpendicular(normal));
        primitive.tangents[i] = glm::vec4(tangent, side == 0 ? 1.0f : -1.0f);
    }
}

std::size_t drop_degenerate_triangles(Primitive& primitive) {
    const std::size_t before = primitive.triangles();
    const std::size_t vertices = primitive.positions.size();
    std::size_t kept = 0;
    for (std::size_t triangle = 0; triangle < before; ++triangle) {
        const std::uint32_t a = primitive.indices[3 * triangle];
        const std::uint32_t b = primitive.indices[3 * triangle + 1];
        const std::uint32_t c = primitive.indices[3 * triangle + 2];
        if (std::max({a, b, c}) >= vertices || a == b || b == c || c == a) continue;
        primitive.indices[kept++] = a;
        primitive.indices[kept++] = b;
        primitive.indices[kept++] = c;
    }
    primitive.indices.resize(kept);
    return before - kept / 3;
}

std::size_t drop_unused_vertices(Primitive& primitive) {
    constexpr std::uint32_t kUnused = std::numeric_limits<std::uint32_t>::max();
    const std::size_t before = primitive.positions.size();
    std::vector<std::uint32_t> renamed(before, kUnused), sources;
    for (const std::uint32_t index : primitive.indices) renamed[index] = 0;
    for (std::size_t i = 0; i < before; ++i) {
        if (renamed[i] == kUnused) continue;
        renamed[i] = static_cast<std::uint32_t>(sources.size());
        sources.push_back(static_cast<std::uint32_t>(i));
    }
    if (sources.size() == before) return 0;
    for (std::uint32_t& index : primitive.indices) index = renamed[index];
    gather_vertices(primitive, sources);
    return before - sources.size();
}

} // namespace ockham
