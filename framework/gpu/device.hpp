// SPDX-License-Identifier: Apache-2.0
// One logical Vulkan device with one queue, headless: no surface, no window. Chooses the physical
// device by score and says why each of the others was refused. Owns what all graphs on it share:
// memory, pipelines, samplers. Programs create one; Executor and uploads take a reference.
#pragma once

#include "framework/gpu/debug.hpp"

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

class Allocator;
class Pipelines;

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
    std::uint32_t timestamp_bits = 0;
    float anisotropy = 1; ///< 1: none
};

class Device {
public:
    /// Throws Error(device) where there is no driver, no device that fits (with every device and
    /// what it lacks), or no validation layer although asked for.
    explicit Device(const DeviceOptions& options = {});
    /// Waits for the queue; everything made from this device must be gone by then.
    ~Device();
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;

    const DeviceInfo& info() const { return info_; }
    const Limits& limits() const { return limits_; }
    Validation validation() const { return options_.validation; }
    /// Push descriptors exist and are not switched off.
    bool pushes_descriptors() const { return push_descriptor_set_ != nullptr; }
    ValidationLog& validation_log() { return *validation_log_; }
    /// What validation found so far.
    std::vector<std::string> validation_messages() const { return validation_log_->messages(); }

    Allocator& allocator() { return *allocator_; }
    Pipelines& pipelines() { return *pipelines_; }
    /// Shared, owned by the device. Linear is linear across mips too.
    VkSampler sampler(VkFilter filter, VkSamplerAddressMode address);
    /// Features of a format with optimal tiling.
    VkFormatFeatureFlags format_features(VkFormat format) const;

    /// Submits in order and waits until all are done. Throws Error(device) naming `what`.
    void submit(std::span<const VkCommandBuffer> commands, std::string_view what);
    /// Records with `record` into a fresh command buffer, submits it and waits.
    void run(const std::string& what, const std::function<void(VkCommandBuffer)>& record);

    VkPhysicalDevice physical() const { return physical_; }
    VkDevice handle() const { return device_; }
    std::uint32_t queue_family() const { return queue_family_; }
    const DebugFunctions& debug() const { return debug_; }
    PFN_vkCmdPushDescriptorSetKHR push_descriptor_set() const { return push_descriptor_set_; }

private:
    void create(VkPhysicalDevice physical);
    void destroy();

    DeviceOptions options_;
    DeviceInfo info_;
    Limits limits_;
    std::unique_ptr<ValidationLog> validation_log_;
    DebugFunctions debug_;
    PFN_vkCmdPushDescriptorSetKHR push_descriptor_set_ = nullptr;
    VkInstance instance_ = VK_NULL_HANDLE;
    VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
    VkPhysicalDevice physical_ = VK_NULL_HANDLE;
    VkDevice device_ = VK_NULL_HANDLE;
    VkQueue queue_ = VK_NULL_HANDLE;
    std::uint32_t queue_family_ = 0;
    std::mutex queue_mutex_;
    std::mutex sampler_mutex_;
    std::map<std::pair<VkFilter, VkSamplerAddressMode>, VkSampler> samplers_;
    std::unique_ptr<Allocator> allocator_;
    std::unique_ptr<Pipelines> pipelines_;
};

/// Every device with its score and the reasons for it or against it, one per line, for people.
std::string list_gpus();

} // namespace ockham::gpu
