// SPDX-License-Identifier: Apache-2.0
// Isosurfaces among the samples of the G-buffer, where MEDIUM and SPEC_ISO_SAMPLES say that there
// are any: shaded as shaders/volume/shade_surface.glsl does, but by all lights of the scene.

#ifdef MEDIUM
#include "include/iso_bsdf.glsl"

bool is_isosurface(uint material) { return kIsoSamples && is_iso_material(material); }
IsoMaterial isosurface_material(uint material) {
    return medium_frame.data.surfaces[min(material - ISO_MATERIAL, MAX_SURFACES - 1u)].material;
}

/// Radiance towards `v` per irradiance from `l`.
vec3 reflect_isosurface(uint material, vec3 n, vec3 v, vec3 l) {
    return constants.surface_gain *
           evaluate_iso(isosurface_material(material), constants.shading, n, v, l);
}
/// Radiance from an environment that is as bright everywhere.
vec3 isosurface_ambient(uint material) {
    return constants.surface_gain *
           iso_diffuse_albedo(isosurface_material(material), constants.shading) *
           constants.environment;
}
#else
bool is_isosurface(uint material) { return false; }
vec3 reflect_isosurface(uint material, vec3 n, vec3 v, vec3 l) { return vec3(0.0); }
vec3 isosurface_ambient(uint material) { return vec3(0.0); }
#endif
