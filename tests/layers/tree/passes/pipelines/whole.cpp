// SPDX-License-Identifier: Apache-2.0
#include "framework/app/cli.hpp" // wrong
#include "framework/gpu/device.hpp"
#include "passes/surface/resolve.hpp"
#include "passes/surface/shade.hpp"
