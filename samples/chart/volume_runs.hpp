// SPDX-License-Identifier: Apache-2.0
// What charts of volumes are measured with: scenes, references that know their own error, and runs
// that show how the error falls with time. Draws nothing. Called by the suites volume, papers and
// stability.
#pragma once

#include "framework/app/volume_source.hpp"
#include "passes/pipelines/volume_gi.hpp"
#include "samples/chart/suite.hpp"

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace ockham::chart {

/// A volume, how it looks, and from where. What `flags()` says draws the same by hand.
struct VolumeScene {
    std::string name;      ///< for people: "cloud"
    VolumeOptions options; ///< as on volume_gi's command line
    std::string camera;    ///< likewise; empty: its default
    bool sky = false;      ///< lit by sky_with_sun(), which by hand is a file

    VolumeSource load() const;
    Camera view() const;
    std::string flags() const;
    /// For Job::inputs: everything that decides the picture.
    std::string inputs() const;
    VolumeScene with_shading(const std::string& shading) const;
};

/// Those of --volumes, or the built-in ones: "cloud" without surfaces, "fingers" with one.
std::vector<VolumeScene> volume_scenes(const ChartOptions& options);

/// The same, and where they are the built-in ones others, of as many kinds as a choice by scenes
/// should know: thin, thick and white media, small and many surfaces.
std::vector<VolumeScene> class_scenes(const ChartOptions& options);

/// A picture that others are compared with. Errors are its own, against what it would converge to,
/// from how much its two halves differ: ImageError's mse and relmse.
struct VolumeReference {
    Image picture;
    double samples = 0; ///< per pixel
    double mse = 0, relmse = 0;
};

/// Keeps references on the disk beside the measurements, since they cost more than these.
class VolumeReferences {
public:
    VolumeReferences(Context& context, std::uint32_t side) : context_(context), side_(side) {}
    /// Of mode path or noncaching, `side` x `side` pixels; 512 samples per pixel with --quick,
    /// 16,384 without, or those of two minutes.
    const VolumeReference& of(const VolumeScene& scene, VolumeMode mode);

private:
    Context& context_;
    std::uint32_t side_;
    std::map<std::string, VolumeReference> kept_; ///< by scene and mode
};

/// User and system time of the whole process, seconds.
double cpu_seconds();
/// Sum of the passes' timestamps of the last execution, seconds.
double gpu_seconds(const Executor& executor);

/// Runs one technique again and again with other seeds, and tells its error after 1, 2, 4 ...
/// steps, until it has taken `seconds` of GPU time. Values of a row: samples (per pixel; the knob
/// too), gpu_seconds, cpu_seconds, psnr, rmse, flip, ssim, relmse, relrmse, paths, cells,
/// cell_bytes, converged (the cache: 0 or 1).
class VolumeRun : public Subject {
public:
    /// With `truth`, true_psnr too: against that; and at least the steps of a probe (volume_choice).
    VolumeRun(gpu::Device& device, const VolumeScene& scene, const VolumeGiParams& params,
        const VolumeReference& reference, double seconds, const VolumeReference* truth = nullptr);
    std::vector<Row> measure() override;
    std::map<std::string, Picture> pictures() override;

private:
    VolumeSource source_;
    const VolumeReference& reference_;
    const VolumeReference* truth_;
    double seconds_;
    std::uint32_t seed_;
    VolumeGi gi_;
};

/// Executes until the cache has reached its error, at most `most` times and until `seconds` of GPU
/// time are spent; returns these.
double converge(VolumeGi& gi, int most, double seconds);

/// Jobs beside what opens them.
class JobList {
public:
    using Open = std::function<std::unique_ptr<Subject>()>;
    void add(Job job, Open open) { entries_.push_back({std::move(job), std::move(open)}); }
    std::vector<Job> jobs() const;
    std::unique_ptr<Subject> open(const Job& job) const;

private:
    struct Entry {
        Job job;
        Open open;
    };
    std::vector<Entry> entries_;
};

/// A subject of one row that is the same each time.
class Once : public Subject {
public:
    using Body = std::function<std::vector<Row>(std::map<std::string, Picture>&)>;
    explicit Once(Body body) : body_(std::move(body)) {}
    std::vector<Row> measure() override { return body_(pictures_); }
    std::map<std::string, Picture> pictures() override { return pictures_; }

private:
    Body body_;
    std::map<std::string, Picture> pictures_;
};

} // namespace ockham::chart
