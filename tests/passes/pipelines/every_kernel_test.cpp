// SPDX-License-Identifier: Apache-2.0
// Every kernel of shaders/ that passes have, run by the pictures that use it, under GPU-assisted
// validation: the layer's own instructions report accesses out of bounds, and any message fails the
// test. Which kernels ran is read off the log, so that none is forgotten.
#include "framework/core/log.hpp"
#include "framework/gpu/shader.hpp"
#include "passes/pipelines/surface_volume.hpp"
#include "tests/support/ball.hpp"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/surface_scenes.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <regex>
#include <set>

namespace ockham::test {
namespace {

namespace fs = std::filesystem;
using Kernels = std::set<std::string>;

/// Before the first device is made.
[[maybe_unused]] const int assisted = ::setenv("OCKHAM_TEST_VALIDATION", "gpu", 1);

/// Compiled in this process so far, without their variants.
Kernels& compiled() {
    static Kernels names;
    return names;
}

/// Kernels that meshes in a medium add.
const Kernels kOfMeshesInAMedium{"surface/isosurfaces.vert", "surface/isosurfaces.frag",
    "surface/mesh_radiance.comp", "volume/mesh_ends.comp", "volume/over_meshes.comp"};

/// Files of a folder of shaders/ that are compiled on their own.
Kernels kernels_of(const std::string& folder) {
    Kernels names;
    for (const auto& entry : fs::directory_iterator(fs::path(OCKHAM_SHADERS) / folder)) {
        const std::string extension = entry.path().extension();
        if (extension == ".comp" || extension == ".vert" || extension == ".frag")
            names.insert(folder + "/" + entry.path().filename().string());
    }
    return names;
}

class EveryKernel : public GpuTest {
protected:
    EveryKernel() {
        log::set_level(log::Level::debug);
        log::set_sink([](log::Level, std::string_view text) {
            if (!text.starts_with("pipeline of shader")) return;
            const std::string line(text);
            const std::regex name("[a-z_]+/[a-z_]+\\.(comp|vert|frag)");
            for (std::sregex_iterator it(line.begin(), line.end(), name), end; it != end; ++it)
                compiled().insert(it->str());
        });
    }
    ~EveryKernel() override {
        log::set_sink({});
        log::set_level(log::Level::info);
    }

