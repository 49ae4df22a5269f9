// SPDX-License-Identifier: Apache-2.0
#include "samples/chart/volume_choice.hpp"

#include "framework/core/error.hpp"
#include "framework/core/json_object.hpp"
#include "samples/chart/falling_curve.hpp"

#include <algorithm>
#include <cmath>

namespace ockham {

extern const char* const kVolumeChart; ///< volume_chart.json

namespace {

constexpr double kLargest = 1e12;
constexpr int kFeatureSide = 24; ///< points along each side of the box that features look at

std::optional<VolumeTechnique> technique_of(const std::string& name) {
    for (const VolumeTechnique& technique : kVolumeTechniques)
        if (name_of(technique) == name) return technique;
    return std::nullopt;
}

VolumeClass parse_class(const JsonObject& json) {
    VolumeClass scenes{.name = json.text("name"), .features = {}, .curves = {}};
    scenes.features = {.surface = json.boolean("surface", false),
        .sun = json.boolean("sun", false),
        .optical_depth = json.number("optical_depth", 0, kLargest, "an optical depth"),
        .albedo = json.number("albedo", 0, 1, "an albedo")};
    for (const JsonObject& one : json.objects("curves")) {
        const std::optional<VolumeTechnique> technique = technique_of(one.text("technique"));
        if (!technique) one.refuse("technique", "a technique, such as 'path'");
        VolumeClass::Curve curve{.technique = *technique, .entries = {}};
        for (const JsonObject& entry : one.objects("entries")) {
            curve.entries.push_back({entry.number("steps", 1, kLargest, "a number of steps"),
                entry.number("gpu_ms", 1e-9, kLargest, "milliseconds"),
                entry.number("psnr", 0, 999, "decibels")});
        }
        const auto rises = [](const auto& a, const auto& b) {
            return a.steps >= b.steps || a.gpu_ms >= b.gpu_ms;
        };
        if (curve.entries.size() < 2 || std::adjacent_find(curve.entries.begin(),
                                            curve.entries.end(), rises) != curve.entries.end())
            one.refuse("entries", "two or more, by rising steps and time");
        scenes.curves.push_back(std::move(curve));
    }
    const bool probed = std::any_of(scenes.curves.begin(), scenes.curves.end(), [](const auto& c) {
        return c.technique.mode == VolumeMode::path && c.entries.back().steps >= kProbeSteps;
    });
    if (!probed) json.refuse("curves", "one of path, which reaches the steps of a probe");
    return scenes;
}

VolumeChart parse(const nlohmann::json& json, const std::string& file) {
    const JsonObject root(json, "chart of volumes", file);
    VolumeChart chart{.device = root.text("device"), .classes = {}};
    for (const JsonObject& one : root.objects("classes")) chart.classes.push_back(parse_class(one));
    if (chart.classes.empty()) root.refuse("classes", "at least one");
    return chart;
}

/// A quantity over entries/millisecond or entries/step: both fall with that price.
FallingCurve over(const VolumeClass::Curve& curve, double VolumeClass::Entry::*cost,
    double VolumeClass::Entry::*value) {
    std::vector<double> prices, values;
    for (auto entry = curve.entries.rbegin(); entry != curve.entries.rend(); ++entry) {
        prices.push_back(1 / ((*entry).*cost));
        values.push_back((*entry).*value);
    }
    return {prices, std::move(values)};
}

const VolumeClass::Curve& curve_of(const VolumeClass& scenes, const VolumeTechnique& technique) {
    const auto found = std::find_if(scenes.curves.begin(), scenes.curves.end(),
        [&](const VolumeClass::Curve& curve) { return curve.technique == technique; });
    check(found != scenes.curves.end(), "a curve of that technique");
    return *found;
}

/// Small where scenes behave alike. Weights are a guess: which transport comes first, then how
/// often light scatters.
double distance(const VolumeFeatures& a, const VolumeFeatures& b) {
    return (a.surface != b.surface ? 10 : 0) + (a.sun != b.sun ? 1 : 0) +
           std::abs(std::log((a.optical_depth + 0.1) / (b.optical_depth + 0.1))) +
           3 * std::abs(a.albedo - b.albedo);
}

/// How many times as long, and how many decibels better, than the class.
struct Proportion {
    double time, decibels;
};
Proportion proportion(const VolumeClass& scenes, const VolumeProbe& probe) {
    const VolumeProbe own = probe_of(scenes);
    return {probe.gpu_ms / own.gpu_ms, probe.psnr - own.psnr};
}

} // namespace

VolumeFeatures features_of(const VolumeSource& source) {
    const VolumeView& view = source.view;
    double opacity = 0, scattered = 0;
    const auto unit = [](float low, float high, int i) {
        return std::lerp(double{low}, double{high}, (i + 0.5) / kFeatureSide);
    };
    for (int z = 0; z < kFeatureSide; ++z)
        for (int y = 0; y < kFeatureSide; ++y)
            for (int x = 0; x < kFeatureSide; ++x) {
                const glm::dvec3 place(unit(view.crop_min.x, view.crop_max.x, x),
                    unit(view.crop_min.y, view.crop_max.y, y),
                    unit(view.crop_min.z, view.crop_max.z, z));
                const TransferPoint point = source.transfer.at(source.volume.sample(place));
                opacity += point.opacity;
                scattered += point.opacity * (point.color.x + point.color.y + point.color.z) / 3;
            }
    const glm::dvec3 extent = glm::dvec3(source.volume.dims) * source.volume.spacing_mm *
                              place_of(source.volume).world_per_mm *
                              glm::dvec3(view.crop_max - view.crop_min);
    const double mean_opacity = opacity / (kFeatureSide * kFeatureSide * kFeatureSide);
    return {.surface = !view.surfaces.empty(),
        .sun = glm::length(view.light_irradiance) > 0,
        .optical_depth =
            mean_opacity * double{view.density_scale} * (extent.x + extent.y + extent.z) / 3,
        .albedo = opacity > 0 ? double{view.albedo} * scattered / opacity : 0};
}

std::string name_of(const VolumeTechnique& technique) {
    if (technique.mode != VolumeMode::caching) return name_of(technique.mode);
    return technique.gather ? "gathered cache" : "composed cache";
}

VolumeChart load_volume_chart(const std::filesystem::path& path) {
    return parse(parse_json(path, "chart of volumes"), path.string());
}

VolumeChart builtin_volume_chart() {
    return parse(nlohmann::json::parse(kVolumeChart), "built-in chart");
}

std::string to_json(const VolumeChart& chart) {
    nlohmann::ordered_json json{{"device", chart.device}};
    json["classes"] = nlohmann::ordered_json::array();
    for (const VolumeClass& scenes : chart.classes) {
        nlohmann::ordered_json curves = nlohmann::ordered_json::array();
        for (const VolumeClass::Curve& curve : scenes.curves) {
            nlohmann::ordered_json entries = nlohmann::ordered_json::array();
            for (const VolumeClass::Entry& entry : curve.entries)
                entries.push_back(
                    {{"steps", entry.steps}, {"gpu_ms", entry.gpu_ms}, {"psnr", entry.psnr}});
            curves.push_back({{"technique", name_of(curve.technique)}, {"entries", entries}});
        }
        json["classes"].push_back({{"name", scenes.name}, {"surface", scenes.features.surface},
            {"sun", scenes.features.sun}, {"optical_depth", scenes.features.optical_depth},
            {"albedo", scenes.features.albedo}, {"curves", curves}});
    }
    return json.dump(1) + "\n";
}

VolumeProbe probe_of(const VolumeClass& scenes) {
    const VolumeClass::Curve& path = curve_of(scenes, kVolumeTechniques[0]);
    using Entry = VolumeClass::Entry;
    return {scenes.features,
        1 / over(path, &Entry::gpu_ms, &Entry::steps).last_at_least(kProbeSteps),
        over(path, &Entry::steps, &Entry::psnr).at(1.0 / kProbeSteps)};
}

const VolumeClass& class_of(const VolumeChart& chart, const VolumeFeatures& features) {
    check(!chart.classes.empty(), "classes");
    return *std::min_element(chart.classes.begin(), chart.classes.end(),
        [&](const VolumeClass& a, const VolumeClass& b) {
            return distance(a.features, features) < distance(b.features, features);
        });
}

VolumeChoice predict(const VolumeClass& scenes, const VolumeProbe& probe,
    const VolumeTechnique& technique, double steps) {
    using Entry = VolumeClass::Entry;
    const Proportion to_class = proportion(scenes, probe);
    const VolumeClass::Curve& curve = curve_of(scenes, technique);
    return {.class_name = scenes.name,
        .technique = technique,
        .steps = steps,
        .psnr = over(curve, &Entry::steps, &Entry::psnr).at(1 / steps) + to_class.decibels,
        .gpu_ms = to_class.time / over(curve, &Entry::gpu_ms, &Entry::steps).last_at_least(steps)};
}

VolumeChoice choose_by_psnr(const VolumeChart& chart, const VolumeProbe& probe, double decibels) {
    using Entry = VolumeClass::Entry;
    const VolumeClass& scenes = class_of(chart, probe.features);
    const double wanted = decibels - proportion(scenes, probe).decibels;
    std::optional<VolumeChoice> best;
    for (const VolumeClass::Curve& curve : scenes.curves) {
        const FallingCurve psnr = over(curve, &Entry::steps, &Entry::psnr);
        VolumeChoice choice = predict(
            scenes, probe, curve.technique, std::ceil(1 / psnr.last_at_least(wanted) - 1e-6));
        choice.reached = psnr.most() >= wanted;
        const bool sooner =
            best && choice.reached == best->reached &&
            (choice.reached ? choice.gpu_ms < best->gpu_ms : choice.psnr > best->psnr);
        if (!best || (choice.reached && !best->reached) || sooner) best = choice;
    }
    return *best;
}

VolumeChoice choose_by_time(
    const VolumeChart& chart, const VolumeProbe& probe, double milliseconds) {
    using Entry = VolumeClass::Entry;
    const VolumeClass& scenes = class_of(chart, probe.features);
    const double price = proportion(scenes, probe).time / milliseconds; // of the class's time
    std::optional<VolumeChoice> best;
    for (const VolumeClass::Curve& curve : scenes.curves) {
        const FallingCurve steps = over(curve, &Entry::gpu_ms, &Entry::steps);
        VolumeChoice choice = predict(
            scenes, probe, curve.technique, std::max(1.0, std::floor(steps.at(price) + 1e-6)));
        choice.reached = curve.entries.front().gpu_ms * price <= 1;
        if (!best || (choice.reached && !best->reached) ||
            (choice.reached == best->reached && choice.psnr > best->psnr))
            best = choice;
    }
    return *best;
}

} // namespace ockham
