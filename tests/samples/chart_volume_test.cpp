// SPDX-License-Identifier: Apache-2.0
// What charts of volumes stand on: the truth about surfaces, references that know their error, runs
// over time, jobs that can be told apart, and the papers' numbers as printed.
#include "framework/image_error/image_error.hpp"
#include "samples/chart/paper_numbers.hpp"
#include "samples/chart/papers_suite.hpp"
#include "samples/chart/surface_search.hpp"
#include "samples/chart/volume_suite.hpp"
#include "tests/support/gpu_fixture.hpp"

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>

namespace ockham::chart {
namespace {

/// The JCGT paper's decibels are those of its MSE with a peak of 255.
TEST(PaperNumbers, DecibelsAreThoseOfThePrintedError) {
    for (const paper::AaRow& row : paper::kAaTable) {
        if (std::isnan(row.mse_1e5)) continue;
        const double decibels = -10 * std::log10(1e-5 * row.mse_1e5);
        EXPECT_NEAR(row.psnr_255 - paper::kDecibelsOf255, decibels, 0.02) << row.m;
    }
}

TEST(PaperNumbers, AShareOfTheSavedSamplesBecameTime) {
    for (std::size_t i = 3; i < std::size(paper::kAaTable); i += 2) {
        const paper::AaRow &ours = paper::kAaTable[i], &all = paper::kAaTable[i - 1];
        const double saved = 1 - ours.samples_percent / 100;
        for (const double ratio : {ours.ms / all.ms, ours.stalled_ms / all.stalled_ms}) {
            EXPECT_GT((1 - ratio) / saved, 0.15);
            EXPECT_LT((1 - ratio) / saved, 0.36);
        }
    }
}

/// Depth of the plane where a ramp along the view has its isovalue, from any pixel.
TEST(SurfaceTruth, FindsAPlane) {
    Volume volume;
    volume.dims = {4, 64, 4};
    volume.type = VoxelType::float32;
    volume.voxels.resize(volume.voxel_count() * sizeof(float));
    for (std::size_t i = 0; i < volume.voxel_count(); ++i) {
        const float value = float(i / 4 % 64) + 0.5f; // voxels from the front
        std::memcpy(&volume.voxels[i * sizeof value], &value, sizeof value);
    }
    Camera camera = look_at({0, -2, 0}, {0, 0, 0}, 1, UpAxis::z); // sees the front face alone
    for (const double depth : surface_truth(volume, 20, camera, 4))
        EXPECT_NEAR(depth, 20.0 / 64, 1e-6);
    for (const double depth : surface_truth(volume, 100, camera, 4)) EXPECT_LT(depth, 0);
    camera.forward = -camera.forward;
    for (const double depth : surface_truth(volume, 20, camera, 4)) EXPECT_LT(depth, 0);
}

class ChartVolumeTest : public test::GpuTest {
protected:
    static ChartOptions options(const std::string& folder) {
        ChartOptions o;
        o.quick = true;
        o.common.validation = "sync";
        o.out = std::filesystem::path(testing::TempDir()) / folder;
        std::filesystem::remove_all(o.out);
        return o;
    }
    static VolumeScene cube() {
        VolumeScene scene;
        scene.name = "cube";
        scene.options.volume = {"builtin:constant:8"};
        scene.options.density_scale = 4;
        scene.options.albedo = 0.5f;
        scene.options.environment = "1,1,1";
        return scene;
    }
};

TEST_F(ChartVolumeTest, JobsAreToldApartAndListedAlikeEachTime) {
    Context context(options("chart_jobs"));
    for (const auto make : {make_volume_suite, make_papers_suite}) {
        const std::vector<Job> jobs = make(context)->jobs(), again = make(context)->jobs();
        std::set<std::string> keys;
        for (const Job& job : jobs) {
            EXPECT_TRUE(keys.insert(job.key()).second) << job.series << " of " << job.scene;
            EXPECT_FALSE(job.command.empty()) << job.series;
        }
        ASSERT_EQ(jobs.size(), again.size());
        for (std::size_t i = 0; i < jobs.size(); ++i) EXPECT_EQ(jobs[i].key(), again[i].key());
        // Nothing measured: a page all the same.
        Store store(context.options.out);
        EXPECT_FALSE(make(context)->report(store, {}).plots.empty());
    }
}

TEST_F(ChartVolumeTest, ScenesOfThePapersHaveTheirRig) {
    ChartOptions with = options("chart_rig");
    std::filesystem::create_directories(with.out);
    for (const char* name : {"a.gltf", "rig.json", "other.json"})
        std::ofstream(with.out / name) << name;
    with.scenes = {(with.out / "a.gltf").string()};
    const auto first_job = [&](const char* rig) {
        with.rig = *rig ? (with.out / rig).string() : "";
        Context context(with);
        return make_papers_suite(context)->jobs().front();
    };
    EXPECT_NE(first_job("rig.json").command.find("--rig"), std::string::npos);
    EXPECT_NE(first_job("rig.json").key(), first_job("other.json").key());
    EXPECT_NE(first_job("rig.json").key(), first_job("").key());
}

/// Errors fall over the rows of a run, and a reference says truly how far it is from the mean of a
/// cube whose mean is known.
TEST_F(ChartVolumeTest, ErrorsFallWithSamples) {
    Context context(options("chart_run"));
    VolumeReferences references(context, 16);
    const VolumeReference& reference = references.of(cube(), VolumeMode::path);
    EXPECT_EQ(reference.samples, 512);
    EXPECT_GT(reference.mse, 0);
    VolumeGiParams params;
    params.width = params.height = 16;
    VolumeRun run(context.device(), cube(), params, reference, 0.5);
    const std::vector<Row> rows = run.measure();
    ASSERT_GE(rows.size(), 3u) << "a busy machine manages four samples in half a second";
    for (std::size_t i = 1; i < rows.size(); ++i) {
        EXPECT_EQ(rows[i].knob, 2 * rows[i - 1].knob);
        EXPECT_GT(rows[i].values.at("gpu_seconds"), rows[i - 1].values.at("gpu_seconds"));
    }
    EXPECT_LT(rows.back().values.at("relmse"), 0.5 * rows.front().values.at("relmse"));
    EXPECT_GT(rows.back().values.at("relmse"), 0.2 * reference.relmse);

    EXPECT_NO_THROW(expect_no_validation_messages(context.device()));
    // Again from the disk: the same picture.
    VolumeReferences others(context, 16);
    EXPECT_EQ(image_error(others.of(cube(), VolumeMode::path).picture, reference.picture).mse, 0);
}

} // namespace
} // namespace ockham::chart
