// SPDX-License-Identifier: Apache-2.0
// Pieces of geometry for built-in scenes: boxes, turned and swept profiles, grids, with normals,
// tangents and texture coordinates. Not a modelling library. All arithmetic is +, -, *, / and
// square root of doubles, so that equal input gives equal bits on every machine.
#pragma once

#include "framework/scene/scene.hpp"

#include <glm/glm.hpp>

#include <cstdint>
#include <numbers>
#include <span>
#include <vector>

namespace ockham {

/// (cos, sin) of an angle in full turns; exact at multiples of a quarter.
glm::dvec2 unit_at(double turns);

/// A corner of a surface. The texture's u grows along `tangent` and its v against
/// cross(normal, tangent), so that the handedness is +1 everywhere: green of a normal map points
/// up in the image, as glTF wants it.
struct ShapeVertex {
    glm::dvec3 position{0.0}; ///< metres
    glm::dvec3 normal{0.0, 1.0, 0.0};
    glm::dvec3 tangent{1.0, 0.0, 0.0}; ///< made perpendicular to `normal` when added
    glm::dvec2 uv{0.0};                ///< metres
};

/// Collects the triangles of one material. Positions are rounded to 1/65536 m, so that edges
/// computed in two ways still meet.
class Shape {
public:
    /// `metres_per_tile`: width of one repetition of the material's texture, > 0.
    explicit Shape(int material, double metres_per_tile = 1.0);

    std::uint32_t add(const ShapeVertex& vertex);
    /// Counter-clockwise seen from the front. Dropped when two corners coincide.
    void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c);
    double metres_per_tile() const { return metres_per_tile_; }
    /// The result; the shape is empty afterwards.
    Primitive take();

private:
    Primitive primitive_;
    double metres_per_tile_;
};

/// Convex, flat polygon, counter-clockwise seen from the front, at least 3 corners. Texture
/// coordinates are the position in metres, u horizontal.
void add_polygon(Shape& shape, std::span<const glm::dvec3> corners);
void add_quad(Shape& shape, glm::dvec3 a, glm::dvec3 b, glm::dvec3 c, glm::dvec3 d);

/// All six sides of an axis-aligned box.
void add_box(Shape& shape, glm::dvec3 low, glm::dvec3 high);

/// Grid of columns x rows quads; `vertex_at(i, j)` with i to the right and j down as seen from
/// the front.
template <class VertexAt>
void add_grid(Shape& shape, int columns, int rows, VertexAt&& vertex_at) {
    std::vector<std::uint32_t> ids;
    for (int j = 0; j <= rows; ++j)
        for (int i = 0; i <= columns; ++i) ids.push_back(shape.add(vertex_at(i, j)));
    const int stride = columns + 1;
    for (int j = 0; j < rows; ++j)
        for (int i = 0; i < columns; ++i) {
            const int top = j * stride + i;
            const int low = top + stride;
            shape.triangle(ids[low], ids[low + 1], ids[top + 1]);
            shape.triangle(ids[low], ids[top + 1], ids[top]);
        }
}

/// Convex outline in the xy plane, counter-clockwise seen from +z, extruded from z = back to front.
void add_prism(Shape& shape, std::span<const glm::dvec2> outline, double back, double front);

/// A cross section in the plane of a frame's `right` (x) and `up` (y); the outside lies to the
/// right of the direction of travel, so a counter-clockwise loop encloses the solid.
struct Profile {
    std::vector<glm::dvec2> points; ///< metres
    bool closed = false;            ///< the last point joins the first
};
Profile circle_profile(double radius, int sides);

/// Where a swept profile stands. `right`, `up`: unit, perpendicular; the sweep moves along
/// cross(right, up).
struct Frame {
    glm::dvec3 position{0.0};
    glm::dvec3 right{1.0, 0.0, 0.0};
    glm::dvec3 up{0.0, 1.0, 0.0};
    double u = 0.0;     ///< metres along the path, for the texture
    double mitre = 0.0; ///< forward shift per metre of profile x
};

/// Surface of a profile moved along two or more frames. Corners of the profile below 50 degrees
/// are shaded smooth, others sharp; along the path everything is smooth. A closed path repeats
/// its first frame at the end (with its own u).
void add_sweep(Shape& shape, std::span<const Frame> path, const Profile& profile);

/// Profile of (radius, height) turned about the y axis through `center`, given bottom to top for
/// an outside. Texture u wraps around a whole number of times.
void add_lathe(Shape& shape, glm::dvec3 center, const Profile& profile, int sides);

/// Round bar from `a` to `b`, closed at both ends.
void add_rod(Shape& shape, glm::dvec3 a, glm::dvec3 b, double radius, int sides);

/// Matrix that turns about y by `turns` and then moves to `position`.
glm::mat4 placement(glm::dvec3 position, double turns = 0.0, double scale = 1.0);

} // namespace ockham
