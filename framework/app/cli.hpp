// SPDX-License-Identifier: Apache-2.0
// The command line that all samples share: common flags, run files, help from the parameters'
// declarations, errors to exit codes. Knows no technique; samples add their own parameters.
#pragma once

#include "framework/core/params.hpp"
#include "framework/gpu/device.hpp"
#include "framework/scene/scene.hpp"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace ockham {

/// What every sample can be told (docs/cli.md).
struct CommonOptions {
    std::string output;
    int width = 1024, height = 768;
    std::string camera;
    float orthographic = 0;
    float exposure = 0;
    std::string tonemap = "none";
    int memory_budget = 0;
    bool strict = false;
    bool allow_external = false;
    std::string gpu;
    bool list_gpus = false;
    std::string validation = "off";
    std::string shader_dir;
    std::string stats;
    std::string trace;
    std::string plan;
    bool explain = false;
    std::vector<std::string> captures;
    std::string reference;
    std::string config;
    std::string dump_config;
    int frames = 1;
    bool quiet = false;
    bool version = false;
};

/// Declare the common flags on `params`; `options` must outlive it. A program declares those that
/// it heeds: how to run, what to look at, what to write.
void add_run_flags(Params& params, CommonOptions& options);
void add_view_flags(Params& params, CommonOptions& options);
void add_output_flags(Params& params, CommonOptions& options);
void add_frames_flag(Params& params, CommonOptions& options);

/// Reads argv, then the run file of --config. An exit code if that was all there is to do (--help,
/// --version, --list-gpus, --dump-config). Throws Error(input) naming the flag.
std::optional<int> parse_command_line(
    int argc, char** argv, const std::string& description, Params& params, CommonOptions& options);

/// Runs a program's body: its return value, or the exit code of what it throws, printed once.
/// SIGINT sets interrupted() instead of ending the process; a second one ends it.
int run_program(const std::function<int()>& body);
bool interrupted();

gpu::DeviceOptions device_options(const CommonOptions& options);
/// With --shader-dir: takes shaders from there, or throws Error(input) where there is no such
/// folder. Call it once, before anything is executed.
void watch_shaders(gpu::Device& device, const CommonOptions& options);
/// Takes up what has changed in --shader-dir since; call it between executions. Errors in shaders
/// are logged, and those before stay in use.
void reload_shaders(gpu::Device& device);
/// Throws Error(device) with the first message if validation found anything so far.
void expect_no_validation_messages(const gpu::Device& device);

/// The numbers of "1,2,3"; none where any of them is not one.
std::vector<float> parse_numbers(const std::string& text, char separator = ',');
/// "r,g,b", each finite and at least 0. Throws Error(input) naming the flag.
glm::vec3 parse_color(const std::string& flag, const std::string& text);

/// "px,py,pz tx,ty,tz fov"; nothing where the text has another form. Throws Error(input) where it
/// has that form and no camera can look so.
std::optional<Camera> parse_camera(const std::string& text, UpAxis up);
/// The camera that --camera and --orthographic ask for: "px,py,pz tx,ty,tz fov", a camera's name,
/// or by default the scene's first, else one that sees everything.
Camera choose_camera(const CommonOptions& options, const Scene& scene, const Bounds& bounds);

/// Every NAME=FILE of --capture, checked. Throws Error(input) naming the text.
std::vector<std::pair<std::string, std::string>> parse_captures(const CommonOptions& options);

/// A line on a terminal that is overwritten as work goes on; silent elsewhere and with --quiet.
class Progress {
public:
    Progress(std::string what, std::size_t steps, bool quiet);
    ~Progress();
    /// `done` of the steps are finished; prints percentage and remaining seconds.
    void update(std::size_t done);

private:
    std::string what_;
    std::size_t steps_;
    bool active_;
    double start_;
};

} // namespace ockham
