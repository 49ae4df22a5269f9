// SPDX-License-Identifier: Apache-2.0
// Walks a ray through the cells of RANGE_CELL^3 voxels that ranges and majorants are kept for:
// Amanatides and Woo 1987, with every crossing computed from the ray itself, so that nothing drifts.
// Where cells are empty, a step leaves a whole cube of them (Cohen and Sheffer 1994).
//   reads ranges (SURFACES), majorants (GRID; without it the medium has one, frame.majorant)
// A cell holds what its lookups can touch, half a voxel beyond its walls included, so a position
// that rounding has put into the neighbour is still inside its bounds.
#ifndef OCKHAM_VOLUME_CELLS_GLSL
#define OCKHAM_VOLUME_CELLS_GLSL

#include "volume/medium.glsl"

#ifdef SURFACES
layout(scalar, binding = MEDIUM_BINDING + 4) readonly buffer Ranges { vec2 cells[]; } ranges; // least, greatest
/// Least and greatest texel value that the field takes in a cell.
vec2 cell_range(uint cell) { return ranges.cells[cell]; }
#endif
#ifdef GRID
// Greatest opacity in a cell; of an empty one, minus how many cells around it are empty as well, along
// each axis and diagonally.
layout(scalar, binding = MEDIUM_BINDING + 5) readonly buffer Majorants { float cells[]; } majorants;
#endif

struct CellWalk {
    vec3 origin;    // in cells
    vec3 direction; // cells per world unit
    vec3 inverse;   // of that; finite
    ivec3 cell;
    int reach; // the next step leaves the cells up to so many away as well
};

/// Stands in the cell at `t` of a ray; the nearest one where that is outside the box.
CellWalk walk_cells(vec3 unit_origin, vec3 unit_direction, float t) {
    vec3 cells_per_unit = vec3(constants.dims) / float(RANGE_CELL);
    CellWalk walk;
    walk.origin = unit_origin * cells_per_unit;
    walk.direction = unit_direction * cells_per_unit;
    bvec3 parallel = lessThan(abs(walk.direction), vec3(1e-20));
    walk.inverse = 1.0 / mix(walk.direction, vec3(1e-20), parallel);
    walk.cell = clamp(ivec3(floor(walk.origin + t * walk.direction)), ivec3(0),
        ivec3(constants.cells) - 1);
    walk.origin = mix(walk.origin, vec3(walk.cell) + 0.5, parallel); // never met, also from a wall
    walk.reach = 0;
    return walk;
}

/// Of the buffers; beyond the box, the nearest cell.
uint cell_index(CellWalk walk) {
    uvec3 cell = uvec3(clamp(walk.cell, ivec3(0), ivec3(constants.cells) - 1));
    return (cell.z * constants.cells.y + cell.y) * constants.cells.x + cell.x;
}

/// t where the ray crosses, of each axis, the wall that it leaves the cell and those in reach by.
vec3 cell_exits(CellWalk walk) {
    vec3 wall = mix(vec3(-walk.reach), vec3(1 + walk.reach), greaterThanEqual(walk.inverse, vec3(0.0)));
    return (vec3(walk.cell) + wall - walk.origin) * walk.inverse;
}
/// The first of them; by rounding it may lie a little before the t of walk_cells().
float cell_exit(CellWalk walk) {
    vec3 exits = cell_exits(walk);
    return min(min(exits.x, exits.y), exits.z);
}

/// To the cell behind the exit. Each call leaves the box further behind: walks end.
void next_cell(inout CellWalk walk) {
    vec3 exits = cell_exits(walk);
    float exit = min(min(exits.x, exits.y), exits.z);
    ivec3 beyond = walk.cell + mix(ivec3(-1 - walk.reach), ivec3(1 + walk.reach),
        greaterThanEqual(walk.inverse, vec3(0.0)));
    ivec3 beside = clamp(ivec3(floor(walk.origin + exit * walk.direction)), walk.cell - walk.reach,
        walk.cell + walk.reach);
    walk.cell = mix(beside, beyond, lessThanEqual(exits, vec3(exit)));
    walk.reach = 0;
}

/// The cell of a walk that is interrupted, and the walk that goes on there: at most 1022 cells along
/// each axis, and one around the box.
uint pack_cell(CellWalk walk) {
    uvec3 cell = uvec3(clamp(walk.cell, ivec3(-1), ivec3(1022)) + 1);
    return cell.x | cell.y << 10 | cell.z << 20;
}
ivec3 unpack_cell(uint packed_cell) {
    return ivec3(packed_cell & 1023u, packed_cell >> 10 & 1023u, packed_cell >> 20) - 1;
}
CellWalk resume_walk(vec3 unit_origin, vec3 unit_direction, uint packed_cell) {
    CellWalk walk = walk_cells(unit_origin, unit_direction, 0.0);
    walk.cell = unpack_cell(packed_cell);
    return walk;
}

/// Extinction per world unit that is nowhere exceeded before majorant_exit(). Where a cell is empty,
/// the walk's next step leaves all that is empty around it.
float enter_cell(inout CellWalk walk) {
#ifdef GRID
    float opacity = majorants.cells[cell_index(walk)];
    walk.reach = int(max(-opacity, 0.0));
    return constants.density_scale * max(opacity, 0.0);
#else
    return constants.majorant;
#endif
}

/// How far enter_cell() holds: one majorant of all holds for ever.
float majorant_exit(CellWalk walk) {
#ifdef GRID
    return cell_exit(walk);
#else
    return kInfinity;
#endif
}

#endif
