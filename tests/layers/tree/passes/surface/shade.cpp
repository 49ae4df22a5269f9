// SPDX-License-Identifier: Apache-2.0
#include "passes/surface/shade.hpp"

#include "framework/gpu/device.hpp"   // wrong
#include "framework/io/exr.hpp"       // wrong
#include "framework/runtime/commands.hpp"
#include "passes/pipelines/whole.hpp" // wrong
#include "passes/surface/frame.hpp"
#include "passes/surface/resolve.hpp" // wrong
#include "shaders/surface/shade.h"

#include <CLI/CLI.hpp> // wrong
