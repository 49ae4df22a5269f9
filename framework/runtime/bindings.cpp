// SPDX-License-Identifier: Apache-2.0
#include "framework/runtime/bindings.hpp"

#include "framework/gpu/image.hpp"
#include "framework/runtime/misuse.hpp"

#include <algorithm>
#include <string_view>

namespace ockham {

namespace {

const char* describe(VkDescriptorType type) {
    switch (type) {
    case VK_DESCRIPTOR_TYPE_STORAGE_BUFFER:
        return "a storage buffer";
    case VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER:
        return "a uniform buffer";
    case VK_DESCRIPTOR_TYPE_STORAGE_IMAGE:
        return "a storage image";
    case VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER:
        return "a sampled image";
    default:
        return "something else";
    }
}

VkShaderStageFlags vulkan_stage(Stage stage) {
    switch (stage) {
    case Stage::compute:
        return VK_SHADER_STAGE_COMPUTE_BIT;
    case Stage::vertex:
        return VK_SHADER_STAGE_VERTEX_BIT;
    case Stage::fragment:
        return VK_SHADER_STAGE_FRAGMENT_BIT;
    case Stage::fixed:
        break;
    }
    return 0;
}

VkDescriptorType descriptor_of(Access access, ResourceKind kind) {
    switch (access) {
    case Access::sampled:
        return VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
    case Access::uniform:
        return VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
    default:
        return kind == ResourceKind::image ? VK_DESCRIPTOR_TYPE_STORAGE_IMAGE
                                           : VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    }
}

const char* dimension(VkImageViewType type) {
    switch (type) {
    case VK_IMAGE_VIEW_TYPE_3D:
        return "3D";
    case VK_IMAGE_VIEW_TYPE_2D_ARRAY:
        return "2D array";
    default:
        return "2D";
    }
}

} // namespace

Bindings::Bindings(const gpu::Device& device, const Declaration& declaration)
    : device_(device), declaration_(declaration), written_(declaration.resources.size(), 0) {
    for (const Use& use : declaration.uses) {
        if (writes(use.access)) written_[use.resource] = 1;
    }
}

const std::vector<std::uint32_t>& Bindings::of(PassId pass, const gpu::Pipeline& pipeline) {
    const auto [known, fresh] = known_.try_emplace({pass, &pipeline});
    if (!fresh) return known->second;
    try {
        for (const Slot& slot : pipeline.layout->slots) {
            const std::uint32_t index = find(pass, slot);
            const Use& use = declaration_.uses[index];
            check_kind(pass, slot, use);
            check_direction(pass, slot, use);
            check_stage(pass, pipeline, slot, use);
            if (declaration_.resources[use.resource].kind == ResourceKind::buffer) {
                check_buffer(pass, slot, use);
            } else {
                check_image(pass, slot, use);
            }
            known->second.push_back(index);
        }
    } catch (...) {
        known_.erase(known);
        throw;
    }
    return known->second;
}

std::size_t Bindings::pipeline_count() const {
    std::set<const gpu::Pipeline*> pipelines;
    for (const auto& [key, uses] : known_) pipelines.insert(key.second);
    return pipelines.size();
}

std::uint32_t Bindings::find(PassId pass, const Slot& slot) const {
    const PassDecl& decl = declaration_.passes[pass];
    std::vector<std::string_view> declared;
    for (std::uint32_t i = decl.first_use; i < decl.first_use + decl.use_count; ++i) {
        const std::string_view name = declaration_.binding_of(declaration_.uses[i]);
        if (name == slot.binding.name) return i;
        if (!name.empty()) declared.push_back(name);
    }
    fail_pass(declaration_, pass, "undeclared-binding",
        "shader '{}' uses binding '{}', which the pass did not declare; it declared: {}",
        slot.shader, slot.binding.name, fmt::join(declared, ", "));
}

void Bindings::check_kind(PassId pass, const Slot& slot, const Use& use) const {
    const ResourceDecl& resource = declaration_.resources[use.resource];
    const VkDescriptorType declared = descriptor_of(use.access, resource.kind);
    if (declared == slot.binding.type) return;
    fail_pass(declaration_, pass, "binding-kind",
        "shader '{}', binding '{}' is {} in the shader, but declared as {} ('{}' of {})",
        slot.shader, slot.binding.name, describe(slot.binding.type), describe(declared),
        name_of(use.access), ockham::describe(resource));
}

void Bindings::check_direction(PassId pass, const Slot& slot, const Use& use) const {
    const gpu::ShaderBinding& binding = slot.binding;
    const auto refuse = [&](const char* does, const char* remedy) {
        fail_pass(declaration_, pass, "binding-direction",
            "shader '{}' {} binding '{}', but the pass declared it '{}' of {}; {}", slot.shader,
            does, binding.name, name_of(use.access),
            ockham::describe(declaration_.resources[use.resource]), remedy);
    };
    if (!binding.writes && use.access == Access::storage_write) {
        refuse(
            "qualifies readonly and so cannot write", "declare a read, or let the shader write it");
    }
    if (binding.writes && !writes(use.access)) {
        refuse("may write", "qualify it readonly in the shader, or declare the write");
    }
    if (binding.reads && use.access == Access::storage_write) {
        refuse("may read", "qualify it writeonly in the shader, or declare read_write");
    }
}

void Bindings::check_stage(
    PassId pass, const gpu::Pipeline& pipeline, const Slot& slot, const Use& use) const {
    // Content that no pass writes is complete before the execution, whoever reads it.
    const VkShaderStageFlags declared = vulkan_stage(use.stage);
    const bool covered = (slot.stages & ~declared) == 0;
    if ((slot.stages & declared) && (covered || !written_[use.resource])) return;
    fail_pass(declaration_, pass, "binding-stage",
        "'{}' uses binding '{}' in other shader stages ({:#x}) than declared ({}, of {}); declare "
        "the stage that uses it",
        pipeline.shaders, slot.binding.name, slot.stages, name_of(use.stage),
        ockham::describe(declaration_.resources[use.resource]));
}

void Bindings::check_buffer(PassId pass, const Slot& slot, const Use& use) const {
    const std::uint64_t bytes = part_of(declaration_, use).bytes;
    const std::uint64_t limit = slot.binding.type == VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER
                                    ? device_.limits().uniform_bytes
                                    : device_.limits().storage_bytes;
    if (bytes <= limit) return;
    fail_pass(declaration_, pass, "binding-size",
        "shader '{}', binding '{}': {} bytes of {} are bound, the device binds at most {} as {}; "
        "bind a range of it",
        slot.shader, slot.binding.name, bytes,
        ockham::describe(declaration_.resources[use.resource]), limit, describe(slot.binding.type));
}

void Bindings::check_image(PassId pass, const Slot& slot, const Use& use) const {
    const gpu::ShaderBinding& binding = slot.binding;
    const ResourceDecl& resource = declaration_.resources[use.resource];
    const Part part = part_of(declaration_, use);
    const auto refuse = [&](const char* code, const std::string& what) {
        fail_pass(declaration_, pass, code, "shader '{}', binding '{}' of {}: {}", slot.shader,
            binding.name, ockham::describe(resource), what);
    };
    const bool is_3d = resource.image.depth > 1;
    if (is_3d != (binding.view_type == VK_IMAGE_VIEW_TYPE_3D)) {
        refuse("binding-dimension", fmt::format("the shader wants a {} image, but this is {}",
                                        dimension(binding.view_type), is_3d ? "3D" : "2D"));
    }
    if (binding.view_type == VK_IMAGE_VIEW_TYPE_2D && part.layers > 1) {
        refuse("binding-dimension",
            fmt::format("the shader wants one layer, but {} are declared; declare a layer of it, "
                        "or use a 2D array in the shader",
                part.layers));
    }
    if (binding.type == VK_DESCRIPTOR_TYPE_STORAGE_IMAGE) {
        if (part.mips > 1) {
            refuse("binding-dimension",
                fmt::format("a storage image has one mip, but {} are declared; declare a mip of it",
                    part.mips));
        }
        if (binding.format != VK_FORMAT_UNDEFINED && binding.format != resource.image.format) {
            refuse("binding-format",
                fmt::format("the shader declares format {}, but it is {}",
                    gpu::name_of(binding.format), gpu::name_of(resource.image.format)));
        }
    } else if (use.filter != Filter::texel &&
               !(device_.format_features(resource.image.format) &
                   VK_FORMAT_FEATURE_SAMPLED_IMAGE_FILTER_LINEAR_BIT)) {
        refuse("binding-filter",
            fmt::format("the device cannot filter format {} linearly; use Filter::texel",
                gpu::name_of(resource.image.format)));
    }
}

} // namespace ockham
