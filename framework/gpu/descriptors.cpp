// SPDX-License-Identifier: Apache-2.0
#include "framework/gpu/descriptors.hpp"

#include "framework/gpu/device.hpp"

namespace ockham::gpu {

namespace {

constexpr std::uint32_t kSetsPerPool = 256;

VkDescriptorPool create_pool(const Device& device) {
    constexpr VkDescriptorPoolSize kSizes[] = {
        {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 8 * kSetsPerPool},
        {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 8 * kSetsPerPool},
        {VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, 4 * kSetsPerPool},
        {VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 2 * kSetsPerPool}};
    const VkDescriptorPoolCreateInfo info{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
        .maxSets = kSetsPerPool,
        .poolSizeCount = std::size(kSizes),
        .pPoolSizes = kSizes};
    VkDescriptorPool pool = VK_NULL_HANDLE;
    expect(vkCreateDescriptorPool(device.handle(), &info, nullptr, &pool),
        "creating a descriptor pool");
    return pool;
}

} // namespace

DescriptorArena::~DescriptorArena() {
    for (const VkDescriptorPool pool : pools_) {
        vkDestroyDescriptorPool(device_.handle(), pool, nullptr);
    }
}

VkDescriptorSet DescriptorArena::allocate(VkDescriptorSetLayout layout) {
    for (;;) {
        const bool fresh = current_ == pools_.size();
        if (fresh) pools_.push_back(create_pool(device_));
        const VkDescriptorSetAllocateInfo info{
            .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
            .descriptorPool = pools_[current_],
            .descriptorSetCount = 1,
            .pSetLayouts = &layout};
        VkDescriptorSet set = VK_NULL_HANDLE;
        const VkResult result = vkAllocateDescriptorSets(device_.handle(), &info, &set);
        if (result == VK_SUCCESS) return set;
        const bool full =
            result == VK_ERROR_OUT_OF_POOL_MEMORY || result == VK_ERROR_FRAGMENTED_POOL;
        if (!full || fresh) expect(result, "allocating a descriptor set");
        ++current_;
    }
}

void DescriptorArena::reset() {
    for (const VkDescriptorPool pool : pools_) vkResetDescriptorPool(device_.handle(), pool, 0);
    current_ = 0;
}

} // namespace ockham::gpu
