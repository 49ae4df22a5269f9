// SPDX-License-Identifier: Apache-2.0
// The scene's materials: of so few as most scenes have, from a uniform buffer, which software drivers
// read for all lanes at once; of more from a storage buffer, which they read lane by lane.
//
// No other uniform buffer has a greater binding. lavapipe (Mesa 22.3) makes constants of what branches
// and loops read at constant places of uniform buffers; its table of them has room for three buffers, and
// the entry of a fourth destroys what lies behind it. This one is read at no constant place.
#ifndef OCKHAM_SHADERS_SURFACE_MATERIALS_GLSL
#define OCKHAM_SHADERS_SURFACE_MATERIALS_GLSL

#include "shared/scene.h"

layout(constant_id = SPEC_MANY_MATERIALS) const bool kManyMaterials = false;

#ifndef VISIBILITY // which has them already
layout(scalar, binding = 4) readonly buffer Materials { MaterialData items[]; } materials;
#endif
layout(scalar, binding = 41) uniform FewMaterials { MaterialData items[FEW_MATERIALS]; } few_materials;

MaterialData material_at(uint index) {
    if (kManyMaterials) return materials.items[index];
    return few_materials.items[index];
}

#endif
