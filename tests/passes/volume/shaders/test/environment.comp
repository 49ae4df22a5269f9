// SPDX-License-Identifier: Apache-2.0
// reads queries: two random numbers, and a direction to look in; writes answers.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "volume/environment.glsl"

layout(local_size_x = 64) in;

struct Query {
    vec2 xi;
    vec3 direction;
};
struct Answer {
    vec3 seen; // in the query's direction
    float seen_pdf;
    vec3 drawn; // by the numbers
    vec3 direction;
    float pdf;
    float pdf_again; // of the drawn direction
};

layout(scalar, binding = 10) readonly buffer Queries { Query items[]; } queries;
layout(scalar, binding = 11) writeonly buffer Answers { Answer items[]; } answers;

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= queries.items.length()) return;
    Query query = queries.items[i];
    Answer answer;
    answer.seen = environment_radiance(query.direction);
    answer.seen_pdf = environment_pdf(query.direction);
    answer.drawn = sample_environment(query.xi, answer.direction, answer.pdf);
    answer.pdf_again = environment_pdf(answer.direction);
    answers.items[i] = answer;
}
