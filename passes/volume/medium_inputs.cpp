// SPDX-License-Identifier: Apache-2.0
#include "passes/volume/medium_inputs.hpp"

#include "passes/shader_variant.hpp"
#include "shaders/include/random.h"
#include "shaders/volume/meshes.h"

#include <cmath>

namespace ockham {

void read_medium(PassBuilder& pass, const MediumInputs& in, const MediumUse& use) {
    pass.uniform("frame", in.frame)
        .sample("volume", in.handles.volume, Stage::compute, Filter::linear_clamp)
        .read("transfer", in.handles.transfer);
    if (in.facts.emission) pass.read("emission", in.handles.emission);
    if (use.surfaces && in.surfaces) pass.read("ranges", in.ranges);
    if (use.tracking && in.majorants) pass.read("majorants", in.majorants);
    if (use.light && in.facts.environment_map)
        pass.sample("environment", in.handles.environment, Stage::compute, Filter::texel)
            .read("environment_table", in.handles.environment_table);
}

std::string medium_variant(
    std::string_view shader, std::string_view mode, const MediumInputs& in, const MediumUse& use) {
    return shader_variant(shader,
        {{mode, !mode.empty()}, {"emission", in.facts.emission},
            {"grid", use.tracking && bool(in.majorants)}, {"surfaces", use.surfaces && in.surfaces},
            {"environment_map", use.light && in.facts.environment_map}});
}

Specialization medium_specialization(const MediumInputs& in) {
    Specialization out{{SPEC_SOBOL, in.sobol ? 1u : 0u}};
    if (in.meshes.ends) {
        out.emplace_back(SPEC_SUN_MAP, bool(in.meshes.sun_map));
        out.emplace_back(SPEC_ISO_SAMPLES, in.opaque);
        out.emplace_back(SPEC_TRANSLUCENT, in.translucent);
    }
    return out;
}

void read_meshes(PassBuilder& pass, const MediumInputs& in, bool camera) {
    if (!in.meshes.ends) return;
    if (camera)
        pass.sample("mesh_ends", in.meshes.ends).sample("mesh_radiance", in.meshes.radiance);
    pass.sample("sun_map", in.meshes.sun_map ? in.meshes.sun_map : in.meshes.picture);
}

void read_mesh_tree(PassBuilder& pass, const MediumInputs& in) {
    if (!in.meshes.ends) return;
    const BufferHandle tree = in.meshes.tree ? in.meshes.tree : in.handles.transfer;
    pass.read("mesh_tree", tree).read("mesh_links", tree);
    pass.read("lights", in.meshes.lamps ? in.meshes.lamps : in.handles.transfer);
}

Specialization path_specialization(const MediumInputs& in) {
    Specialization out = medium_specialization(in);
    if (!in.meshes.ends) return out;
    out.emplace_back(SPEC_MESH_TREE, bool(in.meshes.tree));
    out.emplace_back(SPEC_LAMPS, in.meshes.points + in.meshes.spots);
    out.emplace_back(SPEC_FIRST_LAMP, in.meshes.first_lamp);
    out.emplace_back(SPEC_SPOTS, in.meshes.spots);
    return out;
}

std::string mesh_variant(std::string variant, const MediumInputs& in) {
    if (!in.meshes.ends) return variant;
    return variant + (variant.find(':') == std::string::npos ? ":meshes" : ",meshes");
}

void read_transmittance(PassBuilder& pass, const MediumInputs& in) {
    pass.uniform("medium_frame", in.frame)
        .sample("volume", in.handles.volume, Stage::compute, Filter::linear_clamp)
        .read("transfer", in.handles.transfer)
        .read("majorants", in.majorants ? in.majorants : in.handles.transfer)
        .read("ranges", in.surfaces ? in.ranges : in.handles.transfer);
}

Specialization transmittance_specialization(const MediumInputs& in) {
    return {{SPEC_MEDIUM_GRID, bool(in.majorants)}, {SPEC_MEDIUM_SURFACES, in.surfaces},
        {SPEC_ISO_SAMPLES, in.opaque}};
}

std::uint32_t transmittance_iterations(const MediumInputs& in) {
    const glm::uvec3 dims = in.facts.dims;
    const auto steps = static_cast<std::uint32_t>(std::ceil(glm::length(glm::dvec3(dims))));
    // The search looks at each cell once; bisection takes 20, of every surface that lets light
    // through, of which a hundred are plenty.
    const std::uint32_t search = dims.x + dims.y + dims.z + 64 + 100 * 20;
    return steps + 1 + MAX_CLIP_PLANES + (in.surfaces ? search : 0);
}

} // namespace ockham
