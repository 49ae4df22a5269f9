// SPDX-License-Identifier: Apache-2.0
// A suite of charts: it lists its jobs first, measures one at a time, and at the end says what to
// draw of them. run_suites() takes the jobs in turns (A B C A B C), keeps every repeat at once and
// leaves out those that are kept already. Implemented by *_suite.cpp, called by main.cpp.
#pragma once

#include "framework/app/cli.hpp"
#include "framework/core/image.hpp"
#include "samples/chart/page.hpp"
#include "samples/chart/picture_metrics.hpp"
#include "samples/chart/store.hpp"

#include <memory>
#include <string>
#include <vector>

namespace ockham::chart {

/// What the command line asked for, as all suites see it.
struct ChartOptions {
    CommonOptions common;             ///< width and height of pictures, device
    std::vector<std::string> scenes;  ///< files or builtin: names
    std::vector<std::string> volumes; ///< likewise
    std::string rig;                  ///< of scenes that are files; empty: their own
    std::filesystem::path out;
    std::string ffmpeg, vmaf_model, onnx; ///< of picture_metrics.hpp; empty: what there is
    float target_psnr = 0, target_ms = 0; ///< > 0: what they would choose is marked
    int repeats = 5;
    bool quick = false; ///< small pictures, few settings: all suites together in 20 minutes
};

/// Options, and the device, which is made when a suite first asks for it.
class Context {
public:
    explicit Context(ChartOptions asked) : options(std::move(asked)), metrics_(options) {}

    const ChartOptions options;
    PictureMetrics& metrics() { return metrics_; }
    gpu::Device& device();
    bool has_device() const { return device_ != nullptr; }
    /// Device and driver, for Job::inputs of what runs on it.
    std::string device_text();
    /// "llvmpipe (LLVM 15.0.6, 256 bits)" and the like; empty where none was asked for.
    std::string device_name() const;

private:
    PictureMetrics metrics_;
    std::unique_ptr<gpu::Device> device_;
};

/// Display-encoded bytes, to be kept as PNG.
struct Picture {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgb;
};
Picture to_picture(const Image& linear, float exposure_ev = 0);
/// Displayed largest difference of R, G, B per pixel, times `scale`, in false colour.
Picture error_picture(const Image& test, const Image& reference, float scale = 10);

std::string cpu_name(); ///< model and cores, as the system says

/// A job that is set up and warm.
class Subject {
public:
    virtual ~Subject() = default;
    /// One repeat: one row, or one for each point of a curve. Returns early, with what there is,
    /// where interrupted(); it is not kept then.
    virtual std::vector<Row> measure() = 0;
    /// By name; asked for once, after the first repeat.
    virtual std::map<std::string, Picture> pictures() { return {}; }
};

class Suite {
public:
    virtual ~Suite() = default;
    virtual std::string name() const = 0;
    /// Why it cannot run on this machine, and what to do ("blender is not installed: apt-get ...");
    /// empty: it can.
    virtual std::string obstacle() { return {}; }
    /// All of them, the same ones in the same order in each run of one command. Measures nothing.
    virtual std::vector<Job> jobs() = 0;
    /// So many neighbours in jobs() are open at a time and measured in turns, if they are of one
    /// scene.
    virtual std::size_t together() const { return 4; }
    /// Sets a job up: builds graphs, executes once.
    virtual std::unique_ptr<Subject> open(const Job& job) = 0;
    /// What the page shows: plots, tables and pictures of all that is kept. `points` are those of
    /// jobs(), in their order.
    virtual Section report(const Store& store, const std::vector<Point>& points) = 0;
};

/// Measures what is not kept yet, with a line of progress. False: interrupted.
bool run_suites(const std::vector<std::unique_ptr<Suite>>& suites, Context& context, Store& store);

} // namespace ockham::chart