    static void expect_compiled(const Kernels& kernels) {
        EXPECT_GE(kernels.size(), 3u) << "looked in the wrong folder?";
        for (const std::string& kernel : kernels)
            EXPECT_TRUE(compiled().contains(kernel)) << kernel << " did not run";
        std::printf("reliability: gpu_assisted {\"kernels\": %zu}\n", kernels.size());
    }
};

AdaptiveAaParams adaptive(MetricKind metric = MetricKind::ockham) {
    AdaptiveAaParams p;
    p.width = 13;
    p.height = 9;
    p.m = 2;
    p.metric = metric;
    p.resolve = metric == MetricKind::ockham ? Resolve::stratified : Resolve::prefix;
    p.filter_highlights = metric == MetricKind::ockham;
    p.aov = true;
    return p;
}

std::vector<AdaptiveAaParams> all_of_surfaces() {
    std::vector<AdaptiveAaParams> all{adaptive(), adaptive(MetricKind::paper)};
    for (const AaMethod method : {AaMethod::none, AaMethod::fxaa, AaMethod::smaa, AaMethod::sraa,
             AaMethod::taa, AaMethod::msaa, AaMethod::cluster, AaMethod::uniform, AaMethod::ssaa}) {
        all.push_back(adaptive());
        all.back().method = method;
        all.back().aov = false;
    }
    for (const Dispatch dispatch : kDispatches) {
        all.push_back(adaptive());
        all.back().dispatch = dispatch;
    }
    all.push_back(adaptive());
    all.back().budget = 60;
    all.push_back(adaptive());
    all.back().count_block = 3;
    all.push_back(adaptive());
    all.back().history = true;
    all.push_back(adaptive());
    all.back().bloom = 0.1f;
    all.push_back(adaptive());
    all.back().gbuffer = GbufferLayout::visibility;
    return all;
}

TEST_F(EveryKernel, OfSurfacesIsSilent) {
    const LitScene lit(device(), varied_scene(true));
    const Camera& camera = lit.scene().cameras.front();
    for (const AdaptiveAaParams& p : all_of_surfaces()) {
        if (p.dispatch == Dispatch::stencil && !device().exports_stencil()) continue;
        AdaptiveAa aa(device(), lit, camera, p);
        for (int frame = 0; frame < 2; ++frame) {
            Camera moved = camera;
            moved.position.x += 0.1f * static_cast<float>(frame);
            aa.set_camera(moved);
            aa.execute();
        }
        for (const std::string& message : take_messages())
            ADD_FAILURE() << "method " << static_cast<int>(p.method) << ", " << name_of(p.dispatch)
                          << ": " << message;
    }
    Kernels all;
    for (const char* folder : {"surface", "schedule", "post", "debug"})
        all.merge(kernels_of(folder));
    for (const std::string& kernel : kOfMeshesInAMedium) all.erase(kernel);
    expect_compiled(all);
}

VolumeView lit_view() {
    VolumeView view;
    view.light_direction = {0.3f, 1.0f, -0.4f};
    view.light_irradiance = glm::vec3(2.0f);
    view.density_scale = 10;
    view.albedo = 0.9f;
    view.phase_g = 0.4f;
    return view;
}

VolumeGiParams volume_params(VolumeMode mode, bool gather) {
    VolumeGiParams p;
    p.width = 13;
    p.height = 9;
    p.mode = mode;
    p.gather = gather;
    return p;
}

TEST_F(EveryKernel, OfVolumesIsSilent) {
    const Volume volume = ball();
    const TransferFunction glowing{
        {{.value = 0, .opacity = 0}, {.value = 255, .opacity = 1, .emission = {0.5, 0.4, 0.3}}}};
    Image sky(8, 4, {"R", "G", "B"});
    for (int c = 0; c < 3; ++c)
        for (float& value : sky.plane(c)) value = 0.5f;
    const auto run = [&](const VolumeGiParams& p, bool surfaces, const Image& environment) {
        VolumeView view = lit_view();
        if (surfaces) view.surfaces = {{.value = 190, .opacity = 0.5f}};
        const Camera front = look_at({0, -2.4f, 0.2f}, {0, 0, 0}, 30, UpAxis::z);
        VolumeGi gi(device(), volume, glowing, environment, view, front, p);
        gi.execute();
        view.light_irradiance = glm::vec3(1.0f); // what is cached begins anew
        gi.set_view(view);
        gi.execute();
        gi.finish();
        for (const std::string& message : take_messages())
            ADD_FAILURE() << name_of(p.mode) << ", gather " << p.gather << ": " << message;
    };
    for (const VolumeMode mode : {VolumeMode::path, VolumeMode::noncaching, VolumeMode::caching})
        run(volume_params(mode, true), false, {});
    run(volume_params(VolumeMode::caching, false), true, sky);
    for (const SurfaceSearch search : {SurfaceSearch::march, SurfaceSearch::stochastic}) {
        VolumeGiParams composed = volume_params(VolumeMode::caching, false);
        composed.search = search;
        run(composed, true, {});
    }
    run(volume_params(VolumeMode::path, true), true, sky);
    Kernels all = kernels_of("volume");
    for (const std::string& kernel : kOfMeshesInAMedium) all.erase(kernel);
    expect_compiled(all);
}

TEST_F(EveryKernel, OfMeshesInAMediumIsSilent) {
    const LitScene lit(device(), varied_scene(true));
    const Volume volume = ball();
    const TransferFunction rising{{{.value = 0, .opacity = 0}, {.value = 255, .opacity = 1}}};
    const Image none;
    VolumeView view = lit_by(lit.scene(), lit_view(), glm::vec3(0.3f));
    view.surfaces = {{.value = 100}};
    const VolumePlacement place{{2, 2, 0}, {10, 20, 30}, 6};
    for (const bool gather : {true, false}) {
        SurfaceVolumeParams p;
        p.surfaces = adaptive();
        p.surfaces.aov = false;
        p.medium = volume_params(gather ? VolumeMode::path : VolumeMode::caching, gather);
        SurfaceVolume picture(device(), &lit, MediumSource{volume, rising, none, view, place},
            lit.scene().cameras.front(), p);
        picture.execute();
        picture.execute();
        picture.finish();
        for (const std::string& message : take_messages())
            ADD_FAILURE() << "gather " << gather << ": " << message;
    }
    Kernels there;
    for (const char* folder : {"surface", "volume"})
        for (const std::string& kernel : kernels_of(folder))
            if (kOfMeshesInAMedium.contains(kernel)) there.insert(kernel);
    expect_compiled(there);
}

/// A fourth is no place for what branches and loops read, for the sake of lavapipe: why is told in
/// shaders/surface/materials.glsl.
TEST(EveryKernelTest, DecidesByThreeUniformBuffersAtMost) {
    std::size_t most = 0;
    for (const std::string_view name : gpu::shader_names()) {
        std::map<std::uint32_t, std::string> buffers;
        for (const gpu::ShaderBinding& b : gpu::reflect(name, gpu::find_shader(name)).bindings) {
            if (b.type == VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER) buffers.emplace(b.binding, b.name);
        }
        most = std::max(most, buffers.size());
        ASSERT_LE(buffers.size(), 4u) << name;
        if (buffers.size() == 4) {
            EXPECT_EQ(buffers.rbegin()->second, "few_materials") << name;
        }
    }
    EXPECT_EQ(most, 4u) << "of surfaces in a medium";
}

TEST(EveryKernelTest, KnowsEveryFolder) {
    const std::set<std::string> known{"debug", "include", "post", "samples", "schedule", "shared",
        "surface", "volume"}; // samples: of programs, run by hello_graph and the tutorials
    for (const auto& entry : fs::directory_iterator(OCKHAM_SHADERS))
        EXPECT_TRUE(known.contains(entry.path().filename())) << entry.path();
}

} // namespace
} // namespace ockham::test
