// SPDX-License-Identifier: Apache-2.0
// The image `surface_means`: what a sample that stands for others of its surface takes from all of
// them, written by surface_means.comp.
//   x        bits of what a sample for the whole window adds to alpha^2; 0 where it sees several
//   y, z, w  with --demodulate (rgba32ui, else r32ui): mean base colour of the surfaces labelled
//            0, 1, 2, as pack_color() has it; 0: unknown
// Needs shade.h. What is off is compiled out; then any image of integers may be bound.

layout(constant_id = SPEC_DEMODULATE) const bool kDemodulate = false;
layout(constant_id = SPEC_FILTER_HIGHLIGHTS) const bool kFilterHighlights = false;
layout(binding = 16) uniform usampler2D surface_means;

/// Colour of a sample on the surface `label`, packed; 0: its own.
uint mean_albedo(uvec4 means, uint label) {
    return kDemodulate && label < 3u ? means[label + 1u] : 0u;
}

/// What a sample adds to alpha^2. `share`: of the normals' variance that it stands for, 0 ... 1.
float roughening(uvec4 means, float share) {
    return kFilterHighlights ? share * uintBitsToFloat(means.x) : 0.0;
}
