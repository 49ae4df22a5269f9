// SPDX-License-Identifier: Apache-2.0
// Compute and raster pipelines made from shader names, with the layouts that reflection implies.
// Each is made once per device and kept; the driver's cache is kept on disk. The runtime asks here;
// passes name shaders only. Can take shaders from elsewhere while the program runs (hot reload).
#pragma once

#include "framework/gpu/pipeline_layout.hpp"
#include "framework/gpu/shader.hpp"

#include <vulkan/vulkan.h>

#include <deque>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace ockham::gpu {

class Device;

struct Pipeline {
    VkPipeline handle = VK_NULL_HANDLE;
    const PipelineLayout* layout = nullptr;
    std::string shaders; ///< "surface/metrics.comp", "a.vert + a.frag"
    std::array<std::uint32_t, 3> local_size{1, 1, 1};
};

struct Attachment {
    VkFormat format = VK_FORMAT_UNDEFINED;
    VkAttachmentLoadOp load = VK_ATTACHMENT_LOAD_OP_DONT_CARE;
    bool depth = false; ///< or stencil; at most one, the last

    auto operator<=>(const Attachment&) const = default;
};

/// Triangles without vertex layout; viewport, scissor, cull mode, front face and stencil reference
/// are dynamic.
struct RasterState {
    std::string vertex_shader;
    std::string fragment_shader = {}; ///< empty: depth only
    Specialization specialization = {};
    bool depth_test = true; ///< passes where greater: reversed depth
    bool depth_write = true;
    bool depth_equal = false;   ///< passes where equal, not where greater
    bool stencil_write = false; ///< of what the fragment shader exports
    bool stencil_equal = false; ///< passes where equal to the dynamic reference

    auto operator<=>(const RasterState&) const = default;
};

/// Safe to call from several threads; what it returns lives as long as the device.
class Pipelines {
public:
    /// `cache_dir` empty: nothing on disk.
    Pipelines(Device& device, std::filesystem::path cache_dir);
    /// Writes the driver's cache if it has grown; a failure to do so is a debug message.
    ~Pipelines();
    Pipelines(const Pipelines&) = delete;
    Pipelines& operator=(const Pipelines&) = delete;

    /// Throw Error(input) naming the shader: unknown, wrong stage, unknown constant id, more than
    /// 256 invocations per workgroup, stages that disagree about a binding.
    const Pipeline& compute(std::string_view shader, const Specialization& specialization);
    const Pipeline& raster(const RasterState& state, const std::vector<Attachment>& attachments);
    /// Attachments keep their attachment layout; dependencies are the caller's barriers.
    VkRenderPass render_pass(const std::vector<Attachment>& attachments);
    std::size_t count() const; ///< pipelines in use

    /// From now on shaders are asked of `source` first, when a pipeline uses them and at reload().
    /// What it has must bind no more than the embedded shader and nothing in another way, for
    /// passes are declared for that one. Otherwise, and where it does not compile or makes no
    /// pipeline, the error is logged, and what was in use stays: the embedded shader at first.
    void reload_from(std::unique_ptr<ShaderSource> source);
    /// Takes up what has changed in the source, all of it or, where any of it fails, nothing. Then
    /// compute() and raster() return other pipelines than before. Call it between executions;
    /// without a source it does nothing.
    void reload();

    /// The cache file of this device; empty if there is none.
    const std::filesystem::path& cache_file() const { return cache_file_; }

private:
    using Shaders = std::vector<std::string>; ///< names, by stage
    using ComputeKey = std::pair<std::string, Specialization>;
    using RasterKey = std::pair<RasterState, std::vector<Attachment>>;
    using Key = std::variant<ComputeKey, RasterKey>;
    struct Shader {
        Reflection reflection;
        std::vector<std::uint32_t> reloaded; ///< SPIR-V; empty: the embedded one

        std::span<const std::uint32_t> words() const {
            return reloaded.empty() ? find_shader(reflection.name) : std::span(reloaded);
        }
    };
    /// What names and keys stand for now. Copied before a reload, to go back to if that fails.
    struct Tables {
        std::map<std::string, Shader> shaders;
        std::map<Shaders, const PipelineLayout*> layouts;
        std::map<Key, const Pipeline*> pipelines;
    };

    static Shaders shaders_of(const Key& key);
    const Pipeline& get(const Key& key);
    const Pipeline& make(const Key& key);
    Pipeline make_compute(const ComputeKey& key);
    Pipeline make_raster(const RasterKey& key);
    const Shader& shader(const std::string& name);
    const PipelineLayout& layout(const Shaders& shaders);
    VkRenderPass render_pass_locked(const std::vector<Attachment>& attachments);
    bool set_shader(const std::string& name, std::vector<std::uint32_t> words);
    void remake(const std::set<std::string>& changed);
    void take_up(const std::set<std::string>& names);
    void load_cache(const std::filesystem::path& folder);
    void save_cache() const;

    Device& device_;
    std::filesystem::path cache_file_;
    std::size_t loaded_bytes_ = 0;
    VkPipelineCache cache_ = VK_NULL_HANDLE;
    mutable std::mutex mutex_;
    Tables now_;
    std::map<std::vector<Attachment>, VkRenderPass> render_passes_;
    /// All ever made, those replaced too: they may be recorded or executing.
    std::deque<PipelineLayout> layouts_;
    std::deque<Pipeline> pipelines_;
    std::unique_ptr<ShaderSource> source_;
    std::set<std::string> pending_; ///< changed in the source, but not taken up: a reload failed
};

} // namespace ockham::gpu
