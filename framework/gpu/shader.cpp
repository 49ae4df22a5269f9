// SPDX-License-Identifier: Apache-2.0
#include "framework/gpu/shader.hpp"

#include "framework/core/error.hpp"
#include "framework/gpu/workgroup_memory.hpp"

#include <spirv_cross/spirv_cross_c.h>

#include <algorithm>
#include <map>
#include <memory>
#include <vector>

namespace ockham::gpu {

namespace {

using Registry = std::map<std::string_view, std::span<const std::uint32_t>>;

/// Made by the first registration, which runs before main().
Registry& registry() {
    static Registry shaders;
    return shaders;
}

} // namespace

ShaderRegistration::ShaderRegistration(std::span<const EmbeddedShader> table) {
    for (const EmbeddedShader& shader : table) {
        const auto [row, added] = registry().emplace(shader.name, shader.words);
        check(added || std::ranges::equal(row->second, shader.words),
            "two different shaders have one name");
    }
}

std::span<const std::uint32_t> find_shader(std::string_view name) {
    const auto found = registry().find(name);
    if (found != registry().end()) return found->second;
    // Variants of the same file, or else all files: hundreds of names would say nothing.
    const auto file_of = [](std::string_view shader) { return shader.substr(0, shader.find(':')); };
    std::vector<std::string_view> near = shader_names();
    std::erase_if(near, [&](std::string_view other) { return file_of(other) != file_of(name); });
    if (near.empty()) {
        near = shader_names();
        std::ranges::transform(near, near.begin(), file_of);
        near.erase(std::unique(near.begin(), near.end()), near.end());
    }
    fail_input("no shader '{}' is built in; add it with ockham_add_shaders() and link that target. "
               "Built in are: {}",
        name, fmt::join(near, ", "));
}

std::vector<std::string_view> shader_names() {
    std::vector<std::string_view> names;
    for (const auto& [name, words] : registry()) names.push_back(name);
    return names;
}

namespace {

struct ContextDeleter {
    void operator()(spvc_context_s* context) const { spvc_context_destroy(context); }
};

/// SPIRV-Cross over one module; its results live as long as this object.
class Reflector {
public:
    Reflector(std::string_view name, std::span<const std::uint32_t> words) : name_(name) {
        spvc_context context = nullptr;
        spvc_context_create(&context);
        context_.reset(context);
        spvc_parsed_ir ir = nullptr;
        expect(spvc_context_parse_spirv(context, words.data(), words.size(), &ir));
        expect(spvc_context_create_compiler(
            context, SPVC_BACKEND_NONE, ir, SPVC_CAPTURE_MODE_TAKE_OWNERSHIP, &compiler_));
        spvc_set active = nullptr;
        expect(spvc_compiler_get_active_interface_variables(compiler_, &active));
        expect(
            spvc_compiler_create_shader_resources_for_active_variables(compiler_, &used_, active));
        expect(spvc_compiler_create_shader_resources(compiler_, &declared_));
    }

    Reflection run() {
        Reflection result;
        result.name = name_;
        result.stage = stage();
        add(result, SPVC_RESOURCE_TYPE_UNIFORM_BUFFER, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER);
        add(result, SPVC_RESOURCE_TYPE_STORAGE_BUFFER, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER);
        add(result, SPVC_RESOURCE_TYPE_STORAGE_IMAGE, VK_DESCRIPTOR_TYPE_STORAGE_IMAGE);
        add(result, SPVC_RESOURCE_TYPE_SAMPLED_IMAGE, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER);
        refuse(
            SPVC_RESOURCE_TYPE_SEPARATE_IMAGE, "a separate texture; use a sampler2D or the like");
        refuse(SPVC_RESOURCE_TYPE_SEPARATE_SAMPLERS, "a separate sampler; use a sampler2D");
        refuse(SPVC_RESOURCE_TYPE_SUBPASS_INPUT, "a subpass input; use a sampler2D");
        refuse(SPVC_RESOURCE_TYPE_ACCELERATION_STRUCTURE, "an acceleration structure");
        read_push_constants(result);
        read_constants(result);
        check_budget(result);
        return result;
    }

private:
    void expect(spvc_result result) const {
        if (result == SPVC_SUCCESS) return;
        fail_input("shader '{}' cannot be read: {}", name_,
            spvc_context_get_last_error_string(context_.get()));
    }

    std::span<const spvc_reflected_resource> list(
        spvc_resources resources, spvc_resource_type type) const {
        const spvc_reflected_resource* items = nullptr;
        std::size_t count = 0;
        expect(spvc_resources_get_resource_list_for_type(resources, type, &items, &count));
        return {items, count};
    }

    std::string name_of(const spvc_reflected_resource& resource) const {
        const char* variable = spvc_compiler_get_name(compiler_, resource.id);
        return variable && *variable ? variable : resource.name;
    }

