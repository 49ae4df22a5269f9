// SPDX-License-Identifier: Apache-2.0
#include "framework/core/error.hpp"
#include "framework/runtime/executor.hpp" // wrong

#include <glslang/Public/ShaderLang.h> // wrong
#include <spirv_cross/spirv_cross_c.h>
#include <vulkan/vulkan.h>

void wait(VkDevice device) { vkDeviceWaitIdle(device); }
