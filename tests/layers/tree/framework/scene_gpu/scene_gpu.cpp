// SPDX-License-Identifier: Apache-2.0
#include "framework/runtime/executor.hpp"
#include "framework/scene/scene.hpp"
#include "passes/surface/frame.hpp" // wrong
#include "shaders/shared/scene.h"

void record(VkCommandBuffer commands) { vkCmdDispatch(commands, 1, 1, 1); } // wrong
