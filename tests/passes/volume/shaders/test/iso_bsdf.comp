// SPDX-License-Identifier: Apache-2.0
// Of a material: mode 0 evaluates BRDF * cos and pdf for given directions, mode 1 samples them.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "include/iso_bsdf.glsl"
#include "include/random.glsl"
#include "test/iso_bsdf.h"

layout(local_size_x = 64) in;

layout(scalar, binding = 0) readonly buffer Materials { IsoMaterial of[]; } materials;
layout(scalar, binding = 1) readonly buffer Directions { vec3 of[]; } directions; // mode 0
layout(scalar, binding = 2) writeonly buffer Answers { IsoBsdfAnswer of[]; } answers;
layout(push_constant, scalar) uniform Push { IsoBsdfPush push; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= push.count) return;
    IsoMaterial m = materials.of[push.material];
    IsoBsdfAnswer a;
    if (push.mode == 0u) {
        a.direction = directions.of[i];
        a.value = evaluate_iso(m, push.shading, push.normal, push.view, a.direction);
    } else {
        Random random = make_random(push.material, i, push.mode);
        a.value = sample_iso(m, push.shading, push.normal, push.view, next4(random), a.direction, a.pdf);
    }
    float pdf = pdf_iso(m, push.shading, push.normal, push.view, a.direction);
    if (push.mode == 0u) {
        a.pdf = pdf;
        a.again = evaluate_iso(m, push.shading, push.normal, a.direction, push.view);
    } else {
        a.again = evaluate_iso(m, push.shading, push.normal, push.view, a.direction);
    }
    a.pdf_again = pdf;
    answers.of[i] = a;
}