    VkShaderStageFlagBits stage() const {
        switch (spvc_compiler_get_execution_model(compiler_)) {
        case SpvExecutionModelGLCompute:
            return VK_SHADER_STAGE_COMPUTE_BIT;
        case SpvExecutionModelVertex:
            return VK_SHADER_STAGE_VERTEX_BIT;
        case SpvExecutionModelFragment:
            return VK_SHADER_STAGE_FRAGMENT_BIT;
        default:
            fail_input("shader '{}' is no compute, vertex or fragment shader", name_);
        }
    }

    void refuse(spvc_resource_type type, const char* what) const {
        for (const spvc_reflected_resource& resource : list(used_, type)) {
            fail_input("shader '{}', binding '{}' is {}", name_, name_of(resource), what);
        }
    }

    void add(Reflection& result, spvc_resource_type type, VkDescriptorType descriptor) const {
        for (const spvc_reflected_resource& resource : list(used_, type)) {
            ShaderBinding binding;
            binding.name = name_of(resource);
            binding.set =
                spvc_compiler_get_decoration(compiler_, resource.id, SpvDecorationDescriptorSet);
            binding.binding =
                spvc_compiler_get_decoration(compiler_, resource.id, SpvDecorationBinding);
            binding.type = descriptor;
            const spvc_type shape = spvc_compiler_get_type_handle(compiler_, resource.type_id);
            if (spvc_type_get_num_array_dimensions(shape) > 0) {
                fail_input("shader '{}', binding '{}' is an array of descriptors, which portable "
                           "devices cannot index; use array layers",
                    name_, binding.name);
            }
            read_direction(binding, resource.id);
            if (descriptor == VK_DESCRIPTOR_TYPE_STORAGE_IMAGE ||
                descriptor == VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER) {
                read_image(binding, shape);
            }
            result.bindings.push_back(std::move(binding));
        }
    }

    void read_direction(ShaderBinding& binding, SpvId id) const {
        if (binding.type == VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER ||
            binding.type == VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER) {
            binding.writes = false;
            return;
        }
        const auto restrict_to = [&](SpvDecoration decoration) {
            if (decoration == SpvDecorationNonWritable) binding.writes = false;
            if (decoration == SpvDecorationNonReadable) binding.reads = false;
        };
        for (const SpvDecoration d : {SpvDecorationNonWritable, SpvDecorationNonReadable}) {
            if (spvc_compiler_has_decoration(compiler_, id, d)) restrict_to(d);
        }
        if (binding.type == VK_DESCRIPTOR_TYPE_STORAGE_BUFFER) {
            const SpvDecoration* decorations = nullptr;
            std::size_t count = 0;
            expect(spvc_compiler_get_buffer_block_decorations(compiler_, id, &decorations, &count));
            for (std::size_t i = 0; i < count; ++i) restrict_to(decorations[i]);
        }
    }

    void read_image(ShaderBinding& binding, spvc_type shape) const {
        const SpvDim dimension = spvc_type_get_image_dimension(shape);
        const bool arrayed = spvc_type_get_image_arrayed(shape);
        const bool supported = dimension == SpvDim2D || (dimension == SpvDim3D && !arrayed);
        if (!supported || spvc_type_get_image_multisampled(shape)) {
            fail_input("shader '{}', binding '{}': only 2D, 2D array and 3D images with one sample "
                       "are supported",
                name_, binding.name);
        }
        binding.view_type = dimension == SpvDim3D ? VK_IMAGE_VIEW_TYPE_3D
                            : arrayed             ? VK_IMAGE_VIEW_TYPE_2D_ARRAY
                                                  : VK_IMAGE_VIEW_TYPE_2D;
        if (binding.type == VK_DESCRIPTOR_TYPE_STORAGE_IMAGE) {
            binding.format = vulkan_format(spvc_type_get_image_storage_format(shape));
        }
    }

