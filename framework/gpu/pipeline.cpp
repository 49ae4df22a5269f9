// SPDX-License-Identifier: Apache-2.0
#include "framework/gpu/pipeline.hpp"

#include "framework/core/error.hpp"
#include "framework/core/file.hpp"
#include "framework/core/log.hpp"
#include "framework/gpu/device.hpp"

#include <algorithm>
#include <cstring>

namespace ockham::gpu {

namespace {

const char* name_of(VkShaderStageFlagBits stage) {
    switch (stage) {
    case VK_SHADER_STAGE_COMPUTE_BIT:
        return "compute";
    case VK_SHADER_STAGE_VERTEX_BIT:
        return "vertex";
    case VK_SHADER_STAGE_FRAGMENT_BIT:
        return "fragment";
    default:
        return "other";
    }
}

void expect_stage(const Reflection& shader, VkShaderStageFlagBits stage) {
    if (shader.stage == stage) return;
    fail_input("shader '{}' is a {} shader, but is used as a {} shader", shader.name,
        name_of(shader.stage), name_of(stage));
}

/// A shader module that lives while pipelines are made from it.
class Module {
public:
    Module(const Device& device, const std::string& name, std::span<const std::uint32_t> words)
        : device_(device) {
        const VkShaderModuleCreateInfo info{.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO,
            .codeSize = words.size_bytes(),
            .pCode = words.data()};
        expect(vkCreateShaderModule(device.handle(), &info, nullptr, &handle),
            fmt::format("creating the module of shader '{}'", name));
        set_name(device, VK_OBJECT_TYPE_SHADER_MODULE, handle, name);
    }
    ~Module() { vkDestroyShaderModule(device_.handle(), handle, nullptr); }
    Module(const Module&) = delete;
    Module& operator=(const Module&) = delete;

    VkShaderModule handle = VK_NULL_HANDLE;

private:
    const Device& device_;
};

/// VkSpecializationInfo with the tables that it points to.
struct SpecializationTable {
    explicit SpecializationTable(const Specialization& specialization) {
        for (const auto& [id, value] : specialization) {
            entries.push_back({.constantID = id,
                .offset = static_cast<std::uint32_t>(values.size() * sizeof(std::uint32_t)),
                .size = sizeof(std::uint32_t)});
            values.push_back(value);
        }
        info = {.mapEntryCount = static_cast<std::uint32_t>(entries.size()),
            .pMapEntries = entries.data(),
            .dataSize = values.size() * sizeof(std::uint32_t),
            .pData = values.data()};
    }
    SpecializationTable(const SpecializationTable&) = delete;
    SpecializationTable& operator=(const SpecializationTable&) = delete;

