// SPDX-License-Identifier: Apache-2.0
// What a run leaves behind besides its picture: statistics, plans, captures. Shared by all samples.
#pragma once

#include "framework/graph/compile.hpp"
#include "framework/image_error/image_error.hpp"
#include "framework/runtime/executor.hpp"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ockham {

/// GPU times of several executions of one plan.
class FrameTimes {
public:
    void add(const std::vector<PassTime>& frame);
    std::size_t frames() const { return totals_.size(); }
    /// Median over frames of the sum of all passes, and of those that `counts` accepts. ms.
    double total() const { return median(totals_); }
    double total_of(bool (*counts)(std::string_view pass)) const;
    /// {pass: {min, median, max}}, ms, in order of execution.
    nlohmann::ordered_json to_json() const;
    /// Median over the frames that executed it, of each step of the plan, ms; NaN for a pass that
    /// all of them skipped. Empty where there are no frames.
    std::vector<double> medians() const;
    /// The frames one after the other as Chrome's trace events, for chrome://tracing or Perfetto: a
    /// lane for each queue of the plan that was timed, arrows for its waits, reasons and barriers
    /// as arguments. Where the plan has several queues, starts follow from durations and waits.
    nlohmann::ordered_json to_trace(const Declaration& declaration, const Plan& plan) const;

private:
    static double median(std::vector<double> values);
    std::vector<std::string> passes_;
    std::vector<std::vector<double>> times_; ///< [pass][frame]
    std::vector<std::vector<bool>> skipped_; ///< [pass][frame]
    std::vector<double> totals_;
};

/// device, driver, commit, frames, gpu_ms, total_gpu_ms, plan{...}: the keys of --stats that do not
/// depend on the technique.
nlohmann::ordered_json statistics(
    const gpu::Device& device, const Plan& plan, const FrameTimes& times);
/// image{mse, psnr, ssim, flip, relmse, max, p99, hdr_flip?}; an infinite PSNR is written 999.
nlohmann::ordered_json to_json(const ImageError& error);

/// The command line as one would type it.
std::string command_text(int argc, char** argv);

/// Writes the plan in the format of the file's extension: .txt, .json, .dot or .html. A .json says
/// what it was compiled with, a .html shows the times if there are any.
void write_plan(const std::filesystem::path& path, const Declaration& declaration, const Plan& plan,
    const Capabilities& capabilities = {}, const Policy& policy = {}, const FrameTimes& times = {});
/// Throws Error(input) unless the extension is one that write_plan knows.
void check_plan_path(const std::filesystem::path& path);

/// .exr: the values; .png: colours as they are for colour images, else false colour over the range
/// of the first channel's finite values.
void write_capture(const std::filesystem::path& path, const Image& image);

} // namespace ockham
