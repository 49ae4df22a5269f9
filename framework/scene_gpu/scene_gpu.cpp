// SPDX-License-Identifier: Apache-2.0
#include "framework/scene_gpu/scene_gpu.hpp"

#include "framework/core/error.hpp"
#include "framework/core/log.hpp"
#include "framework/gpu/device.hpp"
#include "framework/gpu/transfer.hpp"
#include "framework/scene_gpu/imports.hpp"
#include "framework/scene_gpu/texture_array.hpp"
#include "shaders/shared/scene.h"
#include "shaders/surface/gbuffer.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace ockham {
namespace {

constexpr std::size_t kMaxMaterials = ISO_MATERIAL; // bits of the packed G-buffer, less isosurfaces

/// Which images go into one array, each once.
class LayerList {
public:
    int add(const Scene& scene, int image, std::optional<float> alpha_cutoff) {
        const auto [found, added] = index_.try_emplace(image, static_cast<int>(layers_.size()));
        if (added) layers_.push_back({&scene.images[static_cast<std::size_t>(image)], {}});
        if (alpha_cutoff)
            layers_[static_cast<std::size_t>(found->second)].alpha_cutoff = alpha_cutoff;
        return found->second;
    }
    const std::vector<TextureLayer>& layers() const { return layers_; }

private:
    std::map<int, int> index_;
    std::vector<TextureLayer> layers_;
};

/// Half a texel: as close as a coordinate may come to a border that does not repeat.
glm::vec2 half_texel(const TextureImage& image) {
    return 0.5f / glm::vec2(image.width, image.height);
}

shader::UvMap uv_map(const TextureUse& use, glm::vec2 inset) {
    return {.u = use.transform_u,
        .v = use.transform_v,
        .inset = inset,
        .set = static_cast<std::uint32_t>(use.uv_set),
        .wrap = static_cast<std::uint32_t>(use.wrap_u) | static_cast<std::uint32_t>(use.wrap_v)
                                                             << 2};
}

/// Gives each image of a material a layer, and its coordinates one of the two slots that the
/// G-buffer can hold.
class MaterialBuilder {
public:
    MaterialBuilder(const Scene& scene, LayerList& color, LayerList& data)
        : scene_(scene), color_(color), data_(data) {}

    shader::MaterialData build(const Material& material) {
        slots_.clear();
        shader::MaterialData out{};
        out.base_color = material.base_color;
        out.emissive = material.emissive;
        out.metallic = material.metallic;
        out.roughness = material.roughness;
        const float ratio = (material.ior - 1.0f) / (material.ior + 1.0f);
        out.reflectance = ratio * ratio;
        out.normal_scale = material.normal_scale;
        out.occlusion_strength = material.occlusion_strength;
        out.alpha_cutoff = material.alpha_cutoff;
        out.flags = material.unlit ? MATERIAL_UNLIT : 0u;
        out.base_color_texture = reference(color_, material, material.base_color_texture,
            material.masked ? std::optional(material.alpha_cutoff) : std::nullopt);
        out.emissive_texture = reference(color_, material, material.emissive_texture, {});
        out.metallic_roughness_texture =
            reference(data_, material, material.metallic_roughness_texture, {});
        out.occlusion_texture = reference(data_, material, material.occlusion_texture, {});
        for (std::size_t i = 0; i < 2; ++i) {
            out.uv[i] = i < slots_.size() ? uv_map(*slots_[i].use, slots_[i].inset)
                                          : uv_map(TextureUse{}, glm::vec2(0.0f));
        }
        out.normal_texture = layer_of(data_, material.normal_texture, {});
        out.normal_texture.slot = 2;
        const TextureUse& bump = material.normal_texture;
        out.uv[2] = uv_map(bump, bump.used() ? half_texel(image_of(bump)) : glm::vec2(0.0f));
        return out;
    }

private:
    /// Coordinates that one or more images share.
    struct Slot {
        const TextureUse* use;
        glm::vec2 inset; ///< of the coarsest of them
    };

    const TextureImage& image_of(const TextureUse& use) const {
        return scene_.images[static_cast<std::size_t>(use.image)];
    }

    shader::TextureRef layer_of(
        LayerList& list, const TextureUse& use, std::optional<float> cutoff) {
        if (!use.used()) return {.layer = -1, .slot = 0, .size = glm::vec2(1.0f)};
        const TextureImage& image = image_of(use);
        return {.layer = list.add(scene_, use.image, cutoff),
            .slot = 0,
            .size = glm::vec2(image.width, image.height)};
    }

