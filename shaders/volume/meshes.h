// SPDX-License-Identifier: Apache-2.0
// Parameters of the kernels that bring meshes and a medium together.
#ifndef OCKHAM_SHADERS_VOLUME_MESHES_H
#define OCKHAM_SHADERS_VOLUME_MESHES_H

#include "shared/types.h"

OCKHAM_SHARED_BEGIN

struct OverMeshesPush {
    uint window; ///< m
};

// Specialisation of volume/meshes.glsl and volume/transmittance.glsl; numbers apart from those of
// include/random.h, surface/shade.h and surface/gbuffer.h.
#define SPEC_SUN_MAP 32         // bool: the sun casts shadows
#define SPEC_MEDIUM_GRID 33     // bool: there are majorants, not one extinction everywhere
#define SPEC_MEDIUM_SURFACES 34 // bool: there are isosurfaces
#define SPEC_MESH_TREE 35       // bool: flights that have been scattered meet meshes
#define SPEC_LAMPS 36           // point and spot lights that light the medium
#define SPEC_FIRST_LAMP 37      // the first of them among the scene's lights
#define SPEC_SPOTS 38           // spot lights, the last of them
#define SPEC_ISO_SAMPLES 39     // bool: samples of the G-buffer show the first opaque isosurface
#define SPEC_TRANSLUCENT 40     // bool: others are not opaque

OCKHAM_SHARED_END

#endif
