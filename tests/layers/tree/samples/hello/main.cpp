// SPDX-License-Identifier: Apache-2.0
#include "framework/app/cli.hpp"
#include "framework/gpu/device.hpp"
#include "passes/pipelines/whole.hpp"
#include "passes/surface/shade.hpp"
#include "samples/hello/options.hpp"
#include "tests/support/gpu_fixture.hpp" // wrong

#include <CLI/CLI.hpp>

int main() { vkDeviceWaitIdle(nullptr); } // wrong
