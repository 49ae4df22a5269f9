// SPDX-License-Identifier: Apache-2.0
#include "framework/gpu/device.hpp"
#include "framework/io/exr.hpp"
#include "framework/scene_gpu/scene_gpu.hpp"
#include "passes/pipelines/whole.hpp" // wrong

#include <CLI/CLI.hpp>
#include <GLFW/glfw3.h> // wrong
#include <imgui.h>      // wrong
