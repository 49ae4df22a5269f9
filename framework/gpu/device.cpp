// SPDX-License-Identifier: Apache-2.0
#include "framework/gpu/device.hpp"

#include "framework/core/error.hpp"
#include "framework/core/log.hpp"
#include "framework/gpu/pipeline.hpp"
#include "framework/gpu/selection.hpp"
#include "framework/gpu/wait.hpp"

#include <algorithm>
#include <cstdlib>
#include <cstring>

namespace ockham::gpu {

namespace {

std::filesystem::path default_cache_dir() {
    if (const char* cache = std::getenv("XDG_CACHE_HOME"); cache && *cache == '/') {
        return std::filesystem::path(cache) / "ockham";
    }
    if (const char* home = std::getenv("HOME"); home && *home == '/') {
        return std::filesystem::path(home) / ".cache" / "ockham";
    }
    return {}; // nowhere to keep it
}

Limits read_limits(VkPhysicalDevice physical, bool push_descriptors) {
    VkPhysicalDevicePushDescriptorPropertiesKHR push{
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PUSH_DESCRIPTOR_PROPERTIES_KHR};
    VkPhysicalDeviceVulkan13Properties v13{
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_PROPERTIES,
        .pNext = push_descriptors ? &push : nullptr};
    VkPhysicalDeviceVulkan11Properties v11{
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_PROPERTIES, .pNext = &v13};
    VkPhysicalDeviceProperties2 properties{
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, .pNext = &v11};
    vkGetPhysicalDeviceProperties2(physical, &properties);
    const VkPhysicalDeviceLimits& l = properties.properties.limits;
    return {.image_extent = l.maxImageDimension2D,
        .attachment_extent = std::min({l.maxImageDimension2D, l.maxFramebufferWidth,
            l.maxFramebufferHeight, l.maxViewportDimensions[0], l.maxViewportDimensions[1]}),
        .image_extent_3d = l.maxImageDimension3D,
        .image_layers = l.maxImageArrayLayers,
        .allocation_bytes = v11.maxMemoryAllocationSize,
        .buffer_bytes = v13.maxBufferSize,
        .storage_bytes = l.maxStorageBufferRange,
        .uniform_bytes = l.maxUniformBufferRange,
        .groups = {l.maxComputeWorkGroupCount[0], l.maxComputeWorkGroupCount[1],
            l.maxComputeWorkGroupCount[2]},
        .push_descriptors = push_descriptors ? push.maxPushDescriptors : 0,
        .buffer_image_granularity = std::max<std::uint64_t>(l.bufferImageGranularity, 1),
        .timestamp_period_ns = static_cast<double>(l.timestampPeriod),
        .anisotropy = l.maxSamplerAnisotropy};
}

DeviceInfo read_info(VkPhysicalDevice physical) {
    VkPhysicalDeviceVulkan12Properties v12{
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_PROPERTIES};
    VkPhysicalDeviceProperties2 properties{
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, .pNext = &v12};
    vkGetPhysicalDeviceProperties2(physical, &properties);
    const VkPhysicalDeviceProperties& p = properties.properties;
    const auto version = [](std::uint32_t v) {
        return fmt::format(
            "{}.{}.{}", VK_API_VERSION_MAJOR(v), VK_API_VERSION_MINOR(v), VK_API_VERSION_PATCH(v));
    };
    return {.name = p.deviceName,
        .driver = v12.driverName,
        // The words are optional; the number is encoded as the driver likes, usually like this.
        .driver_version = *v12.driverInfo ? v12.driverInfo : version(p.driverVersion),
        .api_version = version(p.apiVersion),
        .software = p.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU};
}

template <class Function>
Function load(VkInstance instance, const char* name) {
    return reinterpret_cast<Function>(vkGetInstanceProcAddr(instance, name));
}

/// What keeps descriptors from being pushed, whatever the device can do.
bool forces_descriptor_sets(const DeviceOptions& options) {
    const char* force = std::getenv("OCKHAM_FORCE_DESCRIPTOR_SETS");
    // Instrumented shaders take pushed descriptors for uninitialised ones (layer 1.3.239).
    return options.force_descriptor_sets || options.validation == Validation::gpu ||
           (force && std::strcmp(force, "1") == 0);
}

/// What the device says it has; some software drivers do not enforce it themselves.
std::uint64_t device_memory_bytes(VkPhysicalDevice physical) {
    VkPhysicalDeviceMemoryProperties properties{};
    vkGetPhysicalDeviceMemoryProperties(physical, &properties);
    std::uint64_t bytes = 0;
    for (std::uint32_t i = 0; i < properties.memoryHeapCount; ++i) {
        const VkMemoryHeap& heap = properties.memoryHeaps[i];
        if (heap.flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT) bytes += heap.size;
    }
    return bytes;
}

} // namespace

std::string list_gpus() {
    ValidationLog log;
    const Instance instance = create_instance(Validation::off, {}, log);
    std::string text;
    try {
        text = describe(rate_all(instance.handle, {}));
    } catch (...) {
        vkDestroyInstance(instance.handle, nullptr);
        throw;
    }
    vkDestroyInstance(instance.handle, nullptr);
    return text.empty() ? "no Vulkan device; install a driver, for example the package "
                          "mesa-vulkan-drivers\n"
                        : text;
}

Device::Device(const DeviceOptions& options)
    : options_(options), validation_log_(std::make_unique<ValidationLog>()) {
    const Instance instance =
        create_instance(options.validation, options.instance_extensions, *validation_log_);
    instance_ = instance.handle;
    try {
        if (instance.debug_utils) load_debug_functions();
        if (instance.debug_utils && options.validation != Validation::off) {
            const auto create_messenger = load<PFN_vkCreateDebugUtilsMessengerEXT>(
                instance_, "vkCreateDebugUtilsMessengerEXT");
            const auto info = messenger_info(*validation_log_, options.validation);
            expect(create_messenger(instance_, &info, nullptr, &messenger_),
                "listening to validation messages");
        }
        create(select(rate_all(instance_, options.device_extensions), options.gpu).handle);
    } catch (...) {
        destroy();
        throw;
    }
}

Device::Device(const ExternalDevice& external, const DeviceOptions& options)
    : options_(options), validation_log_(std::make_unique<ValidationLog>()), owned_(false) {
    check(options.gpu.empty() && options.validation == Validation::off &&
              options.instance_extensions.empty() && options.device_extensions.empty(),
        "an external device was chosen, and validation and extensions switched on, by its owner");
    try {
        adopt(external);
    } catch (...) {
        destroy();
        throw;
    }
}

void Device::load_debug_functions() {
    debug_.set_name =
        load<PFN_vkSetDebugUtilsObjectNameEXT>(instance_, "vkSetDebugUtilsObjectNameEXT");
    debug_.begin_label =
        load<PFN_vkCmdBeginDebugUtilsLabelEXT>(instance_, "vkCmdBeginDebugUtilsLabelEXT");
    debug_.end_label =
        load<PFN_vkCmdEndDebugUtilsLabelEXT>(instance_, "vkCmdEndDebugUtilsLabelEXT");
}

void Device::create(VkPhysicalDevice physical) {
    physical_ = physical;
    info_ = read_info(physical);
    families_ = list_families(physical);
    queue_family_ = find_queue_family(families_).value();

    const bool pushes = !forces_descriptor_sets(options_) && has_push_descriptors(physical);

    Features wanted;
    choose_features(physical, wanted);
    stencil_export_ = has_stencil_export(physical);
    std::vector<const char*> extensions;
    if (pushes) extensions.push_back(VK_KHR_PUSH_DESCRIPTOR_EXTENSION_NAME);
    if (stencil_export_) extensions.push_back(VK_EXT_SHADER_STENCIL_EXPORT_EXTENSION_NAME);
    for (const std::string& name : options_.device_extensions) extensions.push_back(name.c_str());
    create_device(wanted, extensions);
    open(pushes);
    if (!wanted.v10.features.samplerAnisotropy) limits_.anisotropy = 1;
}

void Device::create_device(const Features& features, const std::vector<const char*>& extensions) {
    // Two of the main family, of which the second may compute beside the first, and one of each
    // other family that can compute or copy.
    constexpr float kPriorities[] = {1, 1};
    std::vector<VkDeviceQueueCreateInfo> queues;
    for (std::uint32_t i = 0; i < families_.size(); ++i) {
        FamilyInfo& family = families_[i];
        const std::uint32_t wanted = i == queue_family_ ? 2 : family.transfer ? 1 : 0;
        family.queues = std::min(wanted, family.queues);
        if (family.queues == 0) continue;
        queues.push_back({.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
            .queueFamilyIndex = i,
            .queueCount = family.queues,
            .pQueuePriorities = kPriorities});
    }
    const VkDeviceCreateInfo info{.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
        .pNext = &features.v10,
        .queueCreateInfoCount = static_cast<std::uint32_t>(queues.size()),
        .pQueueCreateInfos = queues.data(),
        .enabledExtensionCount = static_cast<std::uint32_t>(extensions.size()),
        .ppEnabledExtensionNames = extensions.data()};
    expect(vkCreateDevice(physical_, &info, nullptr, &device_),
        fmt::format("creating a device on '{}'", info_.name));
    for (const VkDeviceQueueCreateInfo& family : queues) {
        for (std::uint32_t i = 0; i < family.queueCount; ++i) {
            VkQueue& queue = queues_[{family.queueFamilyIndex, i}];
            vkGetDeviceQueue(device_, family.queueFamilyIndex, i, &queue);
        }
    }
}

void Device::adopt(const ExternalDevice& external) {
    instance_ = external.instance;
    physical_ = external.physical;
    info_ = read_info(physical_);
    Features enabled;
    read_features(external.features, enabled);
    const std::vector<std::string> missing = missing_features(enabled);
    if (!missing.empty()) {
        fail_device("the device on '{}' that was handed over lacks features: {}; enable them in "
                    "vkCreateDevice and name the chain in ExternalDevice::features",
            info_.name, fmt::join(missing, ", "));
    }
    families_ = list_families(physical_);
    for (FamilyInfo& family : families_) family.queues = 0;
    for (const ExternalQueue& queue : external.queues) {
        check(queue.family < families_.size(), "an external queue is of no family of its device");
        queues_[{queue.family, families_[queue.family].queues++}] = queue.handle;
    }
    const FamilyInfo main =
        external.queues.empty() ? FamilyInfo{} : families_[external.queues.front().family];
    if (!main.graphics || !main.compute) {
        fail_device("the first queue of the device on '{}' that was handed over must have graphics "
                    "and compute",
            info_.name);
    }
    queue_family_ = external.queues.front().family;
    if (external.queue_mutex) queue_mutex_ = external.queue_mutex;
    device_ = external.device;
    if (external.debug_utils) load_debug_functions();
    const auto enables = [&](const char* extension) {
        return std::ranges::find(external.extensions, extension) != external.extensions.end();
    };
    stencil_export_ = enables(VK_EXT_SHADER_STENCIL_EXPORT_EXTENSION_NAME);
    const bool pushes =
        !forces_descriptor_sets(options_) && enables(VK_KHR_PUSH_DESCRIPTOR_EXTENSION_NAME);
    open(pushes);
    if (!enabled.v10.features.samplerAnisotropy) limits_.anisotropy = 1;
}

/// What follows once there are a device and its queues.
void Device::open(bool pushes) {
    limits_ = read_limits(physical_, pushes);
    if (pushes) {
        push_descriptor_set_ = reinterpret_cast<PFN_vkCmdPushDescriptorSetKHR>(
            vkGetDeviceProcAddr(device_, "vkCmdPushDescriptorSetKHR"));
    }
    const std::uint64_t budget = options_.memory_budget_bytes ? options_.memory_budget_bytes
                                                              : device_memory_bytes(physical_);
    allocator_ = std::make_unique<Allocator>(physical_, device_, budget, options_.memory_hook);
    pipelines_ = std::make_unique<Pipelines>(
        *this, options_.cache_dir.empty() ? default_cache_dir() : options_.cache_dir);
    log::debug("device: {}, {}", info_.name, info_.driver_version);
}

Device::~Device() { destroy(); }

void Device::destroy() {
    if (device_) {
        if (owned_) wait_out([&] { return vkDeviceWaitIdle(device_); });
        pipelines_.reset();
        for (const auto& [key, sampler] : samplers_) vkDestroySampler(device_, sampler, nullptr);
        allocator_.reset();
    }
    if (!owned_) return;
    if (device_) vkDestroyDevice(device_, nullptr);
    if (messenger_) {
        load<PFN_vkDestroyDebugUtilsMessengerEXT>(instance_, "vkDestroyDebugUtilsMessengerEXT")(
            instance_, messenger_, nullptr);
    }
    vkDestroyInstance(instance_, nullptr);
}

VkSampler Device::sampler(VkFilter filter, VkSamplerAddressMode address) {
    const std::lock_guard lock(sampler_mutex_);
    VkSampler& sampler = samplers_[{filter, address}];
    if (sampler) return sampler;
    const VkSamplerCreateInfo info{.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO,
        .magFilter = filter,
        .minFilter = filter,
        .mipmapMode = filter == VK_FILTER_LINEAR ? VK_SAMPLER_MIPMAP_MODE_LINEAR
                                                 : VK_SAMPLER_MIPMAP_MODE_NEAREST,
        .addressModeU = address,
        .addressModeV = address,
        .addressModeW = address,
        .maxLod = VK_LOD_CLAMP_NONE};
    expect(vkCreateSampler(device_, &info, nullptr, &sampler), "creating a sampler");
    return sampler;
}

VkFormatFeatureFlags Device::format_features(VkFormat format) const {
    VkFormatProperties properties;
    vkGetPhysicalDeviceFormatProperties(physical_, format, &properties);
    return properties.optimalTilingFeatures;
}

void Device::submit(const QueueSubmission& submission, std::string_view what) {
    const VkQueue queue = queues_.at(submission.queue);
    const auto count = static_cast<std::uint32_t>(submission.commands.size());
    VkResult result = VK_SUCCESS;
    if (submission.waits.empty() && submission.signals.empty()) {
        // The older call: the layer's checks across command buffers see nothing else.
        const VkSubmitInfo info{.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
            .commandBufferCount = count,
            .pCommandBuffers = submission.commands.data()};
        const std::lock_guard lock(*queue_mutex_);
        result = vkQueueSubmit(queue, 1, &info, submission.fence);
    } else {
        const auto convert = [](std::span<const TimelinePoint> points) {
            std::vector<VkSemaphoreSubmitInfo> infos;
            for (const TimelinePoint& point : points) {
                infos.push_back({.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO,
                    .semaphore = point.semaphore,
                    .value = point.value,
                    .stageMask = point.stages});
            }
            return infos;
        };
        const std::vector<VkSemaphoreSubmitInfo> waits = convert(submission.waits);
        const std::vector<VkSemaphoreSubmitInfo> signals = convert(submission.signals);
        std::vector<VkCommandBufferSubmitInfo> commands;
        for (const VkCommandBuffer buffer : submission.commands) {
            commands.push_back(
                {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO, .commandBuffer = buffer});
        }
        const VkSubmitInfo2 info{.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2,
            .waitSemaphoreInfoCount = static_cast<std::uint32_t>(waits.size()),
            .pWaitSemaphoreInfos = waits.data(),
            .commandBufferInfoCount = count,
            .pCommandBufferInfos = commands.data(),
            .signalSemaphoreInfoCount = static_cast<std::uint32_t>(signals.size()),
            .pSignalSemaphoreInfos = signals.data()};
        const std::lock_guard lock(*queue_mutex_);
        result = vkQueueSubmit2(queue, 1, &info, submission.fence);
    }
    expect(result, fmt::format("submitting '{}' to '{}'", what, info_.name));
}

void Device::submit(std::span<const VkCommandBuffer> commands, std::string_view what) {
    const VkFenceCreateInfo fence_info{.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    VkFence fence = VK_NULL_HANDLE;
    expect(vkCreateFence(device_, &fence_info, nullptr, &fence), "creating a fence");
    VkResult result = VK_SUCCESS;
    try {
        submit({.queue = main_queue(), .commands = commands, .fence = fence}, what);
        result = wait_out([&] { return vkWaitForFences(device_, 1, &fence, VK_TRUE, UINT64_MAX); });
    } catch (...) {
        vkDestroyFence(device_, fence, nullptr);
        throw;
    }
    vkDestroyFence(device_, fence, nullptr);
    expect(result, fmt::format("executing '{}' on '{}'", what, info_.name));
}

void Device::run(const std::string& what, const std::function<void(VkCommandBuffer)>& record) {
    const VkCommandPoolCreateInfo pool_info{.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
        .flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT,
        .queueFamilyIndex = queue_family_};
    VkCommandPool pool = VK_NULL_HANDLE;
    expect(vkCreateCommandPool(device_, &pool_info, nullptr, &pool), "creating a command pool");
    try {
        const VkCommandBufferAllocateInfo info{
            .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
            .commandPool = pool,
            .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
            .commandBufferCount = 1};
        VkCommandBuffer commands = VK_NULL_HANDLE;
        expect(vkAllocateCommandBuffers(device_, &info, &commands), "allocating a command buffer");
        set_name(*this, VK_OBJECT_TYPE_COMMAND_BUFFER, commands, what);
        const VkCommandBufferBeginInfo begin{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
            .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
        expect(vkBeginCommandBuffer(commands, &begin), what);
        record(commands);
        expect(vkEndCommandBuffer(commands), what);
        submit({&commands, 1}, what);
    } catch (...) {
        vkDestroyCommandPool(device_, pool, nullptr);
        throw;
    }
    vkDestroyCommandPool(device_, pool, nullptr);
}

} // namespace ockham::gpu
