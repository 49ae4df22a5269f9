// SPDX-License-Identifier: Apache-2.0
#include "samples/chart/aa_choice.hpp"

#include "framework/core/error.hpp"
#include "framework/core/json_object.hpp"
#include "samples/chart/falling_curve.hpp"

#include <algorithm>
#include <cmath>

namespace ockham {

extern const char* const kAaChart; ///< aa_chart.json

namespace {

constexpr double kLargest = 1e9;

AaChart parse(const nlohmann::json& json, const std::string& file) {
    const JsonObject root(json, "chart of anti-aliasing", file);
    AaChart chart;
    chart.m = static_cast<std::uint32_t>(root.number("m", 2, 8, "a window width"));
    chart.device = root.text("device");
    for (const JsonObject& one : root.objects("classes")) {
        AaClass scenes{.name = one.text("name"), .entries = {}};
        for (const JsonObject& entry : one.objects("entries")) {
            scenes.entries.push_back({entry.number("lambda", 1e-12, 1, "a price above 0"),
                entry.number("samples_percent", 1e-3, 100, "a share of all samples"),
                entry.number("psnr", 0, 999, "decibels"),
                entry.number("total_gpu_ms", 1e-9, kLargest, "milliseconds")});
        }
        const auto by_lambda = [](const auto& a, const auto& b) { return a.lambda < b.lambda; };
        std::sort(scenes.entries.begin(), scenes.entries.end(), by_lambda);
        if (scenes.entries.size() < 2) one.refuse("entries", "at least two");
        chart.classes.push_back(std::move(scenes));
    }
    if (chart.classes.empty()) root.refuse("classes", "at least one");
    return chart;
}

/// One quantity over lambda.
FallingCurve falling(const AaClass& scenes, double AaClass::Entry::*value) {
    std::vector<double> lambdas, values;
    for (const AaClass::Entry& entry : scenes.entries) {
        lambdas.push_back(entry.lambda);
        values.push_back(entry.*value);
    }
    return {lambdas, std::move(values)};
}

} // namespace

AaChart load_aa_chart(const std::filesystem::path& path) {
    return parse(parse_json(path, "chart of anti-aliasing"), path.string());
}

AaChart builtin_aa_chart() { return parse(nlohmann::json::parse(kAaChart), "built-in chart"); }

std::string to_json(const AaChart& chart) {
    nlohmann::ordered_json json{{"m", chart.m}, {"device", chart.device}};
    json["classes"] = nlohmann::ordered_json::array();
    for (const AaClass& scenes : chart.classes) {
        nlohmann::ordered_json entries = nlohmann::ordered_json::array();
        for (const AaClass::Entry& entry : scenes.entries) {
            entries.push_back({{"lambda", entry.lambda}, {"samples_percent", entry.samples_percent},
                {"psnr", entry.psnr}, {"total_gpu_ms", entry.total_gpu_ms}});
        }
        json["classes"].push_back({{"name", scenes.name}, {"entries", entries}});
    }
    return json.dump(1) + "\n";
}

const AaClass& class_of(const AaChart& chart, const AaProbe& probe) {
    check(!chart.classes.empty() && probe.samples_percent > 0, "classes and a probe");
    const auto distance = [&](const AaClass& scenes) {
        const double share = falling(scenes, &AaClass::Entry::samples_percent).at(probe.lambda);
        return std::abs(std::log(share / probe.samples_percent));
    };
    return *std::min_element(chart.classes.begin(), chart.classes.end(),
        [&](const AaClass& a, const AaClass& b) { return distance(a) < distance(b); });
}

AaChoice predict(const AaClass& scenes, const AaProbe& probe, double lambda) {
    const FallingCurve ms = falling(scenes, &AaClass::Entry::total_gpu_ms);
    return {.class_name = scenes.name,
        .lambda = lambda,
        .psnr = falling(scenes, &AaClass::Entry::psnr).at(lambda),
        .total_gpu_ms = probe.total_gpu_ms * ms.at(lambda) / ms.at(probe.lambda)};
}

AaChoice choose_by_psnr(const AaChart& chart, const AaProbe& probe, double decibels) {
    const AaClass& scenes = class_of(chart, probe);
    const FallingCurve psnr = falling(scenes, &AaClass::Entry::psnr);
    AaChoice choice = predict(scenes, probe, psnr.last_at_least(decibels));
    choice.reached = psnr.most() >= decibels;
    return choice;
}

AaChoice choose_by_time(const AaChart& chart, const AaProbe& probe, double milliseconds) {
    const AaClass& scenes = class_of(chart, probe);
    const FallingCurve ms = falling(scenes, &AaClass::Entry::total_gpu_ms);
    const double scale = ms.at(probe.lambda) / probe.total_gpu_ms;
    AaChoice choice = predict(scenes, probe, ms.first_at_most(milliseconds * scale));
    choice.reached = ms.least() <= milliseconds * scale;
    return choice;
}

} // namespace ockham