    static VkFormat vulkan_format(SpvImageFormat format) {
        switch (format) {
        case SpvImageFormatR8:
            return VK_FORMAT_R8_UNORM;
        case SpvImageFormatRg8:
            return VK_FORMAT_R8G8_UNORM;
        case SpvImageFormatRgba8:
            return VK_FORMAT_R8G8B8A8_UNORM;
        case SpvImageFormatR8ui:
            return VK_FORMAT_R8_UINT;
        case SpvImageFormatRg8ui:
            return VK_FORMAT_R8G8_UINT;
        case SpvImageFormatRgba8ui:
            return VK_FORMAT_R8G8B8A8_UINT;
        case SpvImageFormatR16:
            return VK_FORMAT_R16_UNORM;
        case SpvImageFormatRg16:
            return VK_FORMAT_R16G16_UNORM;
        case SpvImageFormatRgba16:
            return VK_FORMAT_R16G16B16A16_UNORM;
        case SpvImageFormatR16ui:
            return VK_FORMAT_R16_UINT;
        case SpvImageFormatRg16ui:
            return VK_FORMAT_R16G16_UINT;
        case SpvImageFormatRgba16ui:
            return VK_FORMAT_R16G16B16A16_UINT;
        case SpvImageFormatR16f:
            return VK_FORMAT_R16_SFLOAT;
        case SpvImageFormatRg16f:
            return VK_FORMAT_R16G16_SFLOAT;
        case SpvImageFormatRgba16f:
            return VK_FORMAT_R16G16B16A16_SFLOAT;
        case SpvImageFormatRg16Snorm:
            return VK_FORMAT_R16G16_SNORM;
        case SpvImageFormatR32ui:
            return VK_FORMAT_R32_UINT;
        case SpvImageFormatRg32ui:
            return VK_FORMAT_R32G32_UINT;
        case SpvImageFormatRgba32ui:
            return VK_FORMAT_R32G32B32A32_UINT;
        case SpvImageFormatR32i:
            return VK_FORMAT_R32_SINT;
        case SpvImageFormatR32f:
            return VK_FORMAT_R32_SFLOAT;
        case SpvImageFormatRg32f:
            return VK_FORMAT_R32G32_SFLOAT;
        case SpvImageFormatRgba32f:
            return VK_FORMAT_R32G32B32A32_SFLOAT;
        case SpvImageFormatR11fG11fB10f:
            return VK_FORMAT_B10G11R11_UFLOAT_PACK32;
        case SpvImageFormatRgb10A2:
            return VK_FORMAT_A2B10G10R10_UNORM_PACK32;
        default:
            return VK_FORMAT_UNDEFINED;
        }
    }

    /// Declared, used or not: callers push one struct to all variants of a shader.
    void read_push_constants(Reflection& result) const {
        for (const spvc_reflected_resource& block :
            list(declared_, SPVC_RESOURCE_TYPE_PUSH_CONSTANT)) {
            std::size_t bytes = 0;
            expect(spvc_compiler_get_declared_struct_size(
                compiler_, spvc_compiler_get_type_handle(compiler_, block.base_type_id), &bytes));
            result.push_bytes = static_cast<std::uint32_t>(bytes);
        }
    }

    void read_constants(Reflection& result) const {
        const spvc_specialization_constant* constants = nullptr;
        std::size_t count = 0;
        expect(spvc_compiler_get_specialization_constants(compiler_, &constants, &count));
        for (std::size_t i = 0; i < count; ++i) {
            result.constant_ids.push_back(constants[i].constant_id);
        }
        if (result.stage != VK_SHADER_STAGE_COMPUTE_BIT) return;
        std::array<spvc_specialization_constant, 3> axes{};
        spvc_compiler_get_work_group_size_specialization_constants(
            compiler_, &axes[0], &axes[1], &axes[2]);
        for (unsigned i = 0; i < 3; ++i) {
            result.default_local_size[i] = spvc_compiler_get_execution_mode_argument_by_index(
                compiler_, SpvExecutionModeLocalSize, i);
            if (axes[i].id == 0) continue;
            result.local_size_ids[i] = axes[i].constant_id;
            result.default_local_size[i] = spvc_constant_get_scalar_u32(
                spvc_compiler_get_constant_handle(compiler_, axes[i].id), 0, 0);
        }
    }

    /// What both test drivers and every desktop GPU allow.
    void check_budget(const Reflection& result) const {
        std::uint32_t storage_images = 0;
        for (const ShaderBinding& binding : result.bindings) {
            if (binding.set >= 4) {
                fail_input("shader '{}', binding '{}' is in set {}; portable are sets 0 to 3",
                    name_, binding.name, binding.set);
            }
            storage_images += binding.type == VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
        }
        if (storage_images > 16) {
            fail_input("shader '{}' uses {} storage images; portable are at most 16", name_,
                storage_images);
        }
        if (result.push_bytes > 128) {
            fail_input("shader '{}' has {} bytes of push constants; portable are at most 128",
                name_, result.push_bytes);
        }
    }

    std::string name_;
    std::unique_ptr<spvc_context_s, ContextDeleter> context_;
    spvc_compiler compiler_ = nullptr;
    spvc_resources used_ = nullptr;
    spvc_resources declared_ = nullptr;
};

} // namespace

constexpr std::uint64_t kMaxWorkgroupBytes = 32 * 1024; ///< of both test drivers

std::array<std::uint32_t, 3> Reflection::local_size(const Specialization& specialization) const {
    std::array<std::uint32_t, 3> size = default_local_size;
    for (const auto& [id, value] : specialization) {
        for (std::size_t i = 0; i < 3; ++i) {
            if (local_size_ids[i] == id) size[i] = value;
        }
    }
    return size;
}

Reflection reflect(std::string_view name, std::span<const std::uint32_t> words) {
    Reflection result = Reflector(name, words).run();
    if (const std::uint64_t bytes = workgroup_bytes(words); bytes > kMaxWorkgroupBytes)
        fail_input("shader '{}' shares {} bytes in a workgroup; portable are at most {}", name,
            bytes, kMaxWorkgroupBytes);
    return result;
}

} // namespace ockham::gpu
