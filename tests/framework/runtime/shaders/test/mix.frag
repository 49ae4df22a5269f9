// SPDX-License-Identifier: Apache-2.0
// Writes: colour and depth of each fragment, and its share of a storage target if there is one:
// hashes of all inputs of both stages and of the fragment's index.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "mix.glsl"

layout(location = 0) flat in uint inputs;
layout(location = 0) out float color;

void main() {
    const uint count = push.width * push.height;
    const uint index = uint(gl_FragCoord.y) * push.width + uint(gl_FragCoord.x);
    const uint h = mix_inputs(inputs, index, count);
#if defined(TARGET)
    const uint target_count = TARGET_COUNT;
    for (uint i = index; i < target_count; i += count) write_target(i, hash(h + i));
#endif
    if ((push.flags & 2) != 0 && (h & 1) != 0) discard;
    color = texel_of(h);
#if defined(DEPTH)
    gl_FragDepth = texel_of(hash(h) | 0x100); // above 0, to which depth is cleared
#endif
}
