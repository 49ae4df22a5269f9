// SPDX-License-Identifier: Apache-2.0
// The image `clusters`: which surface of its window each sample of a pixel lies on, 0 ... 3, two
// bits each, in the order in which samples are taken. The first sample's label is 0, and labels are
// numbered as they first occur. Up to 16 samples fit r32ui, 64 rgba32ui.

#define MAX_CLUSTERS 4u

/// `rank`: 0 ... n - 1.
uint cluster_label(uvec4 labels, uint rank) { return labels[rank >> 4] >> 2u * (rank & 15u) & 3u; }

/// Samples with each label, of n. What is beyond the n-th label must be 0.
uvec4 cluster_sizes(uvec4 labels, uint n) {
    uvec4 low = labels & 0x55555555u, high = labels >> 1 & 0x55555555u;
    uvec4 in1 = uvec4(bitCount(low & ~high)), in2 = uvec4(bitCount(high & ~low)), in3 = uvec4(bitCount(low & high));
    uvec3 sizes = uvec3(in1.x + in1.y + in1.z + in1.w, in2.x + in2.y + in2.z + in2.w, in3.x + in3.y + in3.z + in3.w);
    return uvec4(n - sizes.x - sizes.y - sizes.z, sizes);
}

uint cluster_count(uvec4 sizes) {
    return sizes.w > 0u ? 4u : sizes.z > 0u ? 3u : sizes.y > 0u ? 2u : 1u;
}

/// Rank of the first sample with a label, which must occur.
uint cluster_first_rank(uvec4 labels, uint label) {
    uvec4 wanted = uvec4((label & 1u) * 0x55555555u, (label >> 1) * 0x55555555u, 0u, 0u);
    uvec4 match = ~(labels ^ wanted.x) & ~(labels >> 1 ^ wanted.y) & 0x55555555u;
    uint word = match.x != 0u ? 0u : match.y != 0u ? 1u : match.z != 0u ? 2u : 3u;
    return 16u * word + uint(findLSB(match[word])) / 2u;
}
