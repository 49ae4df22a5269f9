// SPDX-License-Identifier: Apache-2.0
// reads places (unit coordinates); writes probes: field, extinction and majorant there, and the cell.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "volume/cells.glsl"

layout(local_size_x = 64) in;

struct Probe {
    float field;
    float sigma_t;
    float majorant;
    uint cell;
};

layout(scalar, binding = 10) readonly buffer Places { vec3 items[]; } places;
layout(scalar, binding = 11) writeonly buffer Probes { Probe items[]; } probes;

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= places.items.length()) return;
    vec3 unit = places.items[i];
    CellWalk walk = walk_cells(unit, vec3(1.0, 0.0, 0.0), 0.0);
    float value = field(unit);
    uint cell = cell_index(walk);
    probes.items[i] = Probe(value, medium_of(value).sigma_t, enter_cell(walk), cell);
}
