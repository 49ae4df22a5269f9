// SPDX-License-Identifier: Apache-2.0
// reads the medium; writes, of each sample whose ray meets an opaque isosurface, the first of these
// as a packed surface sample (packing.glsl), and its depth. Translucent ones before it are left to
// the steps of the medium.
// SLOPES adds those of its tangent plane.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "shared/frame.h"
layout(scalar, binding = 0) uniform Frame { FrameData data; } frame;
#include "surface/camera.glsl"
#include "surface/packing.glsl"
#define SURFACES
#define MEDIUM_BINDING 10
#include "volume/surface.glsl"

#ifdef EXTRA
#define OUT_SLOPES 2
#else
#define OUT_SLOPES 1
#endif
layout(location = 0) out uvec4 out_surface;
#ifdef EXTRA
layout(location = 1) out uvec4 out_extra;
#endif
#ifdef SLOPES
layout(location = OUT_SLOPES) out uint out_slopes;
#endif

const float kGrazing = 1e-4; // least cosine that a slope is computed for

/// The first one from the camera on. The budget bounds a search: every cell of the diagonal once.
bool first_opaque(vec3 origin, vec3 direction, out SurfaceHit hit) {
    float near, far;
    vec3 entry_normal;
    bool inside = clip_ray(origin, direction, near, far, entry_normal);
    uint budget = constants.dims.x + constants.dims.y + constants.dims.z + 64u;
    bool start = true, opaque = false;
    hit = SurfaceHit(far, kNoSurface, vec3(0.0), false);
    for (float t = near; inside && !opaque && t < far && budget > 0u;) {
        bool met = find_surface(origin, direction, t, far, start, entry_normal, budget, hit);
        opaque = met && medium_frame.data.surfaces[hit.surface].opacity >= 1.0;
        t = met ? hit.t + beyond_hit() : far;
        start = false;
    }
    return opaque;
}

void main() {
    vec3 across = sample_across(ivec2(gl_FragCoord.xy));
    bool flat_view = frame.data.orthographic != 0u;
    vec3 origin = frame.data.position + (flat_view ? across : vec3(0.0));
    vec3 way = frame.data.forward + (flat_view ? vec3(0.0) : across), direction = normalize(way);
    SurfaceHit hit;
    if (!first_opaque(origin, direction, hit)) discard;

    vec3 normal = dot(hit.normal, direction) > 0.0 ? -hit.normal : hit.normal;
    float stored = stored_depth(hit.t * dot(direction, frame.data.forward));
    gl_FragDepth = stored;
    TextureCoordinates none = TextureCoordinates(vec2(0.0), vec2(0.0), vec2(0.0));
    out_surface = pack_surface(normal, ISO_MATERIAL + hit.surface, none);
#ifdef EXTRA
    out_extra = uvec4(pack_color(vec3(1.0)), pack_coordinates(none));
#endif
#ifdef SLOPES
    // On a plane through the hit, stored depth is proportional to dot(normal, way) under perspective.
    vec2 slope = vec2(dot(normal, sample_right()), dot(normal, sample_down())) / min(dot(normal, way), -kGrazing);
    out_slopes = packHalf2x16(flat_view ? slope / (frame.data.far_distance * stored) : slope);
#endif
}
