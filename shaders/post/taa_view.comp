// SPDX-License-Identifier: Apache-2.0
// reads this frame's camera and the last one's; writes what the next frame needs to know, and how
// many frames the history holds: all since the camera stands still, else at most a few.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "post/taa.h"
#include "shared/frame.h"

layout(local_size_x = 8) in;

layout(scalar, binding = 0) uniform Frame { FrameData data; } frame;
layout(scalar, binding = 1) readonly buffer PreviousView { TaaView data; } previous_view;
layout(scalar, binding = 2) writeonly buffer View { TaaView data; } view;

void main() {
    if (gl_GlobalInvocationID.x > 0u) return;
    TaaView old = previous_view.data;
    bool still = old.position == frame.data.position && old.forward == frame.data.forward &&
                 old.right == frame.data.right && old.up == frame.data.up;
    uint frames = still ? old.frames : min(old.frames, TAA_MOVING_FRAMES - 1u);
    view.data = TaaView(frame.data.position, frame.data.right, frame.data.up, frame.data.forward, frames + 1u);
}
