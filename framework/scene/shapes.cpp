// SPDX-License-Identifier: Apache-2.0
#include "framework/scene/shapes.hpp"

#include "framework/core/error.hpp"

#include <array>
#include <cmath>
#include <utility>

namespace ockham {

namespace {

double snap(double metres) { return std::floor(metres * 65536.0 + 0.5) / 65536.0; }

/// One side of a profile: the normals it is shaded with, and the lengths up to its ends.
struct Segment {
    glm::dvec2 begin, end;
    glm::dvec2 begin_normal, end_normal;
    double begin_length, end_length;

    glm::dvec2 flat_normal() const {
        return glm::dvec2(end.y - begin.y, begin.x - end.x) / (end_length - begin_length);
    }
};

std::vector<Segment> segments_of(const Profile& profile) {
    constexpr double kSmoothCosine = 0.64; // 50 degrees
    const std::size_t count = profile.points.size();
    std::vector<Segment> segments;
    double length = 0.0;
    for (std::size_t i = 0; i + 1 < count + (profile.closed ? 1 : 0); ++i) {
        const glm::dvec2 begin = profile.points[i];
        const glm::dvec2 end = profile.points[(i + 1) % count];
        const glm::dvec2 step = end - begin;
        const double step_length = std::sqrt(glm::dot(step, step));
        check(step_length > 0.0, "profile: two equal points in a row");
        const glm::dvec2 normal = glm::dvec2(step.y, -step.x) / step_length;
        segments.push_back({begin, end, normal, normal, length, length + step_length});
        length += step_length;
    }
    for (std::size_t i = profile.closed ? 0 : 1; i < segments.size(); ++i) {
        auto& previous = segments[(i + segments.size() - 1) % segments.size()];
        auto& next = segments[i];
        const glm::dvec2 a = previous.flat_normal();
        const glm::dvec2 b = next.flat_normal();
        if (glm::dot(a, b) < kSmoothCosine) continue;
        const glm::dvec2 sum = a + b;
        previous.end_normal = next.begin_normal = sum / std::sqrt(glm::dot(sum, sum));
    }
    return segments;
}

} // namespace

glm::dvec2 unit_at(double turns) {
    turns -= std::floor(turns);
    const int quarter = static_cast<int>(turns * 4.0 + 0.5); // nearest quarter turn, 0 ... 4
    const double angle = (turns - 0.25 * quarter) * (2.0 * std::numbers::pi);
    const double square = angle * angle;
    double cosine = 0.0;
    double sine = 0.0;
    for (int term = 9; term >= 1; --term) { // Taylor series, |angle| <= pi/4
        cosine = (1.0 + cosine) * -square / ((2 * term - 1) * (2 * term));
        sine = (1.0 + sine) * -square / ((2 * term) * (2 * term + 1));
    }
    cosine = 1.0 + cosine;
    sine = angle * (1.0 + sine);
    switch (quarter & 3) {
    case 0:
        return {cosine, sine};
    case 1:
        return {-sine, cosine};
    case 2:
        return {-cosine, -sine};
    default:
        return {sine, -cosine};
    }
}

Shape::Shape(int material, double metres_per_tile) : metres_per_tile_(metres_per_tile) {
    primitive_.material = material;
}

std::uint32_t Shape::add(const ShapeVertex& vertex) {
    const glm::dvec3 n = glm::normalize(vertex.normal);
    const glm::dvec3 t = glm::normalize(vertex.tangent - n * glm::dot(n, vertex.tangent));
    const glm::dvec3 p = vertex.position;
    primitive_.positions.emplace_back(snap(p.x), snap(p.y), snap(p.z));
    primitive_.normals.emplace_back(n);
    primitive_.tangents.emplace_back(t.x, t.y, t.z, 1.0);
    primitive_.uvs[0].emplace_back(vertex.uv / metres_per_tile_);
    return static_cast<std::uint32_t>(primitive_.positions.size() - 1);
}

void Shape::triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    const auto& p = primitive_.positions;
    if (p[a] == p[b] || p[b] == p[c] || p[c] == p[a]) return;
    primitive_.indices.insert(primitive_.indices.end(), {a, b, c});
}

Primitive Shape::take() {
    const int material = primitive_.material;
    Primitive result = std::exchange(primitive_, Primitive{});
    primitive_.material = material;
    return result;
}

void add_polygon(Shape& shape, std::span<const glm::dvec3> corners) {
    const glm::dvec3 normal =
        glm::normalize(glm::cross(corners[1] - corners[0], corners[2] - corners[0]));
    const bool level = std::abs(normal.y) > 0.99;
    const glm::dvec3 tangent =
        level ? glm::dvec3(1, 0, 0) : glm::normalize(glm::cross(glm::dvec3(0, 1, 0), normal));
    const glm::dvec3 bitangent = glm::cross(normal, tangent);
    std::vector<std::uint32_t> ids;
    for (const glm::dvec3& corner : corners)
        ids.push_back(shape.add(
            {corner, normal, tangent, {glm::dot(corner, tangent), -glm::dot(corner, bitangent)}}));
    for (std::size_t i = 2; i < ids.size(); ++i) shape.triangle(ids[0], ids[i - 1], ids[i]);
}

