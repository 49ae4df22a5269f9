// SPDX-License-Identifier: Apache-2.0
// Unit vectors as two signed numbers on the unfolded octahedron.
// Cigolle et al., A Survey of Efficient Representations for Independent Unit Vectors, JCGT 2014.

vec2 octahedral_fold(vec2 v) {
    return (1.0 - abs(v.yx)) * vec2(v.x >= 0.0 ? 1.0 : -1.0, v.y >= 0.0 ? 1.0 : -1.0);
}

/// Unit vector to [-1,1]^2. A zero or non-finite vector gives a non-finite or arbitrary result.
vec2 octahedral_encode(vec3 n) {
    vec2 p = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
    return n.z >= 0.0 ? p : octahedral_fold(p);
}

vec3 octahedral_decode(vec2 p) {
    vec3 n = vec3(p, 1.0 - abs(p.x) - abs(p.y));
    if (n.z < 0.0) n.xy = octahedral_fold(n.xy);
    return normalize(n);
}
