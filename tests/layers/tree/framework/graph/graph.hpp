// SPDX-License-Identifier: Apache-2.0
#include "framework/core/error.hpp"
#include "framework/gpu/device.hpp" // wrong

#include <vulkan/vulkan_core.h>

// vkCmdDispatch may be named in a comment, and PFN_vkCmdDispatch is a type.
inline PFN_vkCmdDispatch dispatch = &vkCmdDispatch; // wrong
