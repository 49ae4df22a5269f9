// SPDX-License-Identifier: Apache-2.0
// One logical Vulkan device. Knows no window: who has one names the extensions. Chooses the
// physical device by score and says why each of the others was refused, or stands on handles that
// the caller has. Owns what all graphs on it share: queues, memory, pipelines, samplers. Executor
// and uploads refer to it.
#pragma once

#include "framework/gpu/debug.hpp"
#include "framework/gpu/memory.hpp"
#include "framework/gpu/queue.hpp"

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace ockham::gpu {

class Pipelines;
struct Features;

struct DeviceOptions {
    /// Index in list_gpus(), or part of a name, case ignored; empty: the best score.
    std::string gpu = {};
    Validation validation = Validation::off;
    /// Refuses allocations beyond; 0 = the sum of the device's own heaps.
    std::uint64_t memory_budget_bytes = 0;
    /// Compiled pipelines are kept here; empty: $XDG_CACHE_HOME/ockham or ~/.cache/ockham.
    std::filesystem::path cache_dir = {};
    /// Descriptor sets from pools even where push descriptors exist; also by the environment:
    /// OCKHAM_FORCE_DESCRIPTOR_SETS=1.
    bool force_descriptor_sets = false;
    /// Where device memory comes from; empty: from Vulkan.
    MemoryHook memory_hook = {};
    /// More of them, for programs with a window; an instance or device without them is an Error.
    std::vector<std::string> instance_extensions = {}, device_extensions = {};
};

/// A queue of an embedder.
struct ExternalQueue {
    VkQueue handle = VK_NULL_HANDLE;
    std::uint32_t family = 0;
};

/// Handles of an embedder, who keeps them alive and destroys them. What was enabled cannot be asked
/// of Vulkan, so the embedder states it.
struct ExternalDevice {
    VkInstance instance = VK_NULL_HANDLE; ///< made for Vulkan 1.3 or later
    VkPhysicalDevice physical = VK_NULL_HANDLE;
    VkDevice device = VK_NULL_HANDLE;
    /// Those that graphs may use; the first has graphics and compute and is the main one.
    std::vector<ExternalQueue> queues;
    /// The chain given to vkCreateDevice, from VkPhysicalDeviceFeatures2 or any other struct on.
    const void* features = nullptr;
    std::vector<std::string> extensions = {}; ///< of the device, that were enabled
    bool debug_utils = false;                 ///< VK_EXT_debug_utils was enabled
    /// Held during each use of a queue, so that the embedder may use them from other threads. Null:
    /// the embedder does not, while this device submits.
    std::mutex* queue_mutex = nullptr;
};

/// For statistics and picture metadata.
struct DeviceInfo {
    std::string name;           ///< "llvmpipe (LLVM 15.0.6, 256 bits)"
    std::string driver;         ///< "llvmpipe"
    std::string driver_version; ///< "Mesa 22.3.6 (LLVM 15.0.6)"
    std::string api_version;    ///< "1.3.230"
    bool software = false;      ///< runs on the CPU
};

struct Limits {
    std::uint32_t image_extent = 0;      ///< largest width or height of a 2D image
    std::uint32_t attachment_extent = 0; ///< the same where raster passes draw into it
    std::uint32_t image_extent_3d = 0;
    std::uint32_t image_layers = 0;
    std::uint64_t allocation_bytes = 0;
    std::uint64_t buffer_bytes = 0;
    std::uint64_t storage_bytes = 0; ///< largest range bound as a storage buffer
    std::uint64_t uniform_bytes = 0;
    std::array<std::uint32_t, 3> groups{}; ///< workgroups per dispatch
    std::uint32_t push_descriptors = 0;    ///< 0: none
    std::uint64_t buffer_image_granularity = 1;
    double timestamp_period_ns = 1;
    float anisotropy = 1; ///< 1: none
};

class Device {
public:
    /// Throws Error(device) where there is no driver, no device that fits (with every device and
    /// what it lacks), or no validation layer although asked for.
    explicit Device(const DeviceOptions& options = {});
    /// On the caller's handles; `options` name no GPU and no validation. Throws Error(device) that
    /// lists required features that were not enabled, and queues that cannot serve.
    explicit Device(const ExternalDevice& external, const DeviceOptions& options = {});
    /// Waits for its own queues; everything made from this device must be gone by then. Of an
    /// external device, what was recorded must have been executed.
    ~Device();
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;

    const DeviceInfo& info() const { return info_; }
    const Limits& limits() const { return limits_; }
    Validation validation() const { return options_.validation; }
    /// Push descriptors exist and are not switched off.
    bool pushes_descriptors() const { return push_descriptor_set_ != nullptr; }
    /// Fragment shaders may write the stencil: VK_EXT_shader_stencil_export.
    bool exports_stencil() const { return stencil_export_; }
    ValidationLog& validation_log() { return *validation_log_; }
    /// What validation found so far.
    std::vector<std::string> validation_messages() const { return validation_log_->messages(); }

    Allocator& allocator() { return *allocator_; }
    Pipelines& pipelines() { return *pipelines_; }
    /// Shared, owned by the device. Linear is linear across mips too.
    VkSampler sampler(VkFilter filter, VkSamplerAddressMode address);
    /// Features of a format with optimal tiling.
    VkFormatFeatureFlags format_features(VkFormat format) const;

    /// Queue families by Vulkan's index, with the queues that this device has of each.
    std::span<const FamilyInfo> families() const { return families_; }
    QueueId main_queue() const { return {queue_family_, 0}; }
    /// Returns at once. Throws Error(device) naming `what`. Safe to call from several threads.
    void submit(const QueueSubmission& submission, std::string_view what);
    /// Submits to the main queue in order and waits until all are done.
    void submit(std::span<const VkCommandBuffer> commands, std::string_view what);
    /// Records with `record` into a fresh command buffer, submits it and waits.
    void run(const std::string& what, const std::function<void(VkCommandBuffer)>& record);

    VkInstance instance() const { return instance_; }
    VkPhysicalDevice physical() const { return physical_; }
    VkDevice handle() const { return device_; }
    /// For presenting; nothing else may be submitted meanwhile.
    VkQueue main_queue_handle() const { return queues_.at(main_queue()); }
    std::uint32_t queue_family() const { return queue_family_; } ///< of the main queue
    const DebugFunctions& debug() const { return debug_; }
    PFN_vkCmdPushDescriptorSetKHR push_descriptor_set() const { return push_descriptor_set_; }

private:
    void create(VkPhysicalDevice physical);
    void create_device(const Features& features, const std::vector<const char*>& extensions);
    void adopt(const ExternalDevice& external);
    void load_debug_functions();
    void open(bool pushes);
    void destroy();

    DeviceOptions options_;
    DeviceInfo info_;
    Limits limits_;
    std::unique_ptr<ValidationLog> validation_log_;
    DebugFunctions debug_;
    PFN_vkCmdPushDescriptorSetKHR push_descriptor_set_ = nullptr;
    bool stencil_export_ = false;
    VkInstance instance_ = VK_NULL_HANDLE;
    VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
    VkPhysicalDevice physical_ = VK_NULL_HANDLE;
    VkDevice device_ = VK_NULL_HANDLE;
    bool owned_ = true; ///< instance and device
    std::uint32_t queue_family_ = 0;
    std::vector<FamilyInfo> families_;
    std::map<QueueId, VkQueue> queues_;
    std::mutex own_queue_mutex_;
    std::mutex* queue_mutex_ = &own_queue_mutex_; ///< for all queues
    std::mutex sampler_mutex_;
    std::map<std::pair<VkFilter, VkSamplerAddressMode>, VkSampler> samplers_;
    std::unique_ptr<Allocator> allocator_;
    std::unique_ptr<Pipelines> pipelines_;
};

/// Every device with its score and the reasons for it or against it, one per line, for people.
std::string list_gpus();

} // namespace ockham::gpu
