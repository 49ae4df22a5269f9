// SPDX-License-Identifier: Apache-2.0
// Two triangles for each side of the box that the medium is cropped to, wound inwards: those that face
// the camera are its far sides, which are there from inside as well.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "shared/frame.h"
#include "shared/volume.h"

layout(scalar, binding = 0) uniform Frame { FrameData data; } frame;
layout(scalar, binding = 10) uniform MediumFrame { VolumeFrame data; } medium_frame;

void main() {
    const int kCorners[6] = int[](0, 1, 2, 0, 2, 3);
    int axis = gl_VertexIndex / 12, side = (gl_VertexIndex / 6) & 1, i = gl_VertexIndex % 6;
    mat3 edges = medium_frame.data.world_from_unit;
    bool turned = (side == 0) == (determinant(edges) < 0.0);
    int corner = kCorners[turned ? 5 - i : i];
    vec3 unit;
    unit[axis] = float(side);
    unit[(axis + 1) % 3] = corner == 1 || corner == 2 ? 1.0 : 0.0;
    unit[(axis + 2) % 3] = corner >= 2 ? 1.0 : 0.0;
    unit = mix(medium_frame.data.crop_min, medium_frame.data.crop_max, unit);
    gl_Position = frame.data.view_projection * vec4(medium_frame.data.corner + edges * unit, 1.0);
}
