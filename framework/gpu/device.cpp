// SPDX-License-Identifier: Apache-2.0
#include "framework/gpu/device.hpp"

#include "framework/core/error.hpp"
#include "framework/core/log.hpp"
#include "framework/gpu/memory.hpp"
#include "framework/gpu/pipeline.hpp"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <cstring>
#include <optional>

namespace ockham::gpu {

namespace {

constexpr const char* kValidationLayer = "VK_LAYER_KHRONOS_validation";

template <class T, class Function, class... Args>
std::vector<T> enumerate(const char* what, Function function, Args... args) {
    std::uint32_t count = 0;
    expect(function(args..., &count, nullptr), what);
    std::vector<T> items(count);
    expect(function(args..., &count, items.data()), what);
    items.resize(count);
    return items;
}

bool has_extension(const std::vector<VkExtensionProperties>& extensions, const char* name) {
    return std::ranges::any_of(
        extensions, [&](const auto& e) { return std::strcmp(e.extensionName, name) == 0; });
}

/// The layer reads from the environment what has no place in the API of 1.3.239: without the second
/// switch, hazards between command buffers pass unseen.
void enable_queue_submit_checks() {
    constexpr const char* kVariable = "VK_LAYER_ENABLES";
    constexpr const char* kSwitches = "VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT:"
                                      "VALIDATION_CHECK_ENABLE_SYNCHRONIZATION_VALIDATION_QUEUE_"
                                      "SUBMIT";
    const char* present = std::getenv(kVariable);
    if (present && std::strstr(present, kSwitches)) return;
    const std::string value =
        present && *present ? fmt::format("{}:{}", present, kSwitches) : kSwitches;
    setenv(kVariable, value.c_str(), 1);
}

struct Instance {
    VkInstance handle = VK_NULL_HANDLE;
    bool debug_utils = false;
};

Instance create_instance(Validation validation, ValidationLog& log) {
    std::uint32_t version = VK_API_VERSION_1_0;
    vkEnumerateInstanceVersion(&version);
    if (version < VK_API_VERSION_1_3) {
        fail_device("the Vulkan loader is {}.{}, but 1.3 is needed; update the package libvulkan1",
            VK_API_VERSION_MAJOR(version), VK_API_VERSION_MINOR(version));
    }
    Instance instance;
    std::vector<const char*> layers;
    std::vector<const char*> extensions;
    auto available = enumerate<VkExtensionProperties>("listing Vulkan's instance extensions",
        vkEnumerateInstanceExtensionProperties, static_cast<const char*>(nullptr));
    if (validation != Validation::off) {
        const auto present = enumerate<VkLayerProperties>(
            "listing Vulkan's layers", vkEnumerateInstanceLayerProperties);
        if (std::ranges::none_of(present,
                [](const auto& l) { return std::strcmp(l.layerName, kValidationLayer) == 0; })) {
            fail_device("--validation {} needs the layer {}, which is not installed; install the "
                        "package vulkan-validationlayers",
                name_of(validation), kValidationLayer);
        }
        layers.push_back(kValidationLayer);
        extensions.push_back(VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME);
        const auto more =
            enumerate<VkExtensionProperties>("listing the validation layer's extensions",
                vkEnumerateInstanceExtensionProperties, kValidationLayer);
        available.insert(available.end(), more.begin(), more.end());
    }
    instance.debug_utils = has_extension(available, VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
    if (instance.debug_utils) extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);

    std::vector<VkValidationFeatureEnableEXT> enables;
    if (validation == Validation::sync) {
        enables.push_back(VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT);
        enable_queue_submit_checks();
    } else if (validation == Validation::gpu) {
        enables.push_back(VK_VALIDATION_FEATURE_ENABLE_GPU_ASSISTED_EXT);
        enables.push_back(VK_VALIDATION_FEATURE_ENABLE_GPU_ASSISTED_RESERVE_BINDING_SLOT_EXT);
    }
    VkDebugUtilsMessengerCreateInfoEXT messenger = messenger_info(log, validation);
    const VkValidationFeaturesEXT features{.sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT,
        .pNext = instance.debug_utils ? &messenger : nullptr,
        .enabledValidationFeatureCount = static_cast<std::uint32_t>(enables.size()),
        .pEnabledValidationFeatures = enables.data()};
    const VkApplicationInfo application{.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
        .pApplicationName = "Ockham",
        .pEngineName = "Ockham",
        .apiVersion = VK_API_VERSION_1_3};
    const VkInstanceCreateInfo info{.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
        .pNext = validation != Validation::off ? &features : nullptr,
        .pApplicationInfo = &application,
        .enabledLayerCount = static_cast<std::uint32_t>(layers.size()),
        .ppEnabledLayerNames = layers.data(),
        .enabledExtensionCount = static_cast<std::uint32_t>(extensions.size()),
        .ppEnabledExtensionNames = extensions.data()};
    expect(vkCreateInstance(&info, nullptr, &instance.handle), "creating a Vulkan instance");
    return instance;
}

/// The features that the project asks about, chained for vkGetPhysicalDeviceFeatures2 and, reduced
/// to what is wanted, for vkCreateDevice.
struct Features {
    Features() {
        v10.pNext = &v12;
        v12.pNext = &v13;
    }
    Features(const Features&) = delete;
    Features& operator=(const Features&) = delete;

