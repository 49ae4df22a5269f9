// SPDX-License-Identifier: Apache-2.0
// Waiting that holds what it promises: what is in flight is done, or the device is lost. A wait may
// itself fail for want of memory; whoever then unwinds would destroy what the device still uses.
#pragma once

#include <vulkan/vulkan.h>

namespace ockham::gpu {

/// Calls `wait`, which returns a VkResult, again while it fails for want of memory, `tries` times
/// at most. What it returns last.
template <class Wait>
VkResult wait_out(const Wait& wait, int tries = 100) {
    VkResult result = wait();
    while (--tries > 0 &&
           (result == VK_ERROR_OUT_OF_HOST_MEMORY || result == VK_ERROR_OUT_OF_DEVICE_MEMORY)) {
        result = wait();
    }
    return result;
}

} // namespace ockham::gpu
