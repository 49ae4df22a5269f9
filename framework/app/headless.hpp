// SPDX-License-Identifier: Apache-2.0
// A run without a window: what every sample does before, around and after the executions of its
// graph. Outputs are checked first; pictures, captures, plan, trace and statistics are written as
// CommonOptions asks. Knows no technique.
#pragma once

#include "framework/app/cli.hpp"
#include "framework/app/report.hpp"
#include "framework/core/timer.hpp"

#include <optional>
#include <string>
#include <vector>

namespace ockham {

class HeadlessRun {
public:
    /// Checks every output and loads --reference, before anything costs time. `more`: files that
    /// the program writes beside the common ones; empty names are none. `options` must outlive
    /// this object. Throws Error(input) naming flag or file.
    HeadlessRun(const CommonOptions& options, int argc, char** argv,
        const std::vector<std::string>& more = {});

    /// --plan, without times, and --explain: before the first execution, so that they are there
    /// also where it fails.
    void announce(const gpu::Device& device, const Executor& executor) const;
    /// Takes the GPU times of the execution that was just waited for.
    void add_times(const Executor& executor) { times_.add(executor.times()); }
    void add_times(const std::vector<PassTime>& times) { times_.add(times); }
    const FrameTimes& times() const { return times_; }

    const std::string& command() const { return command_; }
    /// --reference; nothing without one. `frame`: the number that stands for %04d in its name.
    std::optional<Image> reference(int frame = 0) const;
    /// Against it.
    std::optional<ImageError> error_of(const Image& picture, int frame = 0) const;
    /// Writes -o, where it was asked for, with what made it in the metadata. `frame`: the number
    /// that stands for %04d in the name.
    void save_picture(Image picture, int frame = 0) const;
    /// Writes --capture; `images` in the order of parse_captures().
    void save_captures(Executor& executor, const std::vector<ImageHandle>& images) const;
    /// Writes --plan with times, --trace, and --stats: the keys that do not depend on the
    /// technique, then those of `more`, then the error. Throws Error(device) after any validation
    /// message.
    void report(const gpu::Device& device, const Executor& executor,
        const nlohmann::ordered_json& more, const std::optional<ImageError>& error) const;

private:
    void write_plan_file(
        const gpu::Device& device, const Executor& executor, const FrameTimes& times) const;

    const CommonOptions& options_;
    std::string command_;
    Timer wall_;
    std::optional<Image> reference_; ///< where its name has no number
    FrameTimes times_;
};

/// "out%04d.png" and 7: "out0007.png"; a name without %0Nd or %d stays as it is.
std::string numbered(const std::string& name, int number);
bool is_numbered(const std::string& name);

/// One line for people: all metrics.
void print_error(const ImageError& error);

} // namespace ockham