    VkPhysicalDeviceFeatures2 v10{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2};
    VkPhysicalDeviceVulkan12Features v12{
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES};
    VkPhysicalDeviceVulkan13Features v13{
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES};
};

/// One feature: where it is, whether the device must have it, and what it adds to the score.
template <class Struct>
struct Feature {
    const char* name;
    VkBool32 Struct::*member;
    bool required;
};

constexpr Feature<VkPhysicalDeviceFeatures> kFeatures10[] = {
    {"shaderStorageImageExtendedFormats",
        &VkPhysicalDeviceFeatures::shaderStorageImageExtendedFormats, true},
    {"shaderStorageImageWriteWithoutFormat",
        &VkPhysicalDeviceFeatures::shaderStorageImageWriteWithoutFormat, false},
    {"samplerAnisotropy", &VkPhysicalDeviceFeatures::samplerAnisotropy, false},
    {"fragmentStoresAndAtomics", &VkPhysicalDeviceFeatures::fragmentStoresAndAtomics, false},
    {"vertexPipelineStoresAndAtomics", &VkPhysicalDeviceFeatures::vertexPipelineStoresAndAtomics,
        false},
    {"geometryShader", &VkPhysicalDeviceFeatures::geometryShader, false}, // gl_PrimitiveID
    {"shaderClipDistance", &VkPhysicalDeviceFeatures::shaderClipDistance, false},
    {"shaderInt64", &VkPhysicalDeviceFeatures::shaderInt64, false},
};
constexpr Feature<VkPhysicalDeviceVulkan12Features> kFeatures12[] = {
    {"scalarBlockLayout", &VkPhysicalDeviceVulkan12Features::scalarBlockLayout, true},
};
constexpr Feature<VkPhysicalDeviceVulkan13Features> kFeatures13[] = {
    {"synchronization2", &VkPhysicalDeviceVulkan13Features::synchronization2, true},
    {"maintenance4", &VkPhysicalDeviceVulkan13Features::maintenance4, true},
    {"shaderTerminateInvocation", &VkPhysicalDeviceVulkan13Features::shaderTerminateInvocation,
        false},
    {"shaderDemoteToHelperInvocation",
        &VkPhysicalDeviceVulkan13Features::shaderDemoteToHelperInvocation, false},
};

/// Calls visit(feature, struct of `features` that holds it) for each row above.
template <class Visit>
void for_each_feature(Features& features, Visit visit) {
    for (const auto& feature : kFeatures10) visit(feature, features.v10.features);
    for (const auto& feature : kFeatures12) visit(feature, features.v12);
    for (const auto& feature : kFeatures13) visit(feature, features.v13);
}

struct Candidate {
    VkPhysicalDevice handle = VK_NULL_HANDLE;
    std::string name;
    int score = 0;
    std::vector<std::string> merits;   ///< each with its part of the score
    std::vector<std::string> refusals; ///< empty: usable
};

/// The first family with graphics and compute, whose timestamps count.
std::optional<std::uint32_t> find_queue_family(VkPhysicalDevice physical) {
    std::uint32_t count = 0;
    vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, nullptr);
    std::vector<VkQueueFamilyProperties> families(count);
    vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, families.data());
    constexpr VkQueueFlags kNeeded = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
    for (std::uint32_t i = 0; i < count; ++i) {
        const bool fits = (families[i].queueFlags & kNeeded) == kNeeded;
        if (fits && families[i].timestampValidBits > 0) return i;
    }
    return std::nullopt;
}

std::pair<int, const char*> score_of_type(VkPhysicalDeviceType type) {
    switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
        return {1000, "discrete GPU"};
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
        return {500, "integrated GPU"};
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
        return {300, "virtual GPU"};
    case VK_PHYSICAL_DEVICE_TYPE_CPU:
        return {100, "CPU"};
    default:
        return {50, "other"};
    }
}

std::vector<VkExtensionProperties> extensions_of(VkPhysicalDevice physical) {
    return enumerate<VkExtensionProperties>("listing a device's extensions",
        vkEnumerateDeviceExtensionProperties, physical, static_cast<const char*>(nullptr));
}

