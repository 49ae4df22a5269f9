// SPDX-License-Identifier: Apache-2.0
// All triangles of a scene in one tree of boxes, for rays that do not come from the camera: binned
// surface area heuristic (Wald 2007), threaded for each octant of directions so that kernels need
// no stack. The same scene gives the same tree. Uploaded by pipelines; kernels:
// volume/mesh_tree.glsl.
#pragma once

#include "framework/scene/scene.hpp"
#include "shaders/shared/mesh_tree.h"

#include <vector>

namespace ockham {

struct MeshTree {
    std::vector<shader::MeshNode> nodes; ///< the root first; none without triangles
    std::vector<shader::MeshTriangle> triangles;

    std::uint64_t bytes() const {
        return nodes.size() * sizeof(shader::MeshNode) +
               triangles.size() * sizeof(shader::MeshTriangle);
    }
};

/// Triangles of all instances, but for those without an area or with a corner that is not finite.
/// What each looks like is the mean of 16 places on it:
///   albedo   base colour + (1 - metallic) * reflectance, at most 1: what ambient light sees
///   emitted  emissive; of unlit materials the base colour, which has no albedo then
///   share    of the places whose alpha is not below the cutoff; 1 for materials without a mask
MeshTree build_mesh_tree(const Scene& scene);

} // namespace ockham
