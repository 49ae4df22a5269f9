// SPDX-License-Identifier: Apache-2.0
#include "samples/chart/aa_suite.hpp"

#include "framework/app/scene_source.hpp"
#include "framework/core/error.hpp"
#include "framework/core/file.hpp"
#include "framework/image_error/flip.hpp"
#include "framework/image_error/image_error.hpp"
#include "framework/image_error/mse.hpp"
#include "framework/scene/builtin.hpp"
#include "samples/chart/aa_limits.hpp"
#include "samples/chart/aa_sweep.hpp"

#include <cmath>
#include <map>

namespace ockham::chart {
namespace {

constexpr std::uint32_t kM = 4;      ///< window width
constexpr std::uint32_t kFineM = 16; ///< of the second, finer reference

/// What a job stands for.
struct Task {
    std::string source; ///< a file or a builtin: name
    AaSetting setting;
    int frames = 2; ///< until the picture is taken: the first warms up; taa gathers all
};

std::string setting_text(const AaSetting& setting) {
    return setting.knob == 0 ? "" : fmt::format("{:g}", setting.knob);
}

double milliseconds(const std::vector<PassTime>& times, bool shading_only) {
    double sum = 0;
    for (const PassTime& time : times)
        if (!shading_only || is_shading_pass(time.pass)) sum += time.milliseconds;
    return sum;
}

/// A graph with cheap shading and the same with stalled shading.
struct Pair {
    AdaptiveAa cheap, stalled;

    Pair(gpu::Device& device, const LitScene& scene, const Camera& camera, AdaptiveAaParams params)
        : cheap(device, scene, camera, params),
          stalled(device, scene, camera, (params.stall = kAaStall, params)) {}

    void execute(Values& values, const std::string& prefix) {
        cheap.execute();
        stalled.execute();
        values[prefix + "total_gpu_ms"] = milliseconds(cheap.times(), false);
        values[prefix + "shading_gpu_ms"] = milliseconds(cheap.times(), true);
        values[prefix + "stalled_total_gpu_ms"] = milliseconds(stalled.times(), false);
        values[prefix + "stalled_shading_gpu_ms"] = milliseconds(stalled.times(), true);
    }
};

/// One view with its references; the last one asked for stays loaded.
class View {
public:
    View(Context& context, const std::string& source, const SceneOptions& options)
        : device_(context.device()), lit_(device_, load_scenes(options, context.options.common)),
          camera_(choose_camera(context.options.common, lit_.scene(), lit_.gpu().bounds())),
          source_(source) {
        base_.width = static_cast<std::uint32_t>(context.options.common.width);
        base_.height = static_cast<std::uint32_t>(context.options.common.height);
        base_.m = kM;
        base_.order_kind = SampleOrder::optimal;
        base_.resolve = Resolve::stratified;
        AdaptiveAaParams all = base_;
        all.method = AaMethod::ssaa;
        reference_graphs_ = std::make_unique<Pair>(device_, lit_, camera_, all);
        Values warm;
        reference_graphs_->execute(warm, "");
        reference_ = reference_graphs_->cheap.picture();
    }