    shader::TextureRef reference(LayerList& list, const Material& material, const TextureUse& use,
        std::optional<float> cutoff) {
        shader::TextureRef ref = layer_of(list, use, cutoff);
        if (!use.used()) return ref;
        const auto same = [&](const Slot& slot) { return slot.use->same_coordinates(use); };
        auto found = std::find_if(slots_.begin(), slots_.end(), same);
        if (found == slots_.end() && slots_.size() == 2) {
            log::warning("material '{}': its images use more than two different sets of texture "
                         "coordinates; the third is read with the second's",
                material.name);
            found = slots_.end() - 1;
        } else if (found == slots_.end()) {
            slots_.push_back({&use, glm::vec2(0.0f)});
            found = slots_.end() - 1;
        }
        found->inset = glm::max(found->inset, half_texel(image_of(use)));
        ref.slot = static_cast<std::uint32_t>(found - slots_.begin());
        return ref;
    }

    const Scene& scene_;
    LayerList& color_;
    LayerList& data_;
    std::vector<Slot> slots_;
};

shader::LightData light_data(const Light& light) {
    shader::LightData out{};
    out.position = light.position;
    out.inverse_range_squared = std::isinf(light.range) ? 0.0f : 1.0f / (light.range * light.range);
    out.to_light = -light.direction;
    out.softening = light.softening;
    out.intensity = light.intensity;
    out.window_half_power = 0.5f * light.window_power;
    const float cos_outer = std::cos(light.outer_cone);
    out.cone_scale = 1.0f / std::max(0.001f, std::cos(light.inner_cone) - cos_outer);
    out.cone_offset = -cos_outer * out.cone_scale;
    return out;
}

/// Directional, then point, then spot, as the shaders loop over them.
std::vector<shader::LightData> light_table(const Scene& scene) {
    std::vector<shader::LightData> table;
    for (const LightType type : {LightType::directional, LightType::point, LightType::spot}) {
        for (const Light& light : scene.lights) {
            if (light.type == type) table.push_back(light_data(light));
        }
    }
    if (table.empty()) table.push_back({}); // a buffer has at least one byte; none is ever read
    return table;
}

VertexLayout layout_of(const Scene& scene, const SceneFacts& facts) {
    VertexLayout layout;
    bool second = false;
    for (const Material& material : scene.materials) {
        for (const TextureUse* use :
            {&material.base_color_texture, &material.emissive_texture, &material.normal_texture,
                &material.metallic_roughness_texture, &material.occlusion_texture}) {
            second = second || (use->used() && use->uv_set != 0);
        }
    }
    if (facts.normal_maps) layout.tangent = layout.stride++;
    if (second) layout.uv1 = layout.stride++;
    if (facts.vertex_colors) layout.color = layout.stride++;
    return layout;
}

void append_vertices(
    std::vector<glm::vec4>& out, const Primitive& primitive, const VertexLayout& layout) {
    const auto uv = [&](int set, std::size_t v) {
        return primitive.uvs[set].empty() ? glm::vec2(0.0f) : primitive.uvs[set][v];
    };
    for (std::size_t v = 0; v < primitive.positions.size(); ++v) {
        const std::size_t base = out.size();
        out.resize(base + layout.stride, glm::vec4(0.0f));
        glm::vec4* vertex = &out[base];
        vertex[0] = glm::vec4(primitive.positions[v], uv(0, v).x);
        vertex[1] = glm::vec4(primitive.normals[v], uv(0, v).y);
        if (layout.tangent != kNone && !primitive.tangents.empty())
            vertex[layout.tangent] = primitive.tangents[v];
        if (layout.uv1 != kNone) vertex[layout.uv1] = glm::vec4(uv(1, v), 0.0f, 0.0f);
        if (layout.color != kNone) {
            vertex[layout.color] = primitive.colors.empty() ? glm::vec4(1.0f) : primitive.colors[v];
        }
    }
}

/// Instances grouped by mesh and handedness, so that each group is one range.
struct InstanceGroups {
    std::vector<shader::InstanceData> table;
    struct Group {
        int mesh;
        bool mirrored;
        std::uint32_t first, count;
    };
    std::vector<Group> groups;
};

InstanceGroups group_instances(const Scene& scene) {
    std::map<std::pair<int, bool>, std::vector<const Instance*>> sorted;
    for (const Instance& instance : scene.instances) {
        sorted[{instance.mesh, glm::determinant(glm::mat3(instance.world)) < 0.0f}].push_back(
            &instance);
    }
    InstanceGroups out;
    for (const auto& [key, instances] : sorted) {
        out.groups.push_back({key.first, key.second, static_cast<std::uint32_t>(out.table.size()),
            static_cast<std::uint32_t>(instances.size())});
        for (const Instance* instance : instances) {
            const glm::mat4 rows = glm::transpose(instance->world);
            out.table.push_back({rows[0], rows[1], rows[2]});
        }
    }
    return out;
}

std::uint32_t blocks_of(const Primitive& primitive) {
    const auto triangles = static_cast<std::uint32_t>(primitive.indices.size() / 3);
    return (triangles + TRIANGLES_PER_BLOCK - 1) / TRIANGLES_PER_BLOCK;
}

void append_blocks(std::vector<shader::TriangleBlock>& out, const Draw& draw) {
    for (std::uint32_t instance = 0; instance < draw.instance_count; ++instance) {
        for (std::uint32_t block = 0; block < draw.blocks_per_instance; ++block) {
            out.push_back({draw.first_index + 3 * TRIANGLES_PER_BLOCK * block, draw.vertex_offset,
                draw.first_instance + instance, draw.material});
        }
    }
}

/// Makes the image in place, since the uploader remembers where it stands.
void make_array(std::optional<gpu::Image>& image, gpu::Device& device, gpu::Uploader& uploader,
    const std::vector<TextureLayer>& layers, bool srgb, const char* name, std::uint64_t& bytes,
    std::uint64_t& padding) {
    if (layers.empty()) return;
    // Before anything is built: layers are as large as the largest image.
    const auto [width, height] = texture_array_size(layers);
    const gpu::Limits& limits = device.limits();
    const std::uint64_t texels = std::uint64_t{width} * height * layers.size();
    const std::uint64_t budget = device.allocator().budget_bytes();
    if (budget > 0 && texels * 16 / 3 > budget) {
        fail_device(
            "{}: {} images padded to {} x {} texels need {} MiB with their mips, the memory "
            "budget is {} MiB; use smaller or fewer images, or raise --memory-budget",
            name, layers.size(), width, height, (texels * 16 / 3) >> 20, budget >> 20);
    }
    if (width > limits.image_extent || height > limits.image_extent ||
        layers.size() > limits.image_layers) {
        fail_input(
            "{}: {} images of up to {} x {} texels; this device holds {} layers of {} texels a "
            "side: use smaller or fewer images",
            name, layers.size(), width, height, limits.image_layers, limits.image_extent);
    }
    const TextureArray array = build_texture_array(layers, srgb);
    image.emplace(
        device, gpu::ImageInfo{.format = srgb ? VK_FORMAT_R8G8B8A8_SRGB : VK_FORMAT_R8G8B8A8_UNORM,
                    .width = array.width,
                    .height = array.height,
                    .layers = array.layers,
                    .mips = array.mips,
                    .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT,
                    .name = name});
    for (std::uint32_t layer = 0; layer < array.layers; ++layer) {
        for (std::uint32_t mip = 0; mip < array.mips; ++mip) {
            uploader.add(*image, layer, mip,
                std::as_bytes(std::span(array.texels[std::size_t{layer} * array.mips + mip])));
        }
    }
    bytes += array.bytes();
    padding += array.bytes() - array.native_bytes;
}

} // namespace

