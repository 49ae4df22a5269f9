// SPDX-License-Identifier: Apache-2.0
// A PassBench with a volume in it: uploaded, imported, with its VolumeFrame, ranges and majorants.
// For tests of the passes on volumes; ranges and majorants come from the host, so that only the
// pass under test is compiled and run.
#pragma once

#include "passes/volume/frame.hpp"
#include "passes/volume/medium_inputs.hpp"
#include "tests/reference/volume_ranges.hpp"
#include "tests/support/pass_bench.hpp"

namespace ockham::test {

class VolumeBench : public PassBench {
public:
    struct Options {
        VolumeView view = {};
        std::uint32_t width = 64, height = 64;
        Camera camera = volume_camera();
        Image environment = {};
        bool sobol = false; ///< tests of expectations need independent samples
    };

    VolumeBench(gpu::Device& device, const Volume& volume, const TransferFunction& transfer,
        const Options& options)
        : PassBench(device), gpu(device, volume, transfer, options.environment),
          frame(make_volume_frame(
              place_of(volume), gpu, options.camera, options.width, options.height, options.view)) {
        inputs.facts = gpu.facts();
        inputs.handles = gpu.import(graph);
        inputs.frame = buffer("frame", std::vector{frame});
        inputs.sobol = options.sobol;
        inputs.surfaces = !options.view.surfaces.empty();
        std::vector<glm::vec2> ranges;
        std::vector<float> majorants;
        for (const ValueRange& range : reference::cell_ranges(volume)) {
            ranges.emplace_back(gpu.texel_of(range.lowest), gpu.texel_of(range.highest));
            majorants.push_back(
                1.000001f * static_cast<float>(reference::greatest_opacity(gpu.table(), range)));
        }
        if (inputs.surfaces) inputs.ranges = buffer("host_ranges", ranges);
        if (!inputs.facts.homogeneous) inputs.majorants = buffer("host_majorants", majorants);
        on_bind([this](Executor& executor) { gpu.bind(executor, inputs.handles); });
    }

    VolumeGpu gpu;
    shader::VolumeFrame frame;
    MediumInputs inputs;
};

/// A volume of floats, box with sides in the ratio of dims; data values are what `value` gives for
/// a voxel.
template <class Value>
Volume float_volume(glm::uvec3 dims, Value value) {
    Volume volume;
    volume.name = "test";
    volume.dims = dims;
    volume.type = VoxelType::float32;
    std::vector<float> voxels;
    for (std::uint32_t z = 0; z < dims.z; ++z)
        for (std::uint32_t y = 0; y < dims.y; ++y)
            for (std::uint32_t x = 0; x < dims.x; ++x)
                voxels.push_back(static_cast<float>(value(glm::uvec3(x, y, z))));
    const auto bytes = std::as_bytes(std::span(voxels));
    volume.voxels.assign(bytes.begin(), bytes.end());
    return volume;
}

/// Opacity = value from 0 to 1, one colour, and emission times the value.
inline TransferFunction linear_transfer(
    glm::dvec3 color = glm::dvec3(1.0), glm::dvec3 emission = glm::dvec3(0.0)) {
    return {{{.value = 0, .opacity = 0, .color = color, .emission = emission},
        {.value = 1, .opacity = 1, .color = color, .emission = emission}}};
}

} // namespace ockham::test