    const std::string& source() const { return source_; }
    const AdaptiveAaParams& base() const { return base_; }
    const Image& reference() const { return reference_; }
    std::unique_ptr<Pair> open(const AdaptiveAaParams& params) const {
        return std::make_unique<Pair>(device_, lit_, camera_, params);
    }
    /// 16 x 16 samples a pixel: full supersampling of a picture 4 times as wide, averaged.
    const Image& fine_reference();
    /// The reference's times, taken anew once for each `users` calls: once a turn.
    const Values& reference_times(std::size_t users) {
        if (uses_++ % users == 0) reference_graphs_->execute(times_, "reference_");
        return times_;
    }
    /// Rows over lambda of both limits.
    std::vector<Row> limits() const;

private:
    gpu::Device& device_;
    LitScene lit_;
    Camera camera_;
    std::string source_;
    AdaptiveAaParams base_;
    std::unique_ptr<Pair> reference_graphs_;
    Image reference_, fine_reference_;
    Values times_;
    std::size_t uses_ = 0;
};

const Image& View::fine_reference() {
    if (!fine_reference_.empty()) return fine_reference_;
    const int scale = kFineM / kM;
    AdaptiveAaParams params = base_;
    params.method = AaMethod::ssaa;
    params.width *= static_cast<std::uint32_t>(scale);
    params.height *= static_cast<std::uint32_t>(scale);
    AdaptiveAa aa(device_, lit_, camera_, params);
    aa.execute();
    const Image large = aa.picture();
    fine_reference_ = Image(large.width() / scale, large.height() / scale, {"R", "G", "B"});
    const float weight = 1.0f / static_cast<float>(scale * scale);
    for (int c = 0; c < 3; ++c)
        for (int y = 0; y < large.height(); ++y)
            for (int x = 0; x < large.width(); ++x)
                fine_reference_.at(x / scale, y / scale, c) += weight * large.at(x, y, c);
    return fine_reference_;
}

std::vector<Row> View::limits() const {
    const std::uint32_t n = kM * kM;
    AaLimits limits(reference_, n);
    AdaptiveAaParams uniform = base_;
    uniform.method = AaMethod::uniform;
    for (uniform.k = 1; uniform.k < n; ++uniform.k) {
        if (interrupted()) return {};
        AdaptiveAa aa(device_, lit_, camera_, uniform);
        aa.execute();
        limits.add(uniform.k, aa.picture());
    }
    const std::vector<float> variance =
        sample_variance(all_samples(device_, lit_, camera_, base_), kM);
    std::vector<Row> rows;
    for (double lambda = 1e-6; lambda < 0.03; lambda *= 1.4) {
        const LimitPoint known = limits.by_variance(variance, lambda);
        const LimitPoint seen = limits.by_clairvoyance(lambda);
        rows.push_back({.knob = lambda,
            .values = {{"variance_samples_percent", known.samples_percent},
                {"variance_psnr", known.psnr},
                {"clairvoyant_samples_percent", seen.samples_percent},
                {"clairvoyant_psnr", seen.psnr}}});
    }
    return rows;
}

class Limits : public Subject {
public:
    explicit Limits(const View& view) : view_(view) {}
    std::vector<Row> measure() override { return view_.limits(); }

private:
    const View& view_;
};

class Method : public Subject {
public:
    Method(View& view, const Task& task, std::size_t users)
        : view_(view), task_(task), users_(users), graphs_(view.open(params())) {
        Values warm;
        for (int frame = 0; frame + 1 < task_.frames; ++frame) graphs_->execute(warm, "");
    }

    std::vector<Row> measure() override {
        Values values = view_.reference_times(users_);
        graphs_->execute(values, "");
        if (picture_.empty()) judge();
        values.insert(error_.begin(), error_.end());
        return {{.knob = task_.setting.knob, .values = values}};
    }

    std::map<std::string, Picture> pictures() override {
        if (setting_text(task_.setting) != shown_setting(task_.setting.method)) return {};
        return {{"picture", to_picture(picture_)},
            {"error", error_picture(picture_, view_.reference())},
            {"fine_error", error_picture(picture_, view_.fine_reference())}};
    }

private:
    AdaptiveAaParams params() const {
        AdaptiveAaParams p = task_.setting.params;
        p.width = view_.base().width;
        p.height = view_.base().height;
        p.export_counts = true;
        return p;
    }

    void judge() {
        picture_ = graphs_->cheap.picture();
        const AaPoint point =
            judge_aa(task_.setting, graphs_->cheap, picture_, view_.reference(), kM);
        const Image& fine = view_.fine_reference();
        error_ = {{"samples_percent", point.samples_percent}, {"mse", point.mse},
            {"psnr", std::isinf(point.psnr) ? 999.0 : point.psnr}, {"ssim", point.ssim},
            {"flip", point.flip}, {"fine_psnr", psnr(mse(displayed(picture_), displayed(fine)))},
            {"fine_flip", flip(picture_, fine).mean},
            {"lane_efficiency", graphs_->cheap.sample_counts().lane_efficiency}};
    }

