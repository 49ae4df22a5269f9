// SPDX-License-Identifier: Apache-2.0
// Which Vulkan device to use, and why not the others: the instance, the features asked for, and a
// score for each device. Used by Device and list_gpus() only.
#pragma once

#include "framework/gpu/debug.hpp"
#include "framework/gpu/queue.hpp"

#include <optional>
#include <string>
#include <vector>

namespace ockham::gpu {

struct Instance {
    VkInstance handle = VK_NULL_HANDLE;
    bool debug_utils = false;
};

/// An instance with `more` extensions; messages of the validation layer go to `log`, which must
/// outlive it. Throws Error(device) where there is no driver, or no layer or extension although
/// asked for.
Instance create_instance(
    Validation validation, const std::vector<std::string>& more, ValidationLog& log);

/// The features that the project asks about, chained for vkGetPhysicalDeviceFeatures2 and, reduced
/// to what is wanted, for vkCreateDevice.
struct Features {
    Features() {
        v10.pNext = &v12;
        v12.pNext = &v13;
    }
    Features(const Features&) = delete;
    Features& operator=(const Features&) = delete;

    /// The member of the type of the argument, whose value does not matter.
    auto& of(const VkPhysicalDeviceFeatures&) { return v10.features; }
    auto& of(const VkPhysicalDeviceVulkan12Features&) { return v12; }
    auto& of(const VkPhysicalDeviceVulkan13Features&) { return v13; }

    VkPhysicalDeviceFeatures2 v10{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2};
    VkPhysicalDeviceVulkan12Features v12{
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES};
    VkPhysicalDeviceVulkan13Features v13{
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES};
};

/// What a caller's chain of feature structs enables of the above: VkPhysicalDeviceFeatures2, the
/// structs of Vulkan 1.2 and 1.3, and those of single features that the project requires.
void read_features(const void* chain, Features& features);
/// Names of required features that are not set.
std::vector<std::string> missing_features(Features& features);

/// Sets what the project uses and the device has; required features are all there once select()
/// has accepted the device.
void choose_features(VkPhysicalDevice physical, Features& features);

struct Candidate {
    VkPhysicalDevice handle = VK_NULL_HANDLE;
    std::string name;
    int score = 0;
    std::vector<std::string> merits;   ///< each with its part of the score
    std::vector<std::string> refusals; ///< empty: usable
};

/// Devices without one of `extensions` are refused.
std::vector<Candidate> rate_all(VkInstance instance, const std::vector<std::string>& extensions);
/// One line per device: index, name, and score with its parts or reasons of refusal.
std::string describe(const std::vector<Candidate>& candidates);
/// The best usable device among those that `wish` names (index, part of the name, or empty for
/// all). Throws Error(device) with the description of all if there is none.
const Candidate& select(const std::vector<Candidate>& candidates, const std::string& wish);

/// By Vulkan's index, with the number of queues that exist. A family for video or the like has
/// none of the three abilities.
std::vector<FamilyInfo> list_families(VkPhysicalDevice physical);
/// The first family with graphics and compute, whose timestamps count.
std::optional<std::uint32_t> find_queue_family(const std::vector<FamilyInfo>& families);
bool has_push_descriptors(VkPhysicalDevice physical);
bool has_stencil_export(VkPhysicalDevice physical);

} // namespace ockham::gpu