Candidate rate(VkPhysicalDevice physical) {
    Candidate candidate{.handle = physical};
    VkPhysicalDeviceProperties properties;
    vkGetPhysicalDeviceProperties(physical, &properties);
    candidate.name = properties.deviceName;
    const auto merit = [&](int points, std::string_view what) {
        candidate.score += points;
        candidate.merits.push_back(fmt::format("{} +{}", what, points));
    };
    const auto [points, type] = score_of_type(properties.deviceType);
    merit(points, type);
    if (properties.apiVersion < VK_API_VERSION_1_3) {
        candidate.refusals.push_back(
            fmt::format("Vulkan {}.{}, needs 1.3", VK_API_VERSION_MAJOR(properties.apiVersion),
                VK_API_VERSION_MINOR(properties.apiVersion)));
        return candidate; // the newer structs must not be asked for
    }
    if (!find_queue_family(physical)) {
        candidate.refusals.push_back("no queue with graphics, compute and timestamps");
    }
    Features features;
    vkGetPhysicalDeviceFeatures2(physical, &features.v10);
    for_each_feature(features, [&](const auto& feature, auto& values) {
        const bool present = values.*feature.member;
        if (!present && feature.required) {
            candidate.refusals.push_back(fmt::format("no {}", feature.name));
        }
        if (present && !feature.required) merit(1, feature.name);
    });
    if (has_extension(extensions_of(physical), VK_KHR_PUSH_DESCRIPTOR_EXTENSION_NAME)) {
        merit(5, "push descriptors");
    }
    return candidate;
}

std::vector<Candidate> rate_all(VkInstance instance) {
    std::vector<Candidate> candidates;
    for (const VkPhysicalDevice physical : enumerate<VkPhysicalDevice>(
             "listing Vulkan devices", vkEnumeratePhysicalDevices, instance)) {
        candidates.push_back(rate(physical));
    }
    return candidates;
}

std::string describe(const std::vector<Candidate>& candidates) {
    std::string text;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
        const Candidate& c = candidates[i];
        text += c.refusals.empty()
                    ? fmt::format(
                          "[{}] {}: score {} ({})\n", i, c.name, c.score, fmt::join(c.merits, ", "))
                    : fmt::format("[{}] {}: refused: {}\n", i, c.name, fmt::join(c.refusals, "; "));
    }
    return text;
}

std::string lower(std::string text) {
    for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return text;
}

const Candidate& select(const std::vector<Candidate>& candidates, const std::string& wish) {
    if (candidates.empty()) {
        fail_device("no Vulkan device found; install a driver, for example the package "
                    "mesa-vulkan-drivers");
    }
    const bool is_index = !wish.empty() && std::ranges::all_of(wish, [](char c) {
        return std::isdigit(static_cast<unsigned char>(c));
    }) && wish.size() < 6;
    const auto matches = [&](std::size_t index) {
        if (wish.empty()) return true;
        if (is_index) return index == static_cast<std::size_t>(std::stoi(wish));
        return lower(candidates[index].name).find(lower(wish)) != std::string::npos;
    };
    const Candidate* best = nullptr;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
        const Candidate& c = candidates[i];
        if (matches(i) && c.refusals.empty() && (!best || c.score > best->score)) best = &c;
    }
    if (!best) {
        fail_device("{}; the devices are:\n{}",
            wish.empty() ? "no Vulkan device can be used"
                         : fmt::format("no usable Vulkan device matches --gpu '{}'", wish),
            describe(candidates));
    }
    return *best;
}

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
    return {.name = p.deviceName,
        .driver = v12.driverName,
        .driver_version = v12.driverInfo,
        .api_version = fmt::format("{}.{}.{}", VK_API_VERSION_MAJOR(p.apiVersion),
            VK_API_VERSION_MINOR(p.apiVersion), VK_API_VERSION_PATCH(p.apiVersion)),
        .software = p.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU};
}

template <class Function>
Function load(VkInstance instance, const char* name) {
    return reinterpret_cast<Function>(vkGetInstanceProcAddr(instance, name));
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
    const bool pushes =
        !forced && has_extension(extensions_of(physical), VK_KHR_PUSH_DESCRIPTOR_EXTENSION_NAME);
    limits_ = read_limits(physical, queue_family_, pushes);

    Features present, wanted;
    vkGetPhysicalDeviceFeatures2(physical, &present.v10);
    for_each_feature(wanted, [&](const auto& feature, auto& values) {
        using Struct = std::remove_cvref_t<decltype(values)>;
        if constexpr (std::is_same_v<Struct, VkPhysicalDeviceFeatures>) {
            values.*feature.member = present.v10.features.*feature.member;
        } else if constexpr (std::is_same_v<Struct, VkPhysicalDeviceVulkan12Features>) {
            values.*feature.member = present.v12.*feature.member;
        } else {
            values.*feature.member = present.v13.*feature.member;
        }
    });
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
    allocator_ = std::make_unique<Allocator>(physical, device_, options_.memory_budget_bytes);
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
