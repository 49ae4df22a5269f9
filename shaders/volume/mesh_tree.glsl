// SPDX-License-Identifier: Apache-2.0
// Where a ray first meets a triangle, and what it sees there.
//   reads mesh_tree (shared/mesh_tree.h), and by the name of mesh_links its words one by one
// Boxes by slabs (Kay and Kajiya 1986), triangles after Moeller and Trumbore 1997; walks need no stack,
// so that one which is interrupted goes on from three numbers. Holes are spread evenly over their
// triangle: it is met with the chance that a place on it is none. Include after include/random.glsl.
#ifndef OCKHAM_VOLUME_MESH_TREE_GLSL
#define OCKHAM_VOLUME_MESH_TREE_GLSL

#include "include/shared_exponent.glsl"
#include "shared/mesh_tree.h"

layout(scalar, binding = 18) readonly buffer MeshTree { uvec4 rows[]; } mesh_tree;
layout(scalar, binding = 19) readonly buffer MeshLinks { uint words[]; } mesh_links;

// Of one call of search_meshes(), the same for all lanes whatever they meet.
const uint kMeshRounds = 4u, kMeshNodes = 8u;
const uint kMeshIterations = kMeshRounds * (1u + kMeshNodes + MESH_LEAF);

struct MeshSearch {
    uint row;      // node that is next; MESH_END: the search has ended
    float t;       // nothing behind it counts: the nearest triangle so far, or where the ray ends
    uint triangle; // row; MESH_END: none
};
MeshSearch begin_mesh_search(float end) { return MeshSearch(0u, end, MESH_END); }

struct MeshHit {
    vec3 position; // beside the triangle, on the side that the ray comes from
    vec3 normal;   // unit, on that side
    vec3 albedo;
    vec3 emitted;
};

/// Goes on with the search along a ray: direction unit, world; `random`: chooses what is a hole; `lamp`:
/// towards a lamp, which stands for the light in whatever shines: that does not stop it. True: it has
/// ended.
bool search_meshes(inout MeshSearch search, vec3 origin, vec3 direction, uvec4 random, bool lamp) {
    vec3 inverse = 1.0 / mix(direction, vec3(1e-20), lessThan(abs(direction), vec3(1e-20)));
    bvec3 negative = lessThan(inverse, vec3(0.0));
    uint octant = uint(negative.x) | uint(negative.y) << 1 | uint(negative.z) << 2;
    for (uint round = 0u; round < kMeshRounds && search.row != MESH_END; ++round) {
        uint first = 0u, count = 0u;
        for (uint i = 0u; i < kMeshNodes && count == 0u && search.row != MESH_END; ++i) {
            uvec4 a = mesh_tree.rows[search.row], b = mesh_tree.rows[search.row + 1u];
            vec3 low = (uintBitsToFloat(a.xyz) - origin) * inverse;
            vec3 high = (uintBitsToFloat(b.xyz) - origin) * inverse;
            vec3 enter = min(low, high), leave = max(low, high);
            float near = max(max(enter.x, enter.y), max(enter.z, 0.0));
            float far = min(min(leave.x, leave.y), min(leave.z, search.t));
            bool inside = near <= far * 1.000001; // whatever rounding has done
            bool leaf = b.w >= 4u;
            first = a.w;
            count = inside && leaf ? b.w >> 2 : 0u;
            search.row = inside && !leaf ? a.w + MESH_NODE_ROWS * (octant >> b.w & 1u)
                                         : mesh_links.words[4u * search.row + 8u + octant];
        }
        for (uint i = 0u; i < MESH_LEAF && i < count; ++i) {
            uint row = first + MESH_TRIANGLE_ROWS * i;
            uvec4 a = mesh_tree.rows[row];
            uvec4 b = mesh_tree.rows[row + 1u];
            vec3 across = uintBitsToFloat(b.xyz);
            vec3 up = uintBitsToFloat(mesh_tree.rows[row + 2u].xyz);
            vec3 p = cross(direction, up), s = origin - uintBitsToFloat(a.xyz), q = cross(s, across);
            float determinant = dot(across, p);
            vec3 uvt = vec3(dot(s, p), dot(direction, q), dot(up, q)) / determinant;
            // Neighbours overlap by rounding errors: rays do not slip through between them.
            bool met = min(uvt.x, uvt.y) >= -1e-6 && uvt.x + uvt.y <= 1.000001 && uvt.z > 0.0 &&
                uvt.z < search.t; // a parallel ray meets nothing: not a number is not less
            met = met && !(lamp && (b.w & 0x07ffffffu) != 0u);
            uint share = a.w >> 24;
            if (met && share < 255u)
                met = hash4(random + uvec4(0u, 0u, 0u, row)).x < share * 16843009u;
            search.t = met ? uvt.z : search.t;
            search.triangle = met ? row : search.triangle;
        }
    }
    return search.row == MESH_END;
}

/// What a ray sees that has found a triangle.
MeshHit mesh_hit(MeshSearch search, vec3 origin, vec3 direction) {
    uvec4 a = mesh_tree.rows[search.triangle], b = mesh_tree.rows[search.triangle + 1u],
          c = mesh_tree.rows[search.triangle + 2u];
    MeshHit hit;
    vec3 normal = normalize(cross(uintBitsToFloat(b.xyz), uintBitsToFloat(c.xyz)));
    hit.normal = dot(normal, direction) < 0.0 ? normal : -normal;
    vec3 position = origin + search.t * direction;
    vec3 size = abs(position);
    float aside = 1e-5 * (max(max(size.x, size.y), size.z) + search.t);
    hit.position = position + aside * hit.normal;
    hit.albedo = vec3(a.w & 255u, a.w >> 8 & 255u, a.w >> 16 & 255u) / 255.0;
    hit.emitted = unpack_rgb9e5(b.w);
    return hit;
}

#endif
