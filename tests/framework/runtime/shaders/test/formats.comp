// SPDX-License-Identifier: Apache-2.0
// Writes: target, (1, 0.5, 0.25, 0) in the format of the variant.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/types.h"

layout(local_size_x = 8, local_size_y = 8) in;
#if defined(R8)
layout(binding = 0, r8) uniform writeonly image2D target;
#elif defined(RG8)
layout(binding = 0, rg8) uniform writeonly image2D target;
#elif defined(RGBA8)
layout(binding = 0, rgba8) uniform writeonly image2D target;
#elif defined(R16F)
layout(binding = 0, r16f) uniform writeonly image2D target;
#elif defined(RG16F)
layout(binding = 0, rg16f) uniform writeonly image2D target;
#elif defined(RGBA16F)
layout(binding = 0, rgba16f) uniform writeonly image2D target;
#elif defined(R32F)
layout(binding = 0, r32f) uniform writeonly image2D target;
#elif defined(RG32F)
layout(binding = 0, rg32f) uniform writeonly image2D target;
#elif defined(RGBA32F)
layout(binding = 0, rgba32f) uniform writeonly image2D target;
#elif defined(R8UI)
layout(binding = 0, r8ui) uniform writeonly uimage2D target;
#elif defined(R32UI)
layout(binding = 0, r32ui) uniform writeonly uimage2D target;
#elif defined(RGBA32UI)
layout(binding = 0, rgba32ui) uniform writeonly uimage2D target;
#endif

void main() {
    const ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(target)))) return;
#if defined(R8UI) || defined(R32UI) || defined(RGBA32UI)
    imageStore(target, pixel, uvec4(7, 70, 200, 70000) + uint(pixel.x));
#else
    imageStore(target, pixel, vec4(1.0, 0.5, 0.25, 0.0));
#endif
}
