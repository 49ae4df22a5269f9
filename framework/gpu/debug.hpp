// SPDX-License-Identifier: Apache-2.0
// Validation messages, object names, labels, and VkResult as an Error. Everything in gpu and
// runtime reports through here; names and labels are no-ops where the driver has no
// VK_EXT_debug_utils.
#pragma once

#include <vulkan/vulkan.h>

#include <cstdint>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

namespace ockham::gpu {

class Device;

/// off: none. core: API use. sync: core, and hazards between commands, also across command buffers.
/// gpu: core, and shaders instrumented to find what they do out of bounds (2-5 times slower).
enum class Validation { off, core, sync, gpu };
const char* name_of(Validation validation);

/// What the validation layer said, in order. Performance advice is left out.
class ValidationLog {
public:
    void add(std::string message);
    std::size_t count() const;
    std::vector<std::string> messages() const;
    /// The messages so far, which are then forgotten.
    std::vector<std::string> take();

private:
    mutable std::mutex mutex_;
    std::vector<std::string> messages_;
};

/// A result code in words: "out of device memory (VK_ERROR_OUT_OF_DEVICE_MEMORY)".
std::string text_of(VkResult result);
/// Throws Error(device) "<what> failed: <text>; <what to do>" unless `result` is a success code.
void expect(VkResult result, std::string_view what);

/// The loader's functions for names and labels; null where there is no VK_EXT_debug_utils.
struct DebugFunctions {
    PFN_vkSetDebugUtilsObjectNameEXT set_name = nullptr;
    PFN_vkCmdBeginDebugUtilsLabelEXT begin_label = nullptr;
    PFN_vkCmdEndDebugUtilsLabelEXT end_label = nullptr;
};

/// Sends messages of `instance` to `log`, until destroyed. Owned by Device.
VkDebugUtilsMessengerCreateInfoEXT messenger_info(ValidationLog& log, Validation validation);

void set_name(
    const Device& device, VkObjectType type, std::uint64_t handle, const std::string& name);
template <class Handle>
void set_name(const Device& device, VkObjectType type, Handle handle, const std::string& name) {
    set_name(device, type, reinterpret_cast<std::uint64_t>(handle), name);
}

/// Labels the commands recorded during its life, in captures and validation messages.
class Label {
public:
    Label(const Device& device, VkCommandBuffer commands, const std::string& name);
    ~Label();
    Label(const Label&) = delete;
    Label& operator=(const Label&) = delete;

private:
    const Device& device_;
    VkCommandBuffer commands_;
};

} // namespace ockham::gpu
