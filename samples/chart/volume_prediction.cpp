// SPDX-License-Identifier: Apache-2.0
#include "samples/chart/volume_prediction.hpp"

#include "samples/chart/prediction.hpp"

#include <fmt/format.h>

namespace ockham::chart {
namespace {

std::string setting_of(const VolumeChoice& choice) {
    return fmt::format(
        "{}, {:.0f} steps, by {}", name_of(choice.technique), choice.steps, choice.class_name);
}

} // namespace

VolumeChart volume_chart_of(const std::vector<Point>& points,
    const std::vector<VolumeScene>& scenes, const std::string& device) {
    VolumeChart chart{.device = device, .classes = {}};
    for (const VolumeScene& scene : scenes) {
        VolumeClass measured{
            .name = scene.name, .features = features_of(scene.load()), .curves = {}};
        bool probed = false;
        for (const VolumeTechnique& technique : kVolumeTechniques) {
            VolumeClass::Curve curve{.technique = technique, .entries = {}};
            for (const Point& point : points) {
                if (point.job->scene != scene.name || point.job->series != name_of(technique) ||
                    !point.has("true_psnr"))
                    continue;
                curve.entries.push_back(
                    {point.knob, 1e3 * point["gpu_seconds"].median, point["true_psnr"].median});
            }
            // A repeat that was slower has fewer rows: medians of the last ones may fall back.
            const auto& e = curve.entries;
            while (e.size() > 1 && e.back().gpu_ms <= e[e.size() - 2].gpu_ms)
                curve.entries.pop_back();
            if (e.size() < 2) continue;
            probed |= technique == kVolumeTechniques[0] && e.back().steps >= kProbeSteps;
            measured.curves.push_back(std::move(curve));
        }
        if (probed) chart.classes.push_back(std::move(measured));
    }
    return chart;
}

std::vector<Plot> volume_prediction_plots(const VolumeChart& measured) {
    Plot by_psnr{.name = "volume_choice_psnr",
        .question = "Does volume_gi --target-psnr give what was asked for?",
        .x = {"asked_psnr", "PSNR asked for (dB)"},
        .y = {"psnr", "PSNR obtained (dB)"},
        .caption =
            "Technique and steps are chosen by the curves of the class whose features are "
            "nearest, after a probe of eight paths per pixel; the scene itself is left out."};
    Plot by_time{.name = "volume_choice_ms",
        .question = "Does volume_gi --target-ms give what was asked for?",
        .x = {"asked_ms", "GPU time asked for (ms)", true},
        .y = {"ms", "GPU time obtained (ms)", true},
        .caption = "Likewise."};
    for (const VolumeClass& own : measured.classes) {
        VolumeChart others = builtin_volume_chart();
        std::erase_if(others.classes, [&](const VolumeClass& c) { return c.name == own.name; });
        if (others.classes.empty()) continue;
        const VolumeProbe probe = probe_of(own);
        // What a choice gets, read off the scene's own curves, as far as they reach.
        const auto add = [&](Curve& curve, double asked, const VolumeChoice& choice,
                             double VolumeChoice::*value) {
            for (const VolumeClass::Curve& known : own.curves) {
                if (known.technique != choice.technique || !choice.reached ||
                    choice.steps > known.entries.back().steps)
                    continue;
                const VolumeChoice got = predict(own, probe, choice.technique, choice.steps);
                curve.points.push_back(obtained(asked, got.*value, setting_of(choice)));
            }
        };
        Curve psnr{.legend = own.name}, time{.legend = own.name};
        for (double asked = 20; asked <= 46; asked += 2)
            add(psnr, asked, choose_by_psnr(others, probe, asked), &VolumeChoice::psnr);
        for (double times = 0.5; times < 40; times *= 1.5)
            add(time, times * probe.gpu_ms, choose_by_time(others, probe, times * probe.gpu_ms),
                &VolumeChoice::gpu_ms);
        by_psnr.curves.push_back(std::move(psnr));
        by_time.curves.push_back(std::move(time));
    }
    if (by_psnr.curves.empty()) return {};
    by_psnr.curves.push_back(as_asked(by_psnr));
    by_time.curves.push_back(as_asked(by_time));
    return {by_psnr, by_time};
}

} // namespace ockham::chart
