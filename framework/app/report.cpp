// SPDX-License-Identifier: Apache-2.0
#include "framework/app/report.hpp"

#include "framework/core/error.hpp"
#include "framework/core/false_color.hpp"
#include "framework/core/file.hpp"
#include "framework/core/version.hpp"
#include "framework/gpu/device.hpp"
#include "framework/graph/dump.hpp"
#include "framework/io/image_file.hpp"

#include <algorithm>
#include <cmath>

namespace ockham {

void FrameTimes::add(const std::vector<PassTime>& frame) {
    if (passes_.empty()) {
        for (const PassTime& time : frame) passes_.push_back(time.pass);
        times_.resize(passes_.size());
    }
    check(frame.size() == passes_.size(), "every frame executes the same plan");
    double total = 0;
    for (std::size_t i = 0; i < frame.size(); ++i) {
        times_[i].push_back(frame[i].milliseconds);
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

nlohmann::ordered_json FrameTimes::to_trace() const {
    nlohmann::ordered_json events = nlohmann::ordered_json::array();
    double start_us = 0;
    for (std::size_t frame = 0; frame < frames(); ++frame) {
        for (std::size_t i = 0; i < passes_.size(); ++i) {
            const double duration_us = 1e3 * times_[i][frame];
            events.push_back({{"name", passes_[i]}, {"ph", "X"}, {"ts", start_us},
                {"dur", duration_us}, {"pid", 0}, {"tid", 0}, {"args", {{"frame", frame}}}});
            start_us += duration_us;
        }
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
    if (extension != ".txt" && extension != ".json" && extension != ".dot") {
        fail_input(
            "--plan: found '{}', expected a file ending in .txt, .json or .dot", path.string());
    }
}

void write_plan(
    const std::filesystem::path& path, const Declaration& declaration, const Plan& plan) {
    check_plan_path(path);
    const std::string extension = path.extension().string();
    write_text(path, extension == ".txt"   ? plan_text(declaration, plan)
                     : extension == ".dot" ? plan_dot(declaration, plan)
                                           : plan_json(declaration, plan).dump(2) + "\n");
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
