// SPDX-License-Identifier: Apache-2.0
#include "framework/app/report.hpp"

#include "framework/core/error.hpp"
#include "framework/core/false_color.hpp"
#include "framework/core/file.hpp"
#include "framework/core/version.hpp"
#include "framework/gpu/device.hpp"
#include "framework/graph/describe.hpp"
#include "framework/graph/explain/dump.hpp"
#include "framework/graph/explain/explain.hpp"
#include "framework/graph/explain/plan_page.hpp"
#include "framework/graph/explain/timeline.hpp"
#include "framework/io/image_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace ockham {

void FrameTimes::add(const std::vector<PassTime>& frame) {
    if (passes_.empty()) {
        for (const PassTime& time : frame) passes_.push_back(time.pass);
        times_.resize(passes_.size());
        skipped_.resize(passes_.size());
    }
    check(frame.size() == passes_.size(), "every frame executes the same plan");
    double total = 0;
    for (std::size_t i = 0; i < frame.size(); ++i) {
        times_[i].push_back(frame[i].milliseconds);
        skipped_[i].push_back(frame[i].skipped);
        total += frame[i].milliseconds;
    }
    totals_.push_back(total);
}

double FrameTimes::median(std::vector<double> values) {
    if (values.empty()) return 0;
    std::sort(values.begin(), values.end());
    const std::size_t middle = values.size() / 2;
    return values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

double FrameTimes::total_of(bool (*counts)(std::string_view pass)) const {
    std::vector<double> sums(totals_.size(), 0.0);
    for (std::size_t i = 0; i < passes_.size(); ++i) {
        if (!counts(passes_[i])) continue;
        for (std::size_t f = 0; f < sums.size(); ++f) sums[f] += times_[i][f];
    }
    return median(std::move(sums));
}

nlohmann::ordered_json FrameTimes::to_json() const {
    nlohmann::ordered_json json = nlohmann::ordered_json::object();
    for (std::size_t i = 0; i < passes_.size(); ++i) {
        const auto [low, high] = std::minmax_element(times_[i].begin(), times_[i].end());
        json[passes_[i]] = {{"min", *low}, {"median", median(times_[i])}, {"max", *high}};
    }
    return json;
}

std::vector<double> FrameTimes::medians() const {
    std::vector<double> medians;
    for (std::size_t i = 0; i < passes_.size(); ++i) {
        std::vector<double> executed;
        for (std::size_t frame = 0; frame < frames(); ++frame)
            if (!skipped_[i][frame]) executed.push_back(times_[i][frame]);
        medians.push_back(executed.empty() ? std::numeric_limits<double>::quiet_NaN()
                                           : median(std::move(executed)));
    }
    return medians;
}

namespace {

using nlohmann::ordered_json;

/// Names of the lanes: trace viewers show a process for the graph, a thread for each queue.
ordered_json lane_names(const Declaration& declaration, const Plan& plan) {
    ordered_json events = ordered_json::array();
    events.push_back({{"name", "process_name"}, {"ph", "M"}, {"pid", 0},
        {"args", {{"name", declaration.name}}}});
    for (std::uint32_t q = 0; q < plan.queues.size(); ++q)
        events.push_back({{"name", "thread_name"}, {"ph", "M"}, {"pid", 0}, {"tid", q},
            {"args",
                {{"name", fmt::format("{} (family {})", queue_text(q), plan.queues[q].family)}}}});
    return events;
}

/// What the viewer shows of a pass that is clicked; the same in every frame.
ordered_json pass_arguments(const Declaration& declaration, const Plan& plan, std::uint32_t step) {
    ordered_json barriers = ordered_json::array();
    for (const Barrier& barrier : plan.barriers_before(plan.steps[step]))
        barriers.push_back(reason_of_barrier(declaration, plan, barrier));
    return {{"step", step}, {"reason", reason_of_pass(declaration, plan, plan.steps[step].pass)},
        {"barriers", barriers}};
}

/// An arrow from the end of the awaited submission to the start of each that waits for it.
void add_arrows(const Plan& plan, const std::vector<double>& start,
    const std::vector<double>& duration, double from_us, ordered_json& events) {
    for (const Submission& submission : plan.submissions)
        for (std::uint32_t i = 0; i < submission.wait_count; ++i) {
            const Wait& wait = plan.waits[submission.first_wait + i];
            const std::uint32_t index = submission_of(plan, wait.queue, wait.value);
            if (index == kNone || submission.step_count == 0) continue;
            const Submission& awaited = plan.submissions[index];
            if (awaited.step_count == 0) continue;
            const std::uint32_t last = awaited.first_step + awaited.step_count - 1;
            const std::size_t id = events.size();
            events.push_back({{"name", "wait"}, {"cat", "wait"}, {"ph", "s"}, {"id", id},
                {"ts", from_us + start[last] + duration[last]}, {"pid", 0},
                {"tid", awaited.queue}});
            events.push_back({{"name", "wait"}, {"cat", "wait"}, {"ph", "f"}, {"bp", "e"},
                {"id", id}, {"ts", from_us + start[submission.first_step]}, {"pid", 0},
                {"tid", submission.queue}});
        }
}

} // namespace

nlohmann::ordered_json FrameTimes::to_trace(
    const Declaration& declaration, const Plan& plan) const {
    check(frames() == 0 || passes_.size() == plan.steps.size(), "the plan that was timed");
    ordered_json events = lane_names(declaration, plan);
    const std::vector<std::uint32_t> queues = queue_of_steps(plan);
    std::vector<ordered_json> arguments;
    for (std::uint32_t i = 0; i < plan.steps.size(); ++i)
        arguments.push_back(pass_arguments(declaration, plan, i));
    double frame_us = 0;
    for (std::size_t frame = 0; frame < frames(); ++frame) {
        std::vector<double> duration(passes_.size());
        for (std::size_t i = 0; i < passes_.size(); ++i) duration[i] = 1e3 * times_[i][frame];
        const std::vector<double> start = start_times(plan, duration);
        double end = 0;
        for (std::size_t i = 0; i < passes_.size(); ++i) {
            ordered_json args = arguments[i];
            args["frame"] = frame;
            if (skipped_[i][frame]) args["skipped"] = true;
            events.push_back({{"name", passes_[i] + (skipped_[i][frame] ? " (skipped)" : "")},
                {"cat", name_of(declaration.passes[plan.steps[i].pass].kind)}, {"ph", "X"},
                {"ts", frame_us + start[i]}, {"dur", duration[i]}, {"pid", 0}, {"tid", queues[i]},
                {"args", std::move(args)}});
            end = std::max(end, start[i] + duration[i]);
        }
        add_arrows(plan, start, duration, frame_us, events);
        frame_us += end;
    }
    return {{"traceEvents", events}, {"displayTimeUnit", "ms"}};
}

nlohmann::ordered_json statistics(
    const gpu::Device& device, const Plan& plan, const FrameTimes& times) {
    const auto culled = std::count_if(
        plan.passes.begin(), plan.passes.end(), [](const Verdict& pass) { return pass.culled; });
    return {{"device", device.info().name},
        {"driver", fmt::format("{} {}", device.info().driver, device.info().driver_version)},
        {"commit", commit()}, {"frames", times.frames()}, {"gpu_ms", times.to_json()},
        {"total_gpu_ms", times.total()},
        {"plan",
            {{"passes", plan.steps.size()}, {"culled", culled}, {"barriers", plan.barriers.size()},
                {"batches", plan.batches()}, {"bytes_peak", plan.bytes_peak},
                {"bytes_lower_bound", plan.bytes_lower_bound}, {"compile_us", plan.compile_us}}}};
}

nlohmann::ordered_json to_json(const ImageError& error) {
    nlohmann::ordered_json json{{"mse", error.mse},
        {"psnr", std::isinf(error.psnr) ? 999.0 : error.psnr}, {"ssim", error.ssim},
        {"flip", error.flip.mean}, {"relmse", error.relmse}, {"max", error.max},
        {"p99", error.p99}};
    if (error.hdr_flip) json["hdr_flip"] = error.hdr_flip->mean;
    if (error.non_finite > 0) json["non_finite"] = error.non_finite;
    return json;
}

std::string command_text(int argc, char** argv) {
    std::string text;
    for (int i = 0; i < argc; ++i) {
        const std::string word =
            i == 0 ? std::filesystem::path(argv[0]).filename().string() : argv[i];
        const bool plain =
            !word.empty() && word.find_first_of(" \t\"'$*;&|<>()\\") == std::string::npos;
        text += (i > 0 ? " " : "") + (plain ? word : "\"" + word + "\"");
    }
    return text;
}

void check_plan_path(const std::filesystem::path& path) {
    const std::string extension = path.extension().string();
    constexpr std::array<const char*, 4> known{".txt", ".json", ".dot", ".html"};
    if (std::ranges::find(known, extension) == known.end())
        fail_input("--plan: found '{}', expected a file ending in {}", path.string(),
            fmt::join(known, ", "));
}

void write_plan(const std::filesystem::path& path, const Declaration& declaration, const Plan& plan,
    const Capabilities& capabilities, const Policy& policy, const FrameTimes& times) {
    check_plan_path(path);
    const std::string extension = path.extension().string();
    if (extension == ".txt")
        write_text(path, plan_text(declaration, plan));
    else if (extension == ".dot")
        write_text(path, plan_dot(declaration, plan));
    else if (extension == ".html")
        write_text(path, plan_html(declaration, plan, times.medians()));
    else
        write_text(path, plan_json(declaration, plan, capabilities, policy)
                                 .dump(1, ' ', false, nlohmann::json::error_handler_t::replace) +
                             "\n");
}

void write_capture(const std::filesystem::path& path, const Image& image) {
    if (is_exr_path(path) || (image.find("R") && image.find("B"))) return save_image(path, image);
    const std::span<const float> values = image.plane(0);
    float low = std::numeric_limits<float>::infinity(), high = -low;
    for (const float value : values) {
        if (!std::isfinite(value)) continue;
        low = std::min(low, value);
        high = std::max(high, value);
    }
    if (!(low < high)) high = low + 1.0f;
    save_png_srgb(path, image.width(), image.height(), false_color(values, low, high));
}

} // namespace ockham
