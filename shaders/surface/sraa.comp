// SPDX-License-Identifier: Apache-2.0
// reads the G-buffer's window of a pixel and S of the 3 x 3 pixels around; writes the mean of all n
// samples, each reconstructed from those S that lie on its surface.
//   c_i = sum_j w_ij S_j / sum_j w_ij
//   w   = exp(-d^2 / 2 r^2) exp(-h^2 / 2 e^2) max(n_i . n_j, 0)^p     h: off the plane of sample i
// Chajdas, McGuire, Luebke, Subpixel Reconstruction Antialiasing for Deferred Shading, I3D 2011.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "shared/frame.h"
#include "surface/sraa.h"

layout(local_size_x = 8, local_size_y = 8) in;

layout(scalar, binding = 0) uniform Frame { FrameData data; } frame;
#include "surface/surface_sample.glsl"
layout(binding = 4) uniform sampler2D first_sample;
layout(binding = 5, rgba32f) uniform writeonly image2D reconstructed;
layout(push_constant, scalar) uniform Push { SraaPush push; };

/// A shaded sample nearby, or one to reconstruct.
struct Point {
    vec3 world;
    vec3 normal;
    float depth; // along the camera's axis, world units
    bool hit;
};

Point fetch_point(ivec2 position) {
    float stored = fetch_depth(position);
    Point p;
    p.hit = stored > 0.0;
    p.depth = view_depth(stored);
    p.world = sample_world(position, p.depth);
    p.normal = fetch_normal(position);
    return p;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = ivec2(frame.data.size);
    if (any(greaterThanEqual(pixel, size))) return;
    int m = int(frame.data.m);
    ivec2 first = window_offset(int(frame.data.order[0]));

    Point shaded[9];
    vec4 radiance[9];
    vec2 center[9]; // samples from this pixel's first
    for (int j = 0; j < 9; ++j) {
        ivec2 neighbor = clamp(pixel + ivec2(j % 3 - 1, j / 3 - 1), ivec2(0), size - 1);
        shaded[j] = fetch_point(neighbor * m + first);
        radiance[j] = texelFetch(first_sample, neighbor, 0);
        center[j] = vec2((neighbor - pixel) * m + first);
    }
    float pixel_size = 2.0 * length(frame.data.up) / float(frame.data.picture.y);

    vec4 sum = vec4(0.0);
    for (int i = 0; i < m * m; ++i) {
        ivec2 offset = window_offset(i);
        Point p = fetch_point(pixel * m + offset);
        float error = push.plane_error * pixel_size * (frame.data.orthographic != 0u ? 1.0 : p.depth);
        vec4 weighted = vec4(0.0);
        float weights = 0.0;
        for (int j = 0; j < 9; ++j) {
            vec2 d = (center[j] - vec2(offset)) / (float(m) * push.radius);
            float h = dot(p.normal, shaded[j].world - p.world) / error;
            float cosine = max(dot(p.normal, shaded[j].normal), 0.0);
            float surface = p.hit ? exp(-0.5 * h * h) * pow(cosine, push.normal_power) : 1.0;
            float w = p.hit == shaded[j].hit ? exp(-0.5 * dot(d, d)) * surface : 0.0;
            weighted += w * radiance[j];
            weights += w;
        }
        // A surface that no shaded sample around has met: the pixel's own must do.
        sum += weights > 1e-6 ? weighted / weights : radiance[4];
    }
    imageStore(reconstructed, pixel, sum / float(m * m));
}
