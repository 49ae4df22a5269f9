// SPDX-License-Identifier: Apache-2.0
#include "framework/io/gltf.hpp" // wrong
#include "shaders/shared/types.h"

#include <vulkan/vulkan_core.h> // wrong