    View& view_;
    Task task_;
    std::size_t users_;
    std::unique_ptr<Pair> graphs_;
    Image picture_;
    Values error_;
};

/// Before anything is measured; files are looked for when jobs take their fingerprints.
void refuse_unknown(const std::string& source) {
    if (!source.starts_with("builtin:")) return;
    const auto names = builtin_scenes();
    const auto is_it = [&](const BuiltinName& known) { return known.name == source.substr(8); };
    if (std::none_of(names.begin(), names.end(), is_it))
        (void)builtin_scene(source.substr(8)); // says which there are
}

class AaSuite : public Suite {
public:
    explicit AaSuite(Context& context) : context_(context) {
        sources_ = context.options.scenes;
        if (sources_.empty()) sources_ = {"builtin:atrium", "builtin:fence"};
        if (context.options.scenes.empty() && !context.options.quick) {
            for (const char* more : {"builtin:wires", "builtin:foliage", "builtin:sparkle"})
                sources_.push_back(more);
        }
        for (const std::string& source : sources_) {
            refuse_unknown(source);
            std::string label = source.starts_with("builtin:")
                                    ? source.substr(8)
                                    : std::filesystem::path(source).stem().string();
            if (std::find(labels_.begin(), labels_.end(), label) != labels_.end()) label = source;
            labels_.push_back(label);
        }
    }

    std::string name() const override { return "aa"; }
    std::vector<Job> jobs() override;
    std::size_t together() const override {
        const int pixels = context_.options.common.width * context_.options.common.height;
        return pixels <= 512 * 384 ? 4 : 1; // graphs in memory: two of each, and the reference
    }
    std::unique_ptr<Subject> open(const Job& job) override;
    Section report(const Store& store, const std::vector<Point>& points) override {
        const AaChart chart = aa_chart_of(points, labels_, context_.device_text());
        write_text(context_.options.out / "aa_chart.json", to_json(chart));
        return aa_report(context_, store, points, labels_);
    }

private:
    SceneOptions scene_options(const std::string& source) const {
        SceneOptions options;
        options.scenes = {source};
        if (!source.starts_with("builtin:")) options.rig = context_.options.rig;
        return options;
    }
    AaKnobs knobs() const;
    std::vector<Task> tasks(const std::string& source, bool dispatches) const;

