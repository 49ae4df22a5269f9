// SPDX-License-Identifier: Apache-2.0
#include "passes/surface/shading_inputs.hpp"

#include "framework/core/error.hpp"
#include "passes/shader_variant.hpp"
#include "shaders/shared/scene.h"
#include "shaders/surface/shade.h"

namespace ockham {

namespace {

/// Packed normals are bumped already, ids are not.
bool needs_data_textures(const ShadingInputs& in) {
    const SceneFacts& facts = in.scene.scene->facts();
    return in.gbuffer.layout == GbufferLayout::visibility ? facts.data_textures()
                                                          : facts.shading_data_textures;
}

/// Binds the first `few` items of so many, or all, as a uniform buffer. Of more nothing is read
/// there.
void read_few(PassBuilder& pass, std::string_view binding, BufferHandle buffer, std::size_t item,
    std::size_t count, std::size_t few, Stage stage) {
    pass.uniform(binding, count > few ? buffer.range(0, item * few) : BufferPart(buffer), stage);
}

} // namespace

shader::ShadePush one_sample_push(const ShadingParams& params) {
    return {.count = 1,
        .first = 0,
        .last = 1,
        .stall = params.stall,
        .anisotropy = static_cast<float>(params.anisotropy),
        .loop_bound = 1};
}

void read_shading(PassBuilder& pass, const ShadingInputs& in, Stage stage) {
    const SceneFacts& facts = in.scene.scene->facts();
    const bool packed = in.gbuffer.layout == GbufferLayout::packed;
    read_gbuffer(pass, in.gbuffer, stage);
    const SceneHandles& handles = in.scene.handles;
    pass.uniform("frame", in.scene.frame, stage).read("lights", handles.lights, stage);
    read_few(pass, "few_lights", handles.lights, sizeof(shader::LightData), facts.lights(),
        FEW_LIGHTS, stage);
    if (packed) pass.read("materials", handles.materials, stage); // ids: read_gbuffer() did
    read_few(pass, "few_materials", handles.materials, sizeof(shader::MaterialData),
        facts.materials, FEW_MATERIALS, stage);
    if (facts.color_textures) {
        pass.sample(
            "color_textures", in.scene.handles.color_textures, stage, Filter::linear_repeat);
    }
    if (packed && needs_data_textures(in))
        pass.sample("data_textures", in.scene.handles.data_textures, stage, Filter::linear_repeat);
    if (in.shadow_map) pass.sample("shadow_map", in.shadow_map, stage);
    if (in.medium) read_transmittance(pass, *in.medium);
}

std::string shading_variant(
    std::string_view shader, std::string_view mode, const ShadingInputs& in) {
    return shader_variant(
        shader, {{mode, !mode.empty()}, {"color_textures", in.scene.scene->facts().color_textures},
                    {"data_textures", needs_data_textures(in)}, {"shadow", bool(in.shadow_map)},
                    {"extra", bool(in.gbuffer.extra)},
                    {"visibility", in.gbuffer.layout == GbufferLayout::visibility},
                    {"medium", in.medium.has_value()}});
}

Specialization shading_specialization(const ShadingInputs& in, bool stratified) {
    const SceneFacts& facts = in.scene.scene->facts();
    Specialization out = gbuffer_specialization(in.gbuffer);
    out.insert(out.end(),
        {{SPEC_DIRECTIONAL_LIGHTS, facts.directional_lights > 0},
            {SPEC_POINT_LIGHTS, facts.point_lights > 0}, {SPEC_SPOT_LIGHTS, facts.spot_lights > 0},
            {SPEC_MANY_LIGHTS, facts.lights() > FEW_LIGHTS},
            {SPEC_MANY_MATERIALS, facts.materials > FEW_MATERIALS}});
    if (in.medium) {
        const Specialization medium = transmittance_specialization(*in.medium);
        out.insert(out.end(), medium.begin(), medium.end());
    }
    if (stratified) {
        out.insert(out.end(),
            {{SPEC_DEMODULATE, in.demodulate}, {SPEC_FILTER_HIGHLIGHTS, in.filter_highlights}});
    }
    return out;
}

std::uint32_t iterations_per_sample(const SceneFacts& facts, const ShadingParams& params,
    const std::optional<MediumInputs>& medium) {
    const std::uint32_t lookups =
        2u * (facts.color_textures ? 1u : 0u) + 2u * (facts.shading_data_textures ? 1u : 0u);
    const std::uint32_t ways = medium ? facts.lights() * transmittance_iterations(*medium) : 0;
    return (params.stall + 15) / 16 + facts.lights() + lookups * params.anisotropy + ways + 1;
}

std::uint32_t samples_per_dispatch(const SceneFacts& facts, const ShadingParams& params,
    const std::optional<MediumInputs>& medium) {
    const std::uint32_t iterations = iterations_per_sample(facts, params, medium);
    if (iterations > kIterationBudget) {
        fail_input(
            "one shaded sample would take {} loop iterations (stall {}, {} lights{}); the limit "
            "is {}: use fewer lights or a shorter stall",
            iterations, params.stall, facts.lights(), medium ? ", each through the medium" : "",
            kIterationBudget);
    }
    return kIterationBudget / iterations;
}

} // namespace ockham
