// SPDX-License-Identifier: Apache-2.0
#include "framework/gpu/debug.hpp"

#include "framework/core/error.hpp"
#include "framework/core/log.hpp"
#include "framework/gpu/device.hpp"
#include "framework/gpu/device_lost.hpp"

namespace ockham::gpu {

const char* name_of(Validation validation) {
    switch (validation) {
    case Validation::off:
        return "off";
    case Validation::core:
        return "core";
    case Validation::sync:
        return "sync";
    case Validation::gpu:
        return "gpu";
    }
    return "?";
}

void ValidationLog::add(std::string message) {
    log::error("validation: {}", message);
    const std::lock_guard lock(mutex_);
    messages_.push_back(std::move(message));
}

std::size_t ValidationLog::count() const {
    const std::lock_guard lock(mutex_);
    return messages_.size();
}

std::vector<std::string> ValidationLog::messages() const {
    const std::lock_guard lock(mutex_);
    return messages_;
}

std::vector<std::string> ValidationLog::take() {
    const std::lock_guard lock(mutex_);
    return std::exchange(messages_, {});
}

namespace {

struct ResultText {
    VkResult result;
    const char* code;
    const char* text;
    const char* advice;
};

constexpr const char* kMemoryAdvice = "use a smaller picture or scene, or free GPU memory";
constexpr ResultText kResults[] = {
    {VK_ERROR_OUT_OF_HOST_MEMORY, "VK_ERROR_OUT_OF_HOST_MEMORY", "out of host memory",
        kMemoryAdvice},
    {VK_ERROR_OUT_OF_DEVICE_MEMORY, "VK_ERROR_OUT_OF_DEVICE_MEMORY", "out of device memory",
        kMemoryAdvice},
    {VK_ERROR_OUT_OF_POOL_MEMORY, "VK_ERROR_OUT_OF_POOL_MEMORY", "descriptor pool exhausted",
        kMemoryAdvice},
    {VK_ERROR_FRAGMENTED_POOL, "VK_ERROR_FRAGMENTED_POOL", "descriptor pool fragmented",
        kMemoryAdvice},
    {VK_ERROR_FRAGMENTATION, "VK_ERROR_FRAGMENTATION", "memory fragmented", kMemoryAdvice},
    {VK_ERROR_MEMORY_MAP_FAILED, "VK_ERROR_MEMORY_MAP_FAILED", "memory cannot be mapped",
        kMemoryAdvice},
    {VK_ERROR_INITIALIZATION_FAILED, "VK_ERROR_INITIALIZATION_FAILED",
        "the driver could not be initialised", "see the driver's own messages"},
    {VK_ERROR_DEVICE_LOST, "VK_ERROR_DEVICE_LOST", "device lost",
        "a shader ran too long or the driver crashed: see the system log"},
    {VK_ERROR_LAYER_NOT_PRESENT, "VK_ERROR_LAYER_NOT_PRESENT", "layer not present",
        "install the package vulkan-validationlayers"},
    {VK_ERROR_EXTENSION_NOT_PRESENT, "VK_ERROR_EXTENSION_NOT_PRESENT", "extension not present",
        "update the driver"},
    {VK_ERROR_FEATURE_NOT_PRESENT, "VK_ERROR_FEATURE_NOT_PRESENT", "feature not present",
        "choose another device: --list-gpus"},
    {VK_ERROR_INCOMPATIBLE_DRIVER, "VK_ERROR_INCOMPATIBLE_DRIVER", "no usable Vulkan driver",
        "install one, for example the package mesa-vulkan-drivers"},
    {VK_ERROR_TOO_MANY_OBJECTS, "VK_ERROR_TOO_MANY_OBJECTS", "too many objects", kMemoryAdvice},
    {VK_ERROR_FORMAT_NOT_SUPPORTED, "VK_ERROR_FORMAT_NOT_SUPPORTED", "format not supported",
        "choose another device: --list-gpus"},
};

const ResultText* find(VkResult result) {
    for (const ResultText& row : kResults) {
        if (row.result == result) return &row;
    }
    return nullptr;
}

} // namespace

std::string text_of(VkResult result) {
    const ResultText* row = find(result);
    return row ? fmt::format("{} ({})", row->text, row->code)
               : fmt::format("VkResult {}", static_cast<int>(result));
}

void expect(VkResult result, std::string_view what) {
    if (result >= 0) return;
    const ResultText* row = find(result);
    const std::string text = fmt::format("{} failed: {}; {}", what, text_of(result),
        row ? row->advice : "see the driver's own messages");
    if (result == VK_ERROR_DEVICE_LOST) throw DeviceLost(text);
    fail_device("{}", text);
}

namespace {

VKAPI_ATTR VkBool32 VKAPI_CALL on_message(VkDebugUtilsMessageSeverityFlagBitsEXT,
    VkDebugUtilsMessageTypeFlagsEXT, const VkDebugUtilsMessengerCallbackDataEXT* data, void* user) {
    static_cast<ValidationLog*>(user)->add(data->pMessage);
    return VK_FALSE;
}

} // namespace

VkDebugUtilsMessengerCreateInfoEXT messenger_info(ValidationLog& log, Validation validation) {
    VkDebugUtilsMessengerCreateInfoEXT info{
        .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT};
    info.messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
    // With instrumented shaders the layer warns about its own set-up.
    if (validation != Validation::gpu) {
        info.messageSeverity |= VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT;
    }
    info.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
    info.pfnUserCallback = on_message;
    info.pUserData = &log;
    return info;
}

void set_name(
    const Device& device, VkObjectType type, std::uint64_t handle, const std::string& name) {
    if (!device.debug().set_name) return;
    const VkDebugUtilsObjectNameInfoEXT info{
        .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT,
        .objectType = type,
        .objectHandle = handle,
        .pObjectName = name.c_str()};
    device.debug().set_name(device.handle(), &info);
}

Label::Label(const Device& device, VkCommandBuffer commands, const std::string& name)
    : device_(device), commands_(commands) {
    if (!device_.debug().begin_label) return;
    const VkDebugUtilsLabelEXT label{
        .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_LABEL_EXT, .pLabelName = name.c_str()};
    device_.debug().begin_label(commands_, &label);
}

Label::~Label() {
    if (device_.debug().end_label) device_.debug().end_label(commands_);
}

} // namespace ockham::gpu
