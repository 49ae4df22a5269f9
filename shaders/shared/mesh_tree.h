// SPDX-License-Identifier: Apache-2.0
// A tree of boxes around triangles, for rays that are followed through a scene. One buffer of rows
// of 16 bytes: nodes, from the root on, then triangles. Written by framework/scene/mesh_tree.hpp.
#ifndef OCKHAM_SHADERS_SHARED_MESH_TREE_H
#define OCKHAM_SHADERS_SHARED_MESH_TREE_H

#include "shared/types.h"

OCKHAM_SHARED_BEGIN

#define MESH_LEAF 4u       // triangles of a leaf, at most
#define MESH_NODE_ROWS 4u  // of 16 bytes
#define MESH_TRIANGLE_ROWS 3u
#define MESH_END 0xffffffffu // instead of a row: nothing follows

/// `next` is where a walk goes on that has finished with the node, or misses its box: it needs no
/// stack. Of the two children, which lie side by side, it takes the nearer one first.
struct MeshNode {
    vec3 low;     ///< world
    uint first;   ///< row of the first child, on the low side of the axis; of a leaf's triangles
    vec3 high;
    uint kind;    ///< of a leaf, 4 times the number of its triangles; else the axis
    uint next[8]; ///< rows, for rays whose direction has these signs: bit i is set where it is < 0
};
OCKHAM_SHARED_SIZE(MeshNode, 64);

/// A triangle and what light sees of it: on either side it scatters evenly.
struct MeshTriangle {
    vec3 corner;  ///< world
    uint albedo;  ///< 8 bits each of R, G and B, from the low ones on; above, the share that is no hole
    vec3 across;  ///< to the second corner
    uint emitted; ///< radiance: mantissas of 9 bits that share an exponent, as EXT_texture_shared_exponent
    vec3 up;      ///< to the third corner
    uint unused;
};
OCKHAM_SHARED_SIZE(MeshTriangle, 48);

OCKHAM_SHARED_END

#endif
