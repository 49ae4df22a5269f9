// SPDX-License-Identifier: Apache-2.0
// Walks a ray through the cells of RANGE_CELL^3 voxels that ranges and majorants are kept for:
// Amanatides and Woo 1987, with every crossing computed from the ray itself, so that nothing drifts.
//   reads ranges (SURFACES), majorants (GRID; without it the medium has one, frame.majorant)
// A cell holds what its lookups can touch, half a voxel beyond its walls included, so a position
// that rounding has put into the neighbour is still inside its bounds.
#ifndef OCKHAM_VOLUME_CELLS_GLSL
#define OCKHAM_VOLUME_CELLS_GLSL

#include "volume/medium.glsl"

#ifdef SURFACES
layout(scalar, binding = 4) readonly buffer Ranges { vec2 cells[]; } ranges; // least, greatest
/// Least and greatest texel value that the field takes in a cell.
vec2 cell_range(uint cell) { return ranges.cells[cell]; }
#endif
#ifdef GRID
layout(scalar, binding = 5) readonly buffer Majorants { float cells[]; } majorants; // opacity
#endif

struct CellWalk {
    vec3 origin;    // in cells
    vec3 direction; // cells per world unit
    ivec3 cell;
    vec3 exits; // t where the ray crosses the cell's wall of each axis
};

float wall_crossing(CellWalk walk, int axis) {
    float d = walk.direction[axis];
    float wall = float(walk.cell[axis] + (d > 0.0 ? 1 : 0));
    return d == 0.0 ? kInfinity : (wall - walk.origin[axis]) / d;
}

/// Stands in the cell at `t` of a ray; the nearest one where that is outside the box.
CellWalk walk_cells(vec3 unit_origin, vec3 unit_direction, float t) {
    vec3 cells_per_unit = vec3(frame.data.dims) / float(RANGE_CELL);
    CellWalk walk;
    walk.origin = unit_origin * cells_per_unit;
    walk.direction = unit_direction * cells_per_unit;
    walk.cell = clamp(ivec3(floor(walk.origin + t * walk.direction)), ivec3(0),
        ivec3(frame.data.cells) - 1);
    walk.exits = vec3(wall_crossing(walk, 0), wall_crossing(walk, 1), wall_crossing(walk, 2));
    return walk;
}

/// Of the buffers; beyond the box, the nearest cell.
uint cell_index(CellWalk walk) {
    uvec3 cell = uvec3(clamp(walk.cell, ivec3(0), ivec3(frame.data.cells) - 1));
    return (cell.z * frame.data.cells.y + cell.y) * frame.data.cells.x + cell.x;
}

/// t where the ray leaves the cell; by rounding it may lie a little before the t of walk_cells().
float cell_exit(CellWalk walk) { return min(min(walk.exits.x, walk.exits.y), walk.exits.z); }

/// To the cell behind the exit. Each call leaves the box further behind: walks end.
void next_cell(inout CellWalk walk) {
    int axis = walk.exits.x <= walk.exits.y ? (walk.exits.x <= walk.exits.z ? 0 : 2)
                                            : (walk.exits.y <= walk.exits.z ? 1 : 2);
    walk.cell[axis] += walk.direction[axis] > 0.0 ? 1 : -1;
    walk.exits[axis] = wall_crossing(walk, axis);
}

/// The cell of a walk that is interrupted, and the walk that goes on there: at most 1022 cells along
/// each axis, and one around the box.
uint pack_cell(CellWalk walk) {
    uvec3 cell = uvec3(clamp(walk.cell, ivec3(-1), ivec3(1022)) + 1);
    return cell.x | cell.y << 10 | cell.z << 20;
}
CellWalk resume_walk(vec3 unit_origin, vec3 unit_direction, uint packed_cell) {
    CellWalk walk = walk_cells(unit_origin, unit_direction, 0.0);
    walk.cell = ivec3(packed_cell & 1023u, packed_cell >> 10 & 1023u, packed_cell >> 20) - 1;
    walk.exits = vec3(wall_crossing(walk, 0), wall_crossing(walk, 1), wall_crossing(walk, 2));
    return walk;
}

/// Extinction per world unit that is nowhere exceeded in a cell.
float cell_majorant(uint cell) {
#ifdef GRID
    return frame.data.density_scale * majorants.cells[cell];
#else
    return frame.data.majorant;
#endif
}

/// How far cell_majorant() holds: one majorant of all holds for ever.
float majorant_exit(CellWalk walk) {
#ifdef GRID
    return cell_exit(walk);
#else
    return kInfinity;
#endif
}

#endif
