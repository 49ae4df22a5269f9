// SPDX-License-Identifier: Apache-2.0
// reads rays (unit coordinates); writes walks: what goes wrong on the way from `near` to `far`.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "volume/cells.glsl"

layout(local_size_x = 64) in;

struct Ray {
    vec3 origin;
    vec3 direction;
    float near;
    float far;
};
struct Walk {
    float reached;   // t of the last exit
    float farthest;  // voxels that a place in a visited stretch lies outside its cell, at most
    float backwards; // greatest decrease of t from one exit to the next
    uint cells;      // visited
};

layout(scalar, binding = 10) readonly buffer Rays { Ray items[]; } rays;
layout(scalar, binding = 11) writeonly buffer Walks { Walk items[]; } walks;

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= rays.items.length()) return;
    Ray ray = rays.items[i];
    Walk result = Walk(ray.near, 0.0, 0.0, 0u);
    CellWalk walk = walk_cells(ray.origin, ray.direction, ray.near);
    float t = ray.near;
    while (t < ray.far && result.cells < 1000u) {
        float exit = cell_exit(walk), end = min(exit, ray.far);
        result.backwards = max(result.backwards, t - exit);
        if (end > t) {
            uint cell = cell_index(walk);
            uvec3 cells = frame.data.cells;
            vec3 first = vec3(cell % cells.x, cell / cells.x % cells.y, cell / (cells.x * cells.y)) *
                         float(RANGE_CELL);
            for (int k = 0; k <= 4; ++k) {
                vec3 place = ray.origin + mix(t, end, float(k) / 4.0) * ray.direction;
                vec3 voxel = place * vec3(frame.data.dims);
                vec3 outside = max(first - voxel, voxel - first - float(RANGE_CELL));
                result.farthest =
                    max(result.farthest, max(max(outside.x, outside.y), outside.z));
            }
        }
        t = max(t, exit);
        next_cell(walk);
        ++result.cells;
    }
    result.reached = t;
    walks.items[i] = result;
}
