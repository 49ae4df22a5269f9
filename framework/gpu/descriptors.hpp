// SPDX-License-Identifier: Apache-2.0
// Descriptor sets that live for one execution: taken one after another from pools, given back all
// at once. For devices without push descriptors, and for sets other than 0.
#pragma once

#include <vulkan/vulkan.h>

#include <cstddef>
#include <vector>

namespace ockham::gpu {

class Device;

class DescriptorArena {
public:
    explicit DescriptorArena(Device& device) : device_(device) {}
    ~DescriptorArena();
    DescriptorArena(const DescriptorArena&) = delete;
    DescriptorArena& operator=(const DescriptorArena&) = delete;

    /// A set with undefined content, valid until reset().
    VkDescriptorSet allocate(VkDescriptorSetLayout layout);
    /// Gives all sets back. The device must be done with them.
    void reset();

private:
    Device& device_;
    std::vector<VkDescriptorPool> pools_;
    std::size_t current_ = 0; ///< index of the pool that is not full
};

} // namespace ockham::gpu
