// SPDX-License-Identifier: Apache-2.0
#include "samples/chart/aa_sweep.hpp"

#include "framework/image_error/flip.hpp"
#include "framework/image_error/image_error.hpp"
#include "framework/image_error/mse.hpp"
#include "framework/image_error/ssim.hpp"

#include <fmt/format.h>

#include <cmath>
#include <memory>

namespace ockham {
namespace {

/// Graphs alive at a time beside the reference's: each holds a G-buffer.
constexpr std::size_t kTogether = 3;

AaSetting fixed(const char* name, AaMethod method, const AdaptiveAaParams& base) {
    AaSetting setting{.method = name, .params = base};
    setting.params.method = method;
    return setting;
}

} // namespace

std::vector<AaSetting> aa_settings(const AdaptiveAaParams& base, AaKnobs knobs) {
    const std::uint32_t n = base.m * base.m;
    if (knobs.counts.empty())
        for (std::uint32_t k = 1; k < n; ++k) knobs.counts.push_back(k);
    if (knobs.lambdas.empty())
        for (double l = 1e-6; l < 0.02; l *= std::sqrt(10.0)) knobs.lambdas.push_back(l);
    std::vector<AaSetting> settings{fixed("none", AaMethod::none, base),
        fixed("fxaa", AaMethod::fxaa, base), fixed("smaa", AaMethod::smaa, base),
        fixed("sraa", AaMethod::sraa, base), fixed("msaa", AaMethod::msaa, base),
        fixed("cluster", AaMethod::cluster, base)};
    for (const std::uint32_t k : knobs.counts) {
        AaSetting setting = fixed("uniform", AaMethod::uniform, base);
        setting.knob = setting.params.k = k;
        settings.push_back(setting);
    }
    for (const double scale : knobs.scales) {
        AaSetting setting = fixed("paper", AaMethod::adaptive, base);
        setting.knob = scale;
        setting.params.metrics = default_metrics(base.m);
        setting.params.order_kind = SampleOrder::paper;
        setting.params.resolve = Resolve::prefix;
        for (float* weight : {&setting.params.metrics.depth_weight,
                 &setting.params.metrics.normal_weight, &setting.params.metrics.shading_weight}) {
            *weight *= static_cast<float>(scale);
        }
        settings.push_back(setting);
    }
    for (const double lambda : knobs.lambdas) {
        AaSetting setting = fixed("ockham", AaMethod::adaptive, base);
        setting.knob = lambda;
        setting.params.metric = MetricKind::ockham;
        setting.params.filter_highlights = base.resolve == Resolve::stratified;
        setting.params.lambda = static_cast<float>(lambda);
        settings.push_back(setting);
    }
    settings.push_back(fixed("ssaa", AaMethod::ssaa, base));
    return settings;
}

AaPoint judge_aa(const AaSetting& setting, AdaptiveAa& aa, const Image& picture,
    const Image& reference, std::uint32_t m) {
    const Image shown = displayed(picture), expected = displayed(reference);
    AaPoint point{.method = setting.method, .knob = setting.knob, .m = m};
    point.samples_percent = 100.0 * aa.sample_counts().mean / (m * m);
    point.mse = mse(shown, expected);
    point.psnr = psnr(point.mse);
    point.ssim = ssim_luma(shown, expected);
    point.flip = flip(picture, reference).mean;
    return point;
}

Image all_samples(
    gpu::Device& device, const LitScene& scene, const Camera& camera, AdaptiveAaParams params) {
    params.width *= params.m;
    params.height *= params.m;
    params.method = AaMethod::none;
    AdaptiveAa aa(device, scene, camera, params);
    aa.execute();
    return aa.picture();
}

AaSweep::AaSweep(gpu::Device& device, const LitScene& scene, const Camera& camera,
    const AdaptiveAaParams& base, int repeats)
    : device_(device), scene_(scene), camera_(camera),
      reference_params_(fixed("ssaa", AaMethod::ssaa, base).params), repeats_(repeats) {
    AdaptiveAa aa(device_, scene_, camera_, reference_params_);
    aa.execute();
    reference_ = aa.picture();
}

void AaSweep::measure(const std::vector<AaSetting>& settings,
    const std::function<bool(const AaSetting&, const AaPoint&, const Image&)>& visit) {
    for (std::size_t first = 0; first < settings.size(); first += kTogether) {
        const std::size_t last = std::min(first + kTogether, settings.size());
        std::vector<std::unique_ptr<AdaptiveAa>> pictures; // the reference last
        for (std::size_t i = first; i <= last; ++i) {
            AdaptiveAaParams params = i < last ? settings[i].params : reference_params_;
            params.export_counts = true;
            pictures.push_back(std::make_unique<AdaptiveAa>(device_, scene_, camera_, params));
            pictures.back()->execute();
        }
        std::vector<FrameTimes> times(pictures.size());
        for (int repeat = 0; repeat < repeats_; ++repeat) {
            for (std::size_t i = 0; i < pictures.size(); ++i) {
                pictures[i]->execute();
                times[i].add(pictures[i]->executor().times());
            }
        }
        for (std::size_t i = first; i < last; ++i) {
            AdaptiveAa& aa = *pictures[i - first];
            const Image picture = aa.picture();
            AaPoint point = judge_aa(settings[i], aa, picture, reference_, reference_params_.m);
            point.shading_gpu_ms = times[i - first].total_of(is_shading_pass);
            point.total_gpu_ms = times[i - first].total();
            point.reference_shading_gpu_ms = times.back().total_of(is_shading_pass);
            point.reference_total_gpu_ms = times.back().total();
            if (!visit(settings[i], point, picture)) return;
        }
    }
}

std::string aa_csv(const std::vector<AaPoint>& points) {
    std::string text = "method,knob,m,samples_percent,shading_gpu_ms,total_gpu_ms,mse,psnr,ssim,"
                       "flip,reference_shading_gpu_ms,reference_total_gpu_ms\n";
    const auto number = [](double value) {
        return std::isnan(value) ? "" : fmt::format("{:.6g}", value);
    };
    for (const AaPoint& p : points) {
        const double decibels = std::isinf(p.psnr) ? 999.0 : p.psnr;
        text += fmt::format("{},{:.6g},{},{:.4f},{},{},{:.6g},{:.3f},{},{},{},{}\n", p.method,
            p.knob, p.m, p.samples_percent, number(p.shading_gpu_ms), number(p.total_gpu_ms), p.mse,
            decibels, number(p.ssim), number(p.flip), number(p.reference_shading_gpu_ms),
            number(p.reference_total_gpu_ms));
    }
    return text;
}

} // namespace ockham
