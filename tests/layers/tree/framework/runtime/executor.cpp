// SPDX-License-Identifier: Apache-2.0
#include "framework/gpu/device.hpp"
#include "framework/graph/graph.hpp"
#include "framework/scene/scene.hpp" // wrong
