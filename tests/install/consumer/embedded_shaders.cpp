// SPDX-License-Identifier: Apache-2.0
// What ockham_add_shaders does, by hand: tables of SPIR-V under the names that the program uses.
// Only build.sh compiles this; glslangValidator writes the headers.
#include "framework/gpu/shader.hpp"

namespace {

#include "tint_comp.h"
#include "tint_comp_inverted.h"
#include "triangle_frag.h"
#include "triangle_vert.h"

const ockham::gpu::EmbeddedShader table[] = {
    {"consumer/triangle.vert", triangle_vert},
    {"consumer/triangle.frag", triangle_frag},
    {"consumer/tint.comp", tint_comp},
    {"consumer/tint.comp:inverted", tint_comp_inverted},
};
const ockham::gpu::ShaderRegistration registration(table);

} // namespace
