// SPDX-License-Identifier: Apache-2.0
// reads the medium, the light and unfinished paths; adds each pixel's new samples to its sum, in
// order, and stores the path that the budget of iterations leaves unfinished.
//   sum += (radiance, 1 where the camera's ray met anything);  square += luminance^2
// MESHES: less what is seen of them there, volume/meshes.glsl, and 1 where that was hidden; isosurfaces
// that scatter at the end of a ray hide nothing.
// One of PATH, NONCACHING and GATHER says what a sample is: shaders/volume/path.glsl.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "volume/path_trace.h"

layout(push_constant, scalar) uniform Push { PathTracePush push; };
#define PATH_NEE (push.nee != 0u)
#include "include/color.glsl"
#include "volume/path.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 10, rgba32f) uniform image2D sum;
layout(binding = 14, r32f) uniform image2D square;
layout(scalar, binding = 11) buffer Progress { uvec2 pixels[]; } progress; // finished, wanted
layout(scalar, binding = 12) buffer Paths { Path pixels[]; } paths; // of these rows
layout(scalar, binding = 13) buffer Statistics { uvec2 sums[]; } statistics;

void count(uint what, uint more) {
    if (more == 0u) return;
    uint old = atomicAdd(statistics.sums[what].x, more);
    if (old > ~more) atomicAdd(statistics.sums[what].y, 1u);
}

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy + uvec2(0u, push.first_row);
    if (pixel.x >= constants.size.x || gl_GlobalInvocationID.y >= push.rows) return;
    uint slot = gl_GlobalInvocationID.y * constants.size.x + pixel.x;
    uint index = pixel.y * constants.size.x + pixel.x;

    Path path = paths.pixels[slot];
    Tracker tracker = resume(path);
    uvec2 samples = progress.pixels[index];
    uint begun = samples.x + (path.stage == PATH_ENDED ? 0u : 1u);
    uint finished = samples.x, wanted = samples.y + push.samples, bad = 0u;
    vec4 total = imageLoad(sum, ivec2(pixel));
    float squares = imageLoad(square, ivec2(pixel)).x;

    uint budget = push.iterations;
    while (budget > 0u) {
        if (path.stage == PATH_ENDED) {
            if (begun == wanted) break;
            path = begin_camera_path(pixel, push.jitter != 0u, make_random(constants.seed, index, begun++));
            tracker = resume(path);
        }
        advance(path, tracker, budget);
        if (path.stage == PATH_ENDED) {
            bool finite = !any(isnan(path.radiance)) && !any(isinf(path.radiance));
            vec3 radiance = finite ? path.radiance : vec3(0.0);
            vec4 value = vec4(radiance, path.bounces > 0u ? 1.0 : 0.0);
#ifdef MESHES // what the medium has stopped is missing from their picture
            value.rgb -= value.a * mesh_ray_radiance(ivec2(pixel), path.random.z);
            value.a = 0.0;
#endif
            float light = luminance(value.rgb);
            total += value;
            squares += light * light;
            bad += finite ? 0u : 1u;
            ++finished;
        }
    }

#ifdef MESHES
    total.a += float(hidden_ends);
#endif
    suspend(path, tracker);
    bool unfinished = path.stage != PATH_ENDED;
    if (unfinished) paths.pixels[slot] = path;
    else paths.pixels[slot].stage = PATH_ENDED;
    progress.pixels[index] = uvec2(finished, wanted);
    imageStore(sum, ivec2(pixel), total);
    imageStore(square, ivec2(pixel), vec4(squares));
    count(PATHS_WANTED, push.samples);
    count(PATHS_FINISHED, finished - samples.x);
    count(PATHS_STEPS, tentative_collisions);
    count(PATHS_RESUMED, unfinished ? 1u : 0u);
    count(PATHS_TRUNCATED, bad);
    count(PATHS_CLAMPED, clamped_collisions);
}
