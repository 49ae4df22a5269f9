// SPDX-License-Identifier: Apache-2.0
// A PassBench with a scene in it: uploaded, imported, with its camera's FrameData. For tests of
// the passes that draw or shade.
#pragma once

#include "passes/surface/draw_scene.hpp"
#include "passes/surface/frame.hpp"
#include "tests/support/pass_bench.hpp"

namespace ockham::test {

class SceneBench : public PassBench {
public:
    SceneBench(gpu::Device& device, const Scene& scene, const Camera& camera, std::uint32_t width,
        std::uint32_t height, std::uint32_t m, const std::vector<std::uint32_t>& order)
        : PassBench(device), gpu(device, scene),
          frame(make_frame(scene, gpu.bounds(), camera, static_cast<int>(width),
              static_cast<int>(height), static_cast<int>(m), order, 1)) {
        inputs.scene = &gpu;
        inputs.handles = gpu.import(graph);
        inputs.frame = buffer("frame", std::vector{frame});
        on_bind([this](Executor& executor) { gpu.bind(executor, inputs.handles); });
    }

    SceneGpu gpu;
    shader::FrameData frame;
    SceneInputs inputs;
};

} // namespace ockham::test
