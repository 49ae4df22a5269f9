// SPDX-License-Identifier: Apache-2.0
#include "framework/gpu/selection.hpp"

#include "framework/core/error.hpp"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <cstring>

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

/// The layer reads from the environment, while an instance is created, what has no place in the API
/// of 1.3.239: without the second switch, hazards between command buffers pass unseen. What was
/// there before comes back, so that later instances are not concerned.
class QueueSubmitChecks {
public:
    QueueSubmitChecks() {
        constexpr const char* kSwitches =
            "VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT:"
            "VALIDATION_CHECK_ENABLE_SYNCHRONIZATION_VALIDATION_QUEUE_SUBMIT";
        if (const char* present = std::getenv(kVariable)) before_ = present;
        const std::string value =
            before_ && !before_->empty() ? fmt::format("{}:{}", *before_, kSwitches) : kSwitches;
        setenv(kVariable, value.c_str(), 1);
    }
    ~QueueSubmitChecks() {
        if (before_) {
            setenv(kVariable, before_->c_str(), 1);
        } else {
            unsetenv(kVariable);
        }
    }
    QueueSubmitChecks(const QueueSubmitChecks&) = delete;
    QueueSubmitChecks& operator=(const QueueSubmitChecks&) = delete;

private:
    static constexpr const char* kVariable = "VK_LAYER_ENABLES";
    std::optional<std::string> before_;
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
    {"timelineSemaphore", &VkPhysicalDeviceVulkan12Features::timelineSemaphore, true},
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

Candidate rate(VkPhysicalDevice physical, const std::vector<std::string>& extensions) {
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
    if (!find_queue_family(list_families(physical))) {
        candidate.refusals.push_back("no queue with graphics, compute and timestamps");
    }
    const std::vector<VkExtensionProperties> available = extensions_of(physical);
    for (const std::string& name : extensions) {
        if (!has_extension(available, name.c_str()))
            candidate.refusals.push_back(fmt::format("no {}", name));
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
    if (has_push_descriptors(physical)) {
        merit(5, "push descriptors");
    }
    return candidate;
}

std::string lower(std::string text) {
    for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return text;
}

} // namespace

Instance create_instance(
    Validation validation, const std::vector<std::string>& more, ValidationLog& log) {
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
        const auto of_layer =
            enumerate<VkExtensionProperties>("listing the validation layer's extensions",
                vkEnumerateInstanceExtensionProperties, kValidationLayer);
        available.insert(available.end(), of_layer.begin(), of_layer.end());
    }
    instance.debug_utils = has_extension(available, VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
    if (instance.debug_utils) extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);

    for (const std::string& name : more) {
        if (!has_extension(available, name.c_str()))
            fail_device("Vulkan here has no {}; update the driver", name);
        extensions.push_back(name.c_str());
    }

    std::optional<QueueSubmitChecks> checks;
    std::vector<VkValidationFeatureEnableEXT> enables;
    if (validation == Validation::sync) {
        enables.push_back(VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT);
        checks.emplace();
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

void choose_features(VkPhysicalDevice physical, Features& features) {
    Features present;
    vkGetPhysicalDeviceFeatures2(physical, &present.v10);
    for_each_feature(features, [&](const auto& feature, auto& values) {
        values.*feature.member = present.of(values).*feature.member;
    });
}

void read_features(const void* chain, Features& features) {
    const auto copy = [&](const auto& from, auto& to) {
        auto* const next = to.pNext; // of ours
        to = from;
        to.pNext = next;
    };
    for (auto* next = static_cast<const VkBaseInStructure*>(chain); next; next = next->pNext) {
        const void* const item = next;
        switch (next->sType) {
        case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2:
            copy(*static_cast<const VkPhysicalDeviceFeatures2*>(item), features.v10);
            break;
        case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES:
            copy(*static_cast<const VkPhysicalDeviceVulkan12Features*>(item), features.v12);
            break;
        case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES:
            copy(*static_cast<const VkPhysicalDeviceVulkan13Features*>(item), features.v13);
            break;
        case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SCALAR_BLOCK_LAYOUT_FEATURES:
            features.v12.scalarBlockLayout =
                static_cast<const VkPhysicalDeviceScalarBlockLayoutFeatures*>(item)
                    ->scalarBlockLayout;
            break;
        case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_TIMELINE_SEMAPHORE_FEATURES:
            features.v12.timelineSemaphore =
                static_cast<const VkPhysicalDeviceTimelineSemaphoreFeatures*>(item)
                    ->timelineSemaphore;
            break;
        case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SYNCHRONIZATION_2_FEATURES:
            features.v13.synchronization2 =
                static_cast<const VkPhysicalDeviceSynchronization2Features*>(item)
                    ->synchronization2;
            break;
        case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_4_FEATURES:
            features.v13.maintenance4 =
                static_cast<const VkPhysicalDeviceMaintenance4Features*>(item)->maintenance4;
            break;
        default:
            break;
        }
    }
}

std::vector<std::string> missing_features(Features& features) {
    std::vector<std::string> missing;
    for_each_feature(features, [&](const auto& feature, auto& values) {
        if (feature.required && !(values.*feature.member)) missing.push_back(feature.name);
    });
    return missing;
}

std::vector<FamilyInfo> list_families(VkPhysicalDevice physical) {
    std::uint32_t count = 0;
    vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, nullptr);
    std::vector<VkQueueFamilyProperties> families(count);
    vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, families.data());
    std::vector<FamilyInfo> result;
    constexpr VkQueueFlags kOurs = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT |
                                   VK_QUEUE_TRANSFER_BIT | VK_QUEUE_SPARSE_BINDING_BIT |
                                   VK_QUEUE_PROTECTED_BIT;
    for (const VkQueueFamilyProperties& family : families) {
        const bool graphics = family.queueFlags & VK_QUEUE_GRAPHICS_BIT;
        const bool compute = family.queueFlags & VK_QUEUE_COMPUTE_BIT;
        const bool copies =
            (family.queueFlags & VK_QUEUE_TRANSFER_BIT) && !(family.queueFlags & ~kOurs);
        result.push_back({.graphics = graphics,
            .compute = compute,
            .transfer = graphics || compute || copies,
            .queues = family.queueCount,
            .timestamp_bits = family.timestampValidBits});
    }
    return result;
}

std::optional<std::uint32_t> find_queue_family(const std::vector<FamilyInfo>& families) {
    for (std::uint32_t i = 0; i < families.size(); ++i) {
        const FamilyInfo& family = families[i];
        if (family.graphics && family.compute && family.timestamp_bits > 0) return i;
    }
    return std::nullopt;
}

bool has_push_descriptors(VkPhysicalDevice physical) {
    return has_extension(extensions_of(physical), VK_KHR_PUSH_DESCRIPTOR_EXTENSION_NAME);
}

bool has_stencil_export(VkPhysicalDevice physical) {
    return has_extension(extensions_of(physical), VK_EXT_SHADER_STENCIL_EXPORT_EXTENSION_NAME);
}

std::vector<Candidate> rate_all(VkInstance instance, const std::vector<std::string>& extensions) {
    std::vector<Candidate> candidates;
    for (const VkPhysicalDevice physical : enumerate<VkPhysicalDevice>(
             "listing Vulkan devices", vkEnumeratePhysicalDevices, instance)) {
        candidates.push_back(rate(physical, extensions));
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

} // namespace ockham::gpu
