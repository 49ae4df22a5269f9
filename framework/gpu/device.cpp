// SPDX-License-Identifier: Apache-2.0
#include "framework/gpu/device.hpp"

#include "framework/core/error.hpp"
#include "framework/core/log.hpp"
#include "framework/gpu/memory.hpp"
#include "framework/gpu/pipeline.hpp"
#include "framework/gpu/selection.hpp"

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

Limits read_limits(VkPhysicalDevice physical, std::uint32_t queue_family, bool push_descriptors) {
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
    std::uint32_t count = 0;
    vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, nullptr);
    std::vector<VkQueueFamilyProperties> families(count);
    vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, families.data());
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
        .timestamp_bits = families[queue_family].timestampValidBits,
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
    const Instance instance = create_instance(Validation::off, log);
    std::string text;
    try {
        text = describe(rate_all(instance.handle));
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
    const Instance instance = create_instance(options.validation, *validation_log_);
    instance_ = instance.handle;
    try {
        if (instance.debug_utils) {
            debug_.set_name =
                load<PFN_vkSetDebugUtilsObjectNameEXT>(instance_, "vkSetDebugUtilsObjectNameEXT");
            debug_.begin_label =
                load<PFN_vkCmdBeginDebugUtilsLabelEXT>(instance_, "vkCmdBeginDebugUtilsLabelEXT");
            debug_.end_label =
                load<PFN_vkCmdEndDebugUtilsLabelEXT>(instance_, "vkCmdEndDebugUtilsLabelEXT");
        }
        if (instance.debug_utils && options.validation != Validation::off) {
            const auto create_messenger = load<PFN_vkCreateDebugUtilsMessengerEXT>(
                instance_, "vkCreateDebugUtilsMessengerEXT");
            const auto info = messenger_info(*validation_log_, options.validation);
            expect(create_messenger(instance_, &info, nullptr, &messenger_),
                "listening to validation messages");
        }
        create(select(rate_all(instance_), options.gpu).handle);
    } catch (...) {
        destroy();
        throw;
    }
}

void Device::create(VkPhysicalDevice physical) {
    physical_ = physical;
    queue_family_ = find_queue_family(physical).value();
    info_ = read_info(physical);

    const char* force = std::getenv("OCKHAM_FORCE_DESCRIPTOR_SETS");
    // Instrumented shaders take pushed descriptors for uninitialised ones (layer 1.3.239).
    const bool forced = options_.force_descriptor_sets || options_.validation == Validation::gpu ||
                        (force && std::strcmp(force, "1") == 0);
    const bool pushes = !forced && has_push_descriptors(physical);
    limits_ = read_limits(physical, queue_family_, pushes);

    Features wanted;
    choose_features(physical, wanted);
    if (!wanted.v10.features.samplerAnisotropy) limits_.anisotropy = 1;

    const float priority = 1;
    const VkDeviceQueueCreateInfo queue{.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
        .queueFamilyIndex = queue_family_,
        .queueCount = 1,
        .pQueuePriorities = &priority};
    const char* extension = VK_KHR_PUSH_DESCRIPTOR_EXTENSION_NAME;
    const VkDeviceCreateInfo info{.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
        .pNext = &wanted.v10,
        .queueCreateInfoCount = 1,
        .pQueueCreateInfos = &queue,
        .enabledExtensionCount = pushes ? 1u : 0u,
        .ppEnabledExtensionNames = &extension};
    expect(vkCreateDevice(physical, &info, nullptr, &device_),
        fmt::format("creating a device on '{}'", info_.name));
    vkGetDeviceQueue(device_, queue_family_, 0, &queue_);
    if (pushes) {
        push_descriptor_set_ = reinterpret_cast<PFN_vkCmdPushDescriptorSetKHR>(
            vkGetDeviceProcAddr(device_, "vkCmdPushDescriptorSetKHR"));
    }
    const std::uint64_t budget =
        options_.memory_budget_bytes ? options_.memory_budget_bytes : device_memory_bytes(physical);
    allocator_ = std::make_unique<Allocator>(physical, device_, budget);
    pipelines_ = std::make_unique<Pipelines>(
        *this, options_.cache_dir.empty() ? default_cache_dir() : options_.cache_dir);
    log::debug("device: {}, {}", info_.name, info_.driver_version);
}

Device::~Device() { destroy(); }

void Device::destroy() {
    if (device_) {
        vkDeviceWaitIdle(device_);
        pipelines_.reset();
        for (const auto& [key, sampler] : samplers_) vkDestroySampler(device_, sampler, nullptr);
        allocator_.reset();
        vkDestroyDevice(device_, nullptr);
    }
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

void Device::submit(std::span<const VkCommandBuffer> commands, std::string_view what) {
    const VkFenceCreateInfo fence_info{.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    VkFence fence = VK_NULL_HANDLE;
    expect(vkCreateFence(device_, &fence_info, nullptr, &fence), "creating a fence");
    // The older call: the layer's checks across command buffers are surest there.
    const VkSubmitInfo info{.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
        .commandBufferCount = static_cast<std::uint32_t>(commands.size()),
        .pCommandBuffers = commands.data()};
    VkResult result = VK_SUCCESS;
    {
        const std::lock_guard lock(queue_mutex_);
        result = vkQueueSubmit(queue_, 1, &info, fence);
    }
    if (result == VK_SUCCESS) result = vkWaitForFences(device_, 1, &fence, VK_TRUE, UINT64_MAX);
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
