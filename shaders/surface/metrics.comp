// SPDX-License-Identifier: Apache-2.0
// reads the G-buffer's window of a pixel and S around it; writes k, samples to shade there.
//   k_d = c_d (sum d^2 / n - (sum d / n)^2)                      d: view depth
//   k_n = c_n sqrt(1 - min |mean . normal|)                      mean: normalised
//   k_s = r < max(t_min, l_max t_edge) ? 0 : c_s r               r: range of luma in S
//   k   = clamp(ceil(max(k_d, k_n, k_s)), 1, n)
// Hollaender et al. 2013, section 3.1, to the letter but for windows of sky. Its weaknesses (fp32
// cancellation in k_d, no scale invariance, the dead zone of k_s, a fold that k_n cannot see) are
// asserted by tests.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "include/color.glsl"
#include "shared/frame.h"
#include "surface/metrics.h"

layout(local_size_x = 8, local_size_y = 8) in;

layout(scalar, binding = 0) uniform Frame { FrameData data; } frame;
#include "surface/surface_sample.glsl"
layout(binding = 4) uniform sampler2D first_sample;
layout(binding = 5, r8ui) uniform writeonly uimage2D sample_count;
#ifdef WINNER
layout(binding = 6, r8ui) uniform writeonly uimage2D winner;
#endif
layout(push_constant, scalar) uniform Push { MetricsPush push; };

float luma_at(ivec2 pixel) {
    ivec2 inside = clamp(pixel, ivec2(0), ivec2(frame.data.size) - 1);
    return luma(texelFetch(first_sample, inside, 0).rgb);
}

/// A comparison with NaN is false: what cannot be measured asks for nothing.
float finite_or_zero(float x) { return x > 0.0 && x < 3.4e38 ? x : 0.0; }

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, ivec2(frame.data.size)))) return;
    int m = int(frame.data.m);
    float n = float(m * m);

    float depth_sum = 0.0, depth2_sum = 0.0;
    vec3 normal_sum = vec3(0.0);
    uint first_word = 0u, hits = 0u;
    bool normals_differ = false;
    for (int i = 0; i < m * m; ++i) {
        ivec2 position = pixel * m + window_offset(i);
        float stored = fetch_depth(position);
        float d = view_depth(stored);
        depth_sum += d;
        depth2_sum += d * d;
        if (stored > 0.0) {
            uint word = fetch_normal_word(position);
            normals_differ = normals_differ || (hits > 0u && word != first_word);
            first_word = word;
            ++hits;
            normal_sum += unpack_normal(word);
        }
    }
    float mean_depth = depth_sum / n;
    // Sky alone has one depth; rounding the sums of a far background would say otherwise.
    float variance = hits == 0u ? 0.0 : depth2_sum / n - mean_depth * mean_depth;
    float k_depth = push.depth_weight * variance;

    // One normal for the whole window, as on most flat walls, spans no cone. Depth, the dearest of
    // the fetches, is asked again only where the window holds some sky.
    vec3 mean_normal = normalize(normal_sum);
    float smallest = 1.0;
    int filled = normals_differ && hits == uint(m * m) ? m * m : 0;
    for (int i = 0; i < filled; ++i) {
        ivec2 position = pixel * m + window_offset(i);
        smallest = min(smallest, abs(dot(mean_normal, unpack_normal(fetch_normal_word(position)))));
    }
    int sparse = normals_differ ? m * m - filled : 0;
    for (int i = 0; i < sparse; ++i) {
        ivec2 position = pixel * m + window_offset(i);
        if (fetch_depth(position) > 0.0) {
            smallest = min(smallest, abs(dot(mean_normal, unpack_normal(fetch_normal_word(position)))));
        }
    }
    float k_normal = push.normal_weight * sqrt(1.0 - smallest);

    float a = luma_at(pixel + ivec2(-1, 0)), b = luma_at(pixel + ivec2(1, 0));
    float c = luma_at(pixel + ivec2(0, -1)), d = luma_at(pixel + ivec2(0, 1));
    float highest = max(max(a, b), max(c, d));
    float range = highest - min(min(a, b), min(c, d));
    float k_shading = range < max(push.range_min, highest * push.range_edge) ? 0.0 : push.shading_weight * range;

    k_depth = finite_or_zero(k_depth);
    k_normal = finite_or_zero(k_normal);
    k_shading = finite_or_zero(k_shading);
    float wanted = max(k_depth, max(k_normal, k_shading));
    uint k = uint(clamp(ceil(wanted), 1.0, n));
    imageStore(sample_count, pixel, uvec4(k));
#ifdef WINNER
    uint who = k <= 1u ? WINNER_NONE : k_depth == wanted ? WINNER_DEPTH : k_normal == wanted ? WINNER_NORMAL : WINNER_SHADING;
    imageStore(winner, pixel, uvec4(who));
#endif
}
