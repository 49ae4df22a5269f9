// SPDX-License-Identifier: Apache-2.0
// reads volume; writes ranges: per cell, least and greatest of the texels that a trilinear lookup in
// it can touch, 8i - 1 ... 8i + 8 along each axis, clamped like the lookup.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "shared/volume.h"
#include "volume/ranges.h"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 1) uniform sampler3D volume;
layout(scalar, binding = 10) writeonly buffer Ranges { vec2 cells[]; } ranges;
layout(push_constant, scalar) uniform Push { RangesPush push; };

void main() {
    uvec3 cell = gl_GlobalInvocationID;
    if (any(greaterThanEqual(cell, push.cells))) return;

    const int side = RANGE_CELL + 2;
    ivec3 first = ivec3(cell) * RANGE_CELL - 1;
    vec2 range = vec2(uintBitsToFloat(0x7f800000u), uintBitsToFloat(0xff800000u)); // +-infinity
    for (int i = 0; i < side * side * side; ++i) {
        ivec3 texel = first + ivec3(i % side, i / side % side, i / (side * side));
        float value =
            texelFetch(volume, clamp(texel, ivec3(0), ivec3(push.dims) - 1), 0).x;
        range = vec2(min(range.x, value), max(range.y, value));
    }
    ranges.cells[(cell.z * push.cells.y + cell.y) * push.cells.x + cell.x] = range;
}