    std::vector<VkSpecializationMapEntry> entries;
    std::vector<std::uint32_t> values;
    VkSpecializationInfo info{};
};

/// Every constant must exist in one of the shaders at least.
void check_constants(
    const Specialization& specialization, std::span<const Reflection* const> shaders) {
    for (const auto& [id, value] : specialization) {
        const bool known = std::ranges::any_of(shaders, [id = id](const Reflection* shader) {
            return std::ranges::find(shader->constant_ids, id) != shader->constant_ids.end();
        });
        if (!known) {
            fail_input("shader '{}' has no specialisation constant {}; it has: {}",
                shaders.front()->name, id, fmt::join(shaders.front()->constant_ids, ", "));
        }
    }
}

void check_group(const Reflection& shader, const std::array<std::uint32_t, 3>& size) {
    const std::uint64_t invocations = std::uint64_t{size[0]} * size[1] * size[2];
    if (invocations >= 1 && invocations <= 256) return;
    fail_input("shader '{}' has workgroups of {} x {} x {} = {} invocations; portable are 1 to 256",
        shader.name, size[0], size[1], size[2], invocations);
}

VkPipelineShaderStageCreateInfo stage_info(
    VkShaderStageFlagBits stage, const Module& module, const SpecializationTable& table) {
    return {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
        .stage = stage,
        .module = module.handle,
        .pName = "main",
        .pSpecializationInfo = &table.info};
}

} // namespace

Pipelines::Pipelines(Device& device, std::filesystem::path cache_dir) : device_(device) {
    load_cache(cache_dir);
}

Pipelines::~Pipelines() {
    save_cache();
    const VkDevice device = device_.handle();
    for (const Pipeline& pipeline : pipelines_) {
        vkDestroyPipeline(device, pipeline.handle, nullptr);
    }
    for (const auto& [key, pass] : render_passes_) vkDestroyRenderPass(device, pass, nullptr);
    for (const PipelineLayout& layout : layouts_) {
        vkDestroyPipelineLayout(device, layout.handle, nullptr);
        for (const VkDescriptorSetLayout set : layout.sets) {
            vkDestroyDescriptorSetLayout(device, set, nullptr);
        }
    }
    vkDestroyPipelineCache(device, cache_, nullptr);
}

std::size_t Pipelines::count() const {
    const std::lock_guard lock(mutex_);
    return now_.pipelines.size();
}

const Pipeline& Pipelines::compute(std::string_view shader, const Specialization& specialization) {
    return get(ComputeKey(shader, specialization));
}

const Pipeline& Pipelines::raster(
    const RasterState& state, const std::vector<Attachment>& attachments) {
    return get(RasterKey(state, attachments));
}

Pipelines::Shaders Pipelines::shaders_of(const Key& key) {
    if (const auto* const compute = std::get_if<ComputeKey>(&key)) return {compute->first};
    const RasterState& state = std::get<RasterKey>(key).first;
    if (state.fragment_shader.empty()) return {state.vertex_shader};
    return {state.vertex_shader, state.fragment_shader};
}

const Pipeline& Pipelines::get(const Key& key) {
    const std::lock_guard lock(mutex_);
    const auto found = now_.pipelines.find(key);
    if (found != now_.pipelines.end()) return *found->second;
    if (!source_) return make(key);

    // The embedded shaders first: they are the last good ones, should the source's fail.
    const Shaders names = shaders_of(key);
    std::set<std::string> unseen, reloaded;
    for (const std::string& name : names) {
        const auto row = now_.shaders.find(name);
        if (row == now_.shaders.end()) {
            unseen.insert(name);
        } else if (!row->second.reloaded.empty()) {
            reloaded.insert(name);
        }
    }
    try {
        make(key);
    } catch (const Error& error) {
        // What was reloaded for other pipelines need not do for these constants or this partner.
        if (reloaded.empty()) throw;
        log::error("reloaded shaders are given up for those built in: {}", error.what());
        for (const std::string& name : reloaded) set_shader(name, {});
        remake(reloaded);
        pending_.insert(reloaded.begin(), reloaded.end());
        make(key);
    }
    if (!unseen.empty()) take_up(unseen);
    return *now_.pipelines.at(key);
}

const Pipeline& Pipelines::make(const Key& key) {
    const auto* const compute = std::get_if<ComputeKey>(&key);
    pipelines_.push_back(compute ? make_compute(*compute) : make_raster(std::get<RasterKey>(key)));
    const Pipeline& pipeline = pipelines_.back();
    set_name(device_, VK_OBJECT_TYPE_PIPELINE, pipeline.handle, pipeline.shaders);
    now_.pipelines[key] = &pipeline;
    return pipeline;
}

const Pipelines::Shader& Pipelines::shader(const std::string& name) {
    const auto found = now_.shaders.find(name);
    if (found != now_.shaders.end()) return found->second;
    return now_.shaders.emplace(name, Shader{reflect(name, find_shader(name)), {}}).first->second;
}

const PipelineLayout& Pipelines::layout(const Shaders& shaders) {
    const auto found = now_.layouts.find(shaders);
    if (found != now_.layouts.end()) return *found->second;
    std::vector<const Reflection*> reflections;
    bool reloaded = false;
    for (const std::string& name : shaders) {
        const Shader& used = shader(name);
        reflections.push_back(&used.reflection);
        reloaded |= !used.reloaded.empty();
    }
    const std::string text = fmt::format("{}", fmt::join(shaders, " + "));
    PipelineLayout layout = layout_of(reflections);
    if (reloaded) {
        std::vector<Reflection> embedded;
        for (const std::string& name : shaders)
            embedded.push_back(reflect(name, find_shader(name)));
        for (std::size_t i = 0; i < embedded.size(); ++i) reflections[i] = &embedded[i];
        expect_fits(layout, layout_of(reflections), text);
    }
    layouts_.push_back(std::move(layout));
    create_handles(device_, layouts_.back(), text);
    return *now_.layouts.emplace(shaders, &layouts_.back()).first->second;
}

Pipeline Pipelines::make_compute(const ComputeKey& key) {
    const auto& [name, specialization] = key;
    const Shader& used = shader(name);
    const Reflection& reflected = used.reflection;
    expect_stage(reflected, VK_SHADER_STAGE_COMPUTE_BIT);
    const Reflection* const shaders[] = {&reflected};
    check_constants(specialization, shaders);
    Pipeline pipeline{.shaders = name, .local_size = reflected.local_size(specialization)};
    check_group(reflected, pipeline.local_size);
    pipeline.layout = &layout({name});
    const Module module(device_, name, used.words());
    const SpecializationTable table(specialization);
    const VkComputePipelineCreateInfo info{.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
        .stage = stage_info(VK_SHADER_STAGE_COMPUTE_BIT, module, table),
        .layout = pipeline.layout->handle};
    expect(vkCreateComputePipelines(device_.handle(), cache_, 1, &info, nullptr, &pipeline.handle),
        fmt::format("creating the pipeline of shader '{}'", name));
    log::debug("pipeline of shader '{}'", name);
    return pipeline;
}

VkRenderPass Pipelines::render_pass(const std::vector<Attachment>& attachments) {
    const std::lock_guard lock(mutex_);
    return render_pass_locked(attachments);
}

VkRenderPass Pipelines::render_pass_locked(const std::vector<Attachment>& attachments) {
    VkRenderPass& pass = render_passes_[attachments];
    if (pass) return pass;
    std::vector<VkAttachmentDescription> descriptions;
    std::vector<VkAttachmentReference> colors;
    VkAttachmentReference depth{.attachment = VK_ATTACHMENT_UNUSED};
    for (const Attachment& attachment : attachments) {
        const VkImageLayout layout = attachment.depth
                                         ? VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL
                                         : VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
        const VkAttachmentReference reference{
            .attachment = static_cast<std::uint32_t>(descriptions.size()), .layout = layout};
        if (attachment.depth) {
            depth = reference;
        } else {
            colors.push_back(reference);
        }
        descriptions.push_back({.format = attachment.format,
            .samples = VK_SAMPLE_COUNT_1_BIT,
            .loadOp = attachment.load,
            .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
            .stencilLoadOp = attachment.load,
            .stencilStoreOp = VK_ATTACHMENT_STORE_OP_STORE,
            .initialLayout = layout,
            .finalLayout = layout});
    }
    const VkSubpassDescription subpass{.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS,
        .colorAttachmentCount = static_cast<std::uint32_t>(colors.size()),
        .pColorAttachments = colors.data(),
        .pDepthStencilAttachment = &depth};
    const VkRenderPassCreateInfo info{.sType = VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO,
        .attachmentCount = static_cast<std::uint32_t>(descriptions.size()),
        .pAttachments = descriptions.data(),
        .subpassCount = 1,
        .pSubpasses = &subpass};
    expect(vkCreateRenderPass(device_.handle(), &info, nullptr, &pass), "creating a render pass");
    return pass;
}

Pipeline Pipelines::make_raster(const RasterKey& key) {
    const auto& [state, attachments] = key;
    const Shaders shaders = shaders_of(key);
    constexpr VkShaderStageFlagBits kStages[] = {
        VK_SHADER_STAGE_VERTEX_BIT, VK_SHADER_STAGE_FRAGMENT_BIT};
    std::vector<const Reflection*> reflections;
    for (std::size_t i = 0; i < shaders.size(); ++i) {
        reflections.push_back(&shader(shaders[i]).reflection);
        expect_stage(*reflections[i], kStages[i]);
    }
    check_constants(state.specialization, reflections);
    Pipeline pipeline{
        .layout = &layout(shaders), .shaders = fmt::format("{}", fmt::join(shaders, " + "))};

    std::vector<std::unique_ptr<Module>> modules;
    std::vector<VkPipelineShaderStageCreateInfo> stages;
    const SpecializationTable table(state.specialization);
    for (std::size_t i = 0; i < shaders.size(); ++i) {
        modules.push_back(
            std::make_unique<Module>(device_, shaders[i], shader(shaders[i]).words()));
        stages.push_back(stage_info(kStages[i], *modules.back(), table));
    }
    const VkPipelineVertexInputStateCreateInfo no_vertices{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
    const VkPipelineInputAssemblyStateCreateInfo triangles{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
        .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST};
    const VkPipelineViewportStateCreateInfo viewport{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO,
        .viewportCount = 1,
        .scissorCount = 1};
    const VkPipelineRasterizationStateCreateInfo rasterization{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO,
        .polygonMode = VK_POLYGON_MODE_FILL,
        .lineWidth = 1};
    const VkPipelineMultisampleStateCreateInfo one_sample{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO,
        .rasterizationSamples = VK_SAMPLE_COUNT_1_BIT};
    const VkStencilOpState stencil{.failOp = VK_STENCIL_OP_KEEP,
        .passOp = state.stencil_write ? VK_STENCIL_OP_REPLACE : VK_STENCIL_OP_KEEP,
        .depthFailOp = VK_STENCIL_OP_KEEP,
        .compareOp = state.stencil_equal ? VK_COMPARE_OP_EQUAL : VK_COMPARE_OP_ALWAYS,
        .compareMask = 0xff,
        .writeMask = 0xff};
    const VkPipelineDepthStencilStateCreateInfo depth{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO,
        .depthTestEnable = state.depth_test,
        .depthWriteEnable = state.depth_write,
        .depthCompareOp = state.depth_equal ? VK_COMPARE_OP_EQUAL : VK_COMPARE_OP_GREATER,
        .stencilTestEnable = state.stencil_write || state.stencil_equal,
        .front = stencil,
        .back = stencil};
    const auto color_count = std::ranges::count(attachments, false, &Attachment::depth);
    const std::vector<VkPipelineColorBlendAttachmentState> opaque(
        static_cast<std::size_t>(color_count), {.colorWriteMask = 0xf});
    const VkPipelineColorBlendStateCreateInfo blend{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO,
        .attachmentCount = static_cast<std::uint32_t>(opaque.size()),
        .pAttachments = opaque.data()};
    constexpr VkDynamicState kDynamic[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR,
        VK_DYNAMIC_STATE_CULL_MODE, VK_DYNAMIC_STATE_FRONT_FACE,
        VK_DYNAMIC_STATE_STENCIL_REFERENCE};
    const VkPipelineDynamicStateCreateInfo dynamic{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO,
        .dynamicStateCount = std::size(kDynamic),
        .pDynamicStates = kDynamic};
    const VkGraphicsPipelineCreateInfo info{
        .sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
        .stageCount = static_cast<std::uint32_t>(stages.size()),
        .pStages = stages.data(),
        .pVertexInputState = &no_vertices,
        .pInputAssemblyState = &triangles,
        .pViewportState = &viewport,
        .pRasterizationState = &rasterization,
        .pMultisampleState = &one_sample,
        .pDepthStencilState = &depth,
        .pColorBlendState = &blend,
        .pDynamicState = &dynamic,
        .layout = pipeline.layout->handle,
        .renderPass = render_pass_locked(attachments)};
    expect(vkCreateGraphicsPipelines(device_.handle(), cache_, 1, &info, nullptr, &pipeline.handle),
        fmt::format("creating the pipeline of shaders '{}'", pipeline.shaders));
    log::debug("pipeline of shaders '{}'", pipeline.shaders);
    return pipeline;
}

void Pipelines::reload_from(std::unique_ptr<ShaderSource> source) {
    check(source != nullptr, "reload_from() without a source");
    const std::lock_guard lock(mutex_);
    source_ = std::move(source);
    std::set<std::string> names;
    for (const auto& [name, used] : now_.shaders) names.insert(name);
    take_up(names);
}

void Pipelines::reload() {
    const std::lock_guard lock(mutex_);
    if (!source_) return;
    const std::vector<std::string> changed = source_->changed();
    if (changed.empty()) return;
    // What an earlier failure left out may belong to what mends it.
    std::set<std::string> names = pending_;
    names.insert(changed.begin(), changed.end());
    take_up(names);
}

/// Empty words: the embedded ones. False if that is what the name stands for already.
bool Pipelines::set_shader(const std::string& name, std::vector<std::uint32_t> words) {
    const std::span<const std::uint32_t> embedded = find_shader(name);
    if (std::ranges::equal(words, embedded)) words.clear();
    Shader& current = now_.shaders.at(name);
    if (current.reloaded == words) return false;
    current.reflection = reflect(name, words.empty() ? embedded : words);
    current.reloaded = std::move(words);
    return true;
}

/// Makes anew what consists of these shaders.
void Pipelines::remake(const std::set<std::string>& changed) {
    const auto is_changed = [&](const std::string& name) { return changed.contains(name); };
    std::erase_if(
        now_.layouts, [&](const auto& row) { return std::ranges::any_of(row.first, is_changed); });
    std::vector<Key> keys;
    for (const auto& [key, pipeline] : now_.pipelines) {
        if (std::ranges::any_of(shaders_of(key), is_changed)) keys.push_back(key);
    }
    for (const Key& key : keys) make(key);
}

/// Asks the source for these shaders and uses all of them or none; errors are logged.
void Pipelines::take_up(const std::set<std::string>& names) {
    Tables before = now_;
    try {
        std::set<std::string> changed;
        for (const std::string& name : names) {
            if (set_shader(name, source_->load(name))) changed.insert(name);
        }
        remake(changed);
        bool mended = false;
        for (const std::string& name : names) mended |= pending_.erase(name) > 0;
        if (mended || !changed.empty()) {
            log::info("reloaded shaders: {}", fmt::join(mended ? names : changed, ", "));
        }
    } catch (const std::exception& error) {
        now_ = std::move(before);
        pending_.insert(names.begin(), names.end());
        log::error("shaders are not reloaded, those in use stay: {}", error.what());
    }
}

void Pipelines::load_cache(const std::filesystem::path& folder) {
    VkPhysicalDeviceProperties properties;
    vkGetPhysicalDeviceProperties(device_.physical(), &properties);
    std::vector<std::byte> data;
    if (!folder.empty()) {
        std::string id;
        for (const std::uint8_t byte : properties.pipelineCacheUUID)
            id += fmt::format("{:02x}", byte);
        cache_file_ = folder / fmt::format("pipelines-{:04x}-{:04x}-{}.bin", properties.vendorID,
                                   properties.deviceID, id);
        try {
            if (std::filesystem::exists(cache_file_)) data = read_file(cache_file_);
        } catch (const std::exception& error) {
            log::debug("pipeline cache ignored: {}", error.what());
        }
    }
    // Drivers check the header too, but not all of them survive garbage.
    VkPipelineCacheHeaderVersionOne header{};
    if (data.size() >= sizeof header) std::memcpy(&header, data.data(), sizeof header);
    const bool matches =
        header.headerSize == sizeof header &&
        header.headerVersion == VK_PIPELINE_CACHE_HEADER_VERSION_ONE &&
        header.vendorID == properties.vendorID && header.deviceID == properties.deviceID &&
        std::memcmp(header.pipelineCacheUUID, properties.pipelineCacheUUID, VK_UUID_SIZE) == 0;
    if (!data.empty() && !matches) {
        log::debug(
            "pipeline cache ignored: {} is of another device or driver", cache_file_.string());
        data.clear();
    }
    loaded_bytes_ = data.size();
    const VkPipelineCacheCreateInfo info{.sType = VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO,
        .initialDataSize = data.size(),
        .pInitialData = data.data()};
    expect(vkCreatePipelineCache(device_.handle(), &info, nullptr, &cache_),
        "creating a pipeline cache");
}

void Pipelines::save_cache() const {
    if (cache_file_.empty()) return;
    try {
        std::size_t bytes = 0;
        expect(vkGetPipelineCacheData(device_.handle(), cache_, &bytes, nullptr),
            "reading the pipeline cache");
        if (bytes <= loaded_bytes_) return;
        std::vector<std::byte> data(bytes);
        expect(vkGetPipelineCacheData(device_.handle(), cache_, &bytes, data.data()),
            "reading the pipeline cache");
        data.resize(bytes);
        std::filesystem::create_directories(cache_file_.parent_path());
        write_file(cache_file_, data);
    } catch (const std::exception& error) {
        log::debug("pipeline cache not saved: {}", error.what());
    }
}

} // namespace ockham::gpu