SceneGpu::SceneGpu(gpu::Device& device, const Scene& scene)
    : facts_(facts_of(scene)), layout_(layout_of(scene, facts_)), bounds_(scene.bounds()) {
    if (scene.materials.size() > kMaxMaterials) {
        fail_input("scene '{}' has {} materials; at most {} can be told apart", scene.name,
            scene.materials.size(), kMaxMaterials);
    }
    const InstanceGroups instances = group_instances(scene);
    std::vector<glm::vec4> vertices;
    std::vector<std::uint32_t> indices;
    std::vector<shader::TriangleBlock> blocks(1); // ids start in the second
    std::vector<bool> material_used(scene.materials.size(), false);
    struct Range {
        std::uint32_t first_index;
        std::int32_t vertex_offset;
    };
    std::map<const Primitive*, Range> ranges;
    for (const InstanceGroups::Group& group : instances.groups) {
        for (const Primitive& primitive :
            scene.meshes[static_cast<std::size_t>(group.mesh)].primitives) {
            if (primitive.indices.empty()) continue;
            const auto [range, added] = ranges.try_emplace(
                &primitive, Range{static_cast<std::uint32_t>(indices.size()),
                                static_cast<std::int32_t>(vertices.size() / layout_.stride)});
            if (added) {
                append_vertices(vertices, primitive, layout_);
                indices.insert(indices.end(), primitive.indices.begin(), primitive.indices.end());
            }
            const auto material = static_cast<std::size_t>(primitive.material);
            material_used[material] = true;
            draws_.push_back({.first_index = range->second.first_index,
                .index_count = static_cast<std::uint32_t>(primitive.indices.size()),
                .vertex_offset = range->second.vertex_offset,
                .first_instance = group.first,
                .instance_count = group.count,
                .material = static_cast<std::uint32_t>(primitive.material),
                .first_block = static_cast<std::uint32_t>(blocks.size()),
                .blocks_per_instance = blocks_of(primitive),
                .masked = scene.materials[material].masked,
                .double_sided = scene.materials[material].double_sided,
                .mirrored = group.mirrored});
            append_blocks(blocks, draws_.back());
        }
    }

    LayerList color, data;
    MaterialBuilder builder(scene, color, data);
    std::vector<shader::MaterialData> materials;
    for (std::size_t i = 0; i < scene.materials.size(); ++i) {
        // Images of materials that nothing shows stay on the host.
        materials.push_back(
            material_used[i] ? builder.build(scene.materials[i]) : shader::MaterialData{});
    }
    if (materials.empty()) materials.push_back({});

    gpu::Uploader uploader(device);
    const auto make_buffer = [&](std::optional<gpu::Buffer>& buffer, const char* name,
                                 std::span<const std::byte> bytes, VkBufferUsageFlags usage) {
        if (bytes.empty()) return;
        buffer.emplace(device, gpu::BufferInfo{.bytes = bytes.size(),
                                   .usage = usage | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                                   .name = name});
        uploader.add(*buffer, bytes);
        bytes_ += bytes.size();
    };
    const auto bytes_of = [](const auto& values) { return std::as_bytes(std::span(values)); };
    constexpr VkBufferUsageFlags kStorage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
    make_buffer(vertices_, "vertices", bytes_of(vertices), kStorage);
    make_buffer(
        indices_, "indices", bytes_of(indices), kStorage | VK_BUFFER_USAGE_INDEX_BUFFER_BIT);
    if (!draws_.empty()) make_buffer(instances_, "instances", bytes_of(instances.table), kStorage);
    make_buffer(triangle_blocks_, "triangle_blocks", bytes_of(blocks), kStorage);
    constexpr VkBufferUsageFlags kEither = kStorage | VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT;
    make_buffer(materials_, "materials", bytes_of(materials), kEither);
    make_buffer(lights_, "lights", bytes_of(light_table(scene)), kEither);
    make_array(color_textures_, device, uploader, color.layers(), true, "color_textures", bytes_,
        padding_bytes_);
    make_array(data_textures_, device, uploader, data.layers(), false, "data_textures", bytes_,
        padding_bytes_);
    uploader.finish();
}

SceneHandles SceneGpu::import(Graph& graph) const {
    return {import_buffer(graph, vertices_), import_buffer(graph, indices_),
        import_buffer(graph, instances_), import_buffer(graph, triangle_blocks_),
        import_buffer(graph, materials_), import_buffer(graph, lights_),
        import_image(graph, color_textures_), import_image(graph, data_textures_)};
}

void SceneGpu::bind(Executor& executor, const SceneHandles& handles) const {
    bind_import(executor, handles.vertices, vertices_);
    bind_import(executor, handles.indices, indices_);
    bind_import(executor, handles.instances, instances_);
    bind_import(executor, handles.triangle_blocks, triangle_blocks_);
    bind_import(executor, handles.materials, materials_);
    bind_import(executor, handles.lights, lights_);
    bind_import(executor, handles.color_textures, color_textures_);
    bind_import(executor, handles.data_textures, data_textures_);
}

} // namespace ockham
