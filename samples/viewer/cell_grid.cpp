// SPDX-License-Identifier: Apache-2.0
#include "samples/viewer/cell_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ockham::viewer {
namespace {

struct Ray {
    glm::dvec3 origin, direction;
};

Ray ray_of(const Camera& camera, glm::ivec2 size, glm::ivec2 pixel) {
    const glm::dvec3 forward(camera.forward), up(camera.up), right = glm::cross(forward, up);
    const double y = 1 - 2 * (pixel.y + 0.5) / size.y,
                 x = (2 * (pixel.x + 0.5) / size.x - 1) * size.x / size.y;
    if (camera.orthographic_height > 0) {
        const double half = 0.5 * static_cast<double>(camera.orthographic_height);
        return {glm::dvec3(camera.position) + half * (x * right + y * up), forward};
    }
    const double half = std::tan(0.5 * glm::radians(static_cast<double>(camera.fov_y_degrees)));
    return {glm::dvec3(camera.position), forward + half * (x * right + y * up)};
}

template <class Put>
void for_each_pixel(glm::ivec2 size, Put put) {
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) put(glm::ivec2(x, y));
}

} // namespace

/// Amanatides and Woo 1987, in units of cells.
void walk(const CellGrid& grid, const Camera& camera, glm::ivec2 size, glm::ivec2 pixel,
    const std::function<bool(std::size_t cell)>& visit) {
    const Ray world = ray_of(camera, size, pixel);
    const glm::dmat3 to_unit = glm::inverse(grid.place.edges);
    const glm::dvec3 scale = glm::dvec3(grid.dims) / static_cast<double>(grid.side);
    const glm::dvec3 origin = to_unit * (world.origin - grid.place.corner) * scale,
                     direction = to_unit * world.direction * scale;
    double enter = 0, leave = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
        const double a = -origin[axis] / direction[axis],
                     b = (scale[axis] - origin[axis]) / direction[axis];
        if (direction[axis] == 0) {
            if (origin[axis] < 0 || origin[axis] > scale[axis]) return;
            continue;
        }
        enter = std::max(enter, std::min(a, b));
        leave = std::min(leave, std::max(a, b));
    }
    if (!(enter < leave)) return;

    const glm::ivec3 cells(grid.cells());
    const glm::dvec3 first = origin + enter * direction;
    glm::ivec3 cell = glm::clamp(glm::ivec3(glm::floor(first)), glm::ivec3(0), cells - 1);
    glm::ivec3 step(0);
    glm::dvec3 next(std::numeric_limits<double>::infinity()), each = next;
    for (int axis = 0; axis < 3; ++axis) {
        if (direction[axis] == 0) continue;
        step[axis] = direction[axis] > 0 ? 1 : -1;
        next[axis] = (cell[axis] + (direction[axis] > 0 ? 1 : 0) - origin[axis]) / direction[axis];
        each[axis] = 1 / std::abs(direction[axis]);
    }
    for (;;) {
        const glm::ivec3 stride(1, cells.x, cells.x * cells.y);
        if (!visit(static_cast<std::size_t>(glm::dot(glm::dvec3(cell), glm::dvec3(stride)))))
            return;
        int axis = next.x < next.y ? 0 : 1;
        if (next.z < next[axis]) axis = 2;
        cell[axis] += step[axis];
        next[axis] += each[axis];
        if (cell[axis] < 0 || cell[axis] >= cells[axis]) return;
    }
}

Image count_cells(const CellGrid& grid, const Camera& camera, glm::ivec2 size,
    const std::function<bool(std::size_t cell)>& counts) {
    Image image(size.x, size.y, {"cells"});
    for_each_pixel(size, [&](glm::ivec2 pixel) {
        float& sum = image.at(pixel.x, pixel.y, 0);
        walk(grid, camera, size, pixel, [&](std::size_t cell) {
            if (counts(cell)) ++sum;
            return true;
        });
    });
    return image;
}

Image color_cells(const CellGrid& grid, const Camera& camera, glm::ivec2 size,
    const std::function<bool(std::size_t cell)>& counts) {
    Image image(size.x, size.y, {"R", "G", "B"});
    for_each_pixel(size, [&](glm::ivec2 pixel) {
        walk(grid, camera, size, pixel, [&](std::size_t cell) {
            if (!counts(cell)) return true;
            auto hash = static_cast<std::uint32_t>(cell) * 2654435761u; // Knuth's multiplier
            hash ^= hash >> 15;
            for (int c = 0; c < 3; ++c)
                image.at(pixel.x, pixel.y, c) =
                    0.25f + 0.7f * static_cast<float>((hash >> (8 * c)) & 255u) / 255.0f;
            return false;
        });
    });
    return image;
}

} // namespace ockham::viewer