void add_quad(Shape& shape, glm::dvec3 a, glm::dvec3 b, glm::dvec3 c, glm::dvec3 d) {
    add_polygon(shape, std::array{a, b, c, d});
}

void add_box(Shape& shape, glm::dvec3 low, glm::dvec3 high) {
    const auto [x0, y0, z0] = std::array{low.x, low.y, low.z};
    const auto [x1, y1, z1] = std::array{high.x, high.y, high.z};
    add_quad(shape, {x0, y0, z1}, {x1, y0, z1}, {x1, y1, z1}, {x0, y1, z1});
    add_quad(shape, {x1, y0, z0}, {x0, y0, z0}, {x0, y1, z0}, {x1, y1, z0});
    add_quad(shape, {x1, y0, z1}, {x1, y0, z0}, {x1, y1, z0}, {x1, y1, z1});
    add_quad(shape, {x0, y0, z0}, {x0, y0, z1}, {x0, y1, z1}, {x0, y1, z0});
    add_quad(shape, {x0, y1, z1}, {x1, y1, z1}, {x1, y1, z0}, {x0, y1, z0});
    add_quad(shape, {x0, y0, z0}, {x1, y0, z0}, {x1, y0, z1}, {x0, y0, z1});
}

void add_prism(Shape& shape, std::span<const glm::dvec2> outline, double back, double front) {
    std::vector<glm::dvec3> front_face, back_face;
    for (std::size_t i = 0; i < outline.size(); ++i) {
        const glm::dvec2 a = outline[i];
        const glm::dvec2 b = outline[(i + 1) % outline.size()];
        front_face.emplace_back(a, front);
        back_face.insert(back_face.begin(), glm::dvec3(a, back));
        add_quad(shape, {a, back}, {b, back}, {b, front}, {a, front});
    }
    add_polygon(shape, front_face);
    add_polygon(shape, back_face);
}

Profile circle_profile(double radius, int sides) {
    Profile circle{.points = {}, .closed = true};
    for (int i = 0; i < sides; ++i) circle.points.push_back(radius * unit_at(double(i) / sides));
    return circle;
}

void add_sweep(Shape& shape, std::span<const Frame> path, const Profile& profile) {
    for (const auto& segment : segments_of(profile)) {
        const auto vertex_at = [&](int i, int j) {
            const Frame& frame = path[i];
            const glm::dvec2 point = j == 0 ? segment.begin : segment.end;
            const glm::dvec2 normal = j == 0 ? segment.begin_normal : segment.end_normal;
            const glm::dvec3 forward = glm::cross(frame.right, frame.up);
            return ShapeVertex{frame.position + frame.right * point.x + frame.up * point.y +
                                   forward * (frame.mitre * point.x),
                frame.right * normal.x + frame.up * normal.y, forward,
                {frame.u, j == 0 ? segment.begin_length : segment.end_length}};
        };
        add_grid(shape, static_cast<int>(path.size()) - 1, 1, vertex_at);
    }
}

void add_lathe(Shape& shape, glm::dvec3 center, const Profile& profile, int sides) {
    double radius = 0.0;
    for (const glm::dvec2& point : profile.points) radius = std::max(radius, point.x);
    // A whole number of tiles, so that the texture meets itself.
    const double tile = shape.metres_per_tile();
    const double tiles = std::max(1.0, std::floor(radius * 2.0 * std::numbers::pi / tile + 0.5));
    std::vector<Frame> path;
    for (int i = 0; i <= sides; ++i) {
        const glm::dvec2 a = unit_at(double(i) / sides);
        path.push_back({center, {a.x, 0, a.y}, {0, 1, 0}, tiles * tile * i / sides, 0.0});
    }
    add_sweep(shape, path, profile);
}

void add_rod(Shape& shape, glm::dvec3 a, glm::dvec3 b, double radius, int sides) {
    const glm::dvec3 forward = glm::normalize(b - a);
    const glm::dvec3 helper = std::abs(forward.y) > 0.9 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
    const glm::dvec3 right = glm::normalize(glm::cross(helper, forward));
    const glm::dvec3 up = glm::cross(forward, right);
    const double length = std::sqrt(glm::dot(b - a, b - a));
    const Profile circle = circle_profile(radius, sides);
    add_sweep(
        shape, std::array{Frame{a, right, up, 0.0, 0.0}, Frame{b, right, up, length, 0.0}}, circle);
    std::vector<glm::dvec3> begin, end;
    for (const glm::dvec2& point : circle.points) {
        const glm::dvec3 offset = right * point.x + up * point.y;
        begin.insert(begin.begin(), a + offset);
        end.push_back(b + offset);
    }
    add_polygon(shape, begin);
    add_polygon(shape, end);
}

glm::mat4 placement(glm::dvec3 position, double turns, double scale) {
    const glm::dvec2 a = unit_at(turns) * scale;
    return glm::mat4(glm::dmat4({a.x, 0, -a.y, 0}, {0, scale, 0, 0}, {a.y, 0, a.x, 0},
        {snap(position.x), snap(position.y), snap(position.z), 1}));
}

} // namespace ockham