    Context& context_;
    std::vector<std::string> sources_, labels_;
    std::map<std::string, Task> tasks_; ///< by key of the job
    std::unique_ptr<View> view_;
};

AaKnobs AaSuite::knobs() const {
    AaKnobs knobs;
    if (context_.options.quick) {
        knobs.counts = {2, 4, 8, 12};
        knobs.scales = {0.25, 0.5, 1, 2, 4};
        knobs.lambdas = {1e-6, 4e-6, 1.5e-5, 6e-5, 2.5e-4, 1e-3};
    } else {
        knobs.counts = {1, 2, 3, 4, 5, 6, 8, 10, 12, 14};
        knobs.lambdas = {
            1e-6, 2e-6, 4e-6, 8e-6, 1.5e-5, 3e-5, 6e-5, 1.2e-4, 2.5e-4, 5e-4, 1e-3, 4e-3};
    }
    return knobs;
}

/// The flags that ask adaptive_aa for a setting.
std::string flags_of(const AaSetting& setting, int frames) {
    const AdaptiveAaParams& p = setting.params;
    if (setting.method == "uniform") return fmt::format("--method uniform --k {}", p.k);
    if (setting.method == "paper") {
        return fmt::format("--preset paper --c-depth {:g} --c-normal {:g} --c-shading {:g}",
            p.metrics.depth_weight, p.metrics.normal_weight, p.metrics.shading_weight);
    }
    if (setting.method == "taa") return fmt::format("--method taa --frames {}", frames);
    if (p.method == AaMethod::adaptive)
        return fmt::format("--lambda {:g} --dispatch {}", p.lambda, name_of(p.dispatch));
    return "--method " + setting.method;
}

std::vector<Task> AaSuite::tasks(const std::string& source, bool dispatches) const {
    AdaptiveAaParams base;
    base.m = kM;
    base.order_kind = SampleOrder::optimal;
    base.resolve = Resolve::stratified;
    std::vector<Task> tasks;
    for (const AaSetting& setting : aa_settings(base, knobs())) tasks.push_back({source, setting});
    for (const int frames : {2, 4, 8, 16}) {
        AaSetting setting{.method = "taa", .knob = static_cast<double>(frames), .params = base};
        setting.params.method = AaMethod::taa;
        tasks.push_back({source, setting, frames});
    }
    if (!dispatches) return tasks;
    for (const Dispatch dispatch : kDispatches) {
        if (dispatch == Dispatch::stencil && !context_.device().exports_stencil()) continue;
        AaKnobs few;
        few.counts = {1}, few.scales = {}, few.lambdas = {4e-6, 1.5e-5, 6e-5, 2.5e-4};
        for (AaSetting setting : aa_settings(base, few)) {
            if (setting.method != "ockham") continue;
            setting.method = fmt::format("dispatch {}", name_of(dispatch));
            setting.params.dispatch = dispatch;
            tasks.push_back({source, setting});
        }
    }
    return tasks;
}

std::vector<Job> AaSuite::jobs() {
    std::vector<Job> jobs;
    for (std::size_t i = 0; i < sources_.size(); ++i) {
        const CommonOptions& common = context_.options.common;
        const std::string size = fmt::format("--width {} --height {}", common.width, common.height);
        const std::string rig = scene_options(sources_[i]).rig;
        const std::string inputs = fmt::format("{} {} {} {}", size, fingerprint_of(sources_[i]),
            rig.empty() ? "" : fingerprint_of(rig), context_.device_text());
        const std::string scene = sources_[i] + (rig.empty() ? "" : " --rig " + rig);
        // Dispatching does not depend on the scene much: one in a quick run.
        for (const Task& task : tasks(sources_[i], i == 0 || !context_.options.quick)) {
            jobs.push_back({.suite = name(),
                .scene = labels_[i],
                .series = task.setting.method,
                .setting = setting_text(task.setting),
                .inputs = inputs,
                .command = fmt::format(
                    "adaptive_aa {} {} {}", scene, size, flags_of(task.setting, task.frames))});
            tasks_[jobs.back().key()] = task;
        }
        jobs.push_back({.suite = name(),
            .scene = labels_[i],
            .series = "limits",
            .inputs = inputs,
            .command = fmt::format("aa_curve {} {} --limits-only", scene, size),
            .repeats = 1});
        tasks_[jobs.back().key()] = {sources_[i], {.method = "limits", .params = {}}};
    }
    return jobs;
}

std::unique_ptr<Subject> AaSuite::open(const Job& job) {
    const Task& task = tasks_.at(job.key());
    if (!view_ || view_->source() != task.source) {
        view_.reset(); // its memory first
        view_ = std::make_unique<View>(context_, task.source, scene_options(task.source));
    }
    if (task.setting.method == "limits") return std::make_unique<Limits>(*view_);
    return std::make_unique<Method>(*view_, task, together());
}

} // namespace

std::string shown_setting(const std::string& series) {
    const std::map<std::string, std::string> shown{
        {"uniform", "4"}, {"paper", "1"}, {"ockham", "1.5e-05"}, {"taa", "16"}};
    const auto found = shown.find(series);
    return found == shown.end() ? "" : found->second;
}

std::unique_ptr<Suite> make_aa_suite(Context& context) {
    return std::make_unique<AaSuite>(context);
}

} // namespace ockham::chart
