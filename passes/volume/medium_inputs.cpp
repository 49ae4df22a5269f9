// SPDX-License-Identifier: Apache-2.0
#include "passes/volume/medium_inputs.hpp"

#include "passes/shader_variant.hpp"
#include "shaders/include/random.h"

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
    return {{SPEC_SOBOL, in.sobol ? 1u : 0u}};
}

} // namespace ockham
