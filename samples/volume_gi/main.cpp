// SPDX-License-Identifier: Apache-2.0
// volume_gi: renders volumes and isosurfaces with global illumination, sample after sample, and
// reports what it took. README.md beside this file has examples.
#include "framework/app/camera_path.hpp"
#include "framework/app/checkpoint.hpp"
#include "framework/app/cli.hpp"
#include "framework/app/headless.hpp"
#include "framework/app/volume_source.hpp"
#include "framework/core/error.hpp"
#include "framework/core/file.hpp"
#include "framework/core/log.hpp"
#include "framework/core/version.hpp"
#include "framework/gpu/device_lost.hpp"
#include "framework/graph/fingerprint.hpp"
#include "passes/pipelines/volume_gi_options.hpp"
#include "passes/volume/frame.hpp"
#include "samples/chart/volume_choice.hpp"

#include <nlohmann/json.hpp>

#include <bit>
#include <cmath>
#include <set>

using namespace ockham;

namespace {

constexpr int kDefaultSteps = 32;
constexpr std::uint64_t kMostTogether = 16; ///< steps of an execution
constexpr double kTogetherSeconds = 1;      ///< about as long may it take: interrupts wait for it
constexpr int kMostLosses = 3;              ///< of devices, before a run gives up

struct Options {
    CommonOptions common;
    VolumeOptions volume;
    VolumeGiOptions method;
    int steps = 0; ///< 0: as many as the other bounds allow
    float time = 0;
    float target_error = 0;
    float target_psnr = 0, target_ms = 0; ///< 0: mode and steps as they are
    std::string chart;
    CameraMoves moves;
    int frames = 0;
    std::string iso_to;
    std::string checkpoint, resume;
    float checkpoint_interval = 60;
    std::string convergence;
};

void declare(Params& params, Options& o) {
    add_volume_options(params, o.volume);
    add_volume_gi_options(params, o.method);
    const char* kRun = "Run";
    const char* kReport = "Reports";
    const auto add = [&](const char* group, const char* name, Param::Target target,
                         const char* help) -> Param& {
        return params.add(name, target, help).group(group);
    };
    add(kRun, "steps", &o.steps,
        "samples per pixel; default 32, or what --time and --target-error allow")
        .range(0, 1 << 24);
    add(kRun, "time", &o.time, "stop a frame after so long; 0: no bound")
        .range(0, 1e9)
        .unit("seconds");
    add(kRun, "target-error", &o.target_error,
        "stop once the standard error of pixels is this share of their mean; 0: no bound")
        .range(0, 1);
    add(kRun, "target-psnr", &o.target_psnr,
        "choose mode and steps for this error, by a chart of scenes; 0: no")
        .range(0, 200)
        .unit("dB");
    add(kRun, "target-ms", &o.target_ms,
        "choose mode and steps for this GPU time, by a chart of scenes; 0: no")
        .range(0, 1e9)
        .unit("ms");
    add(kRun, "chart", &o.chart,
        "volume_chart.json of a chart to choose by; none: the built-in one");
    add(kRun, "checkpoint", &o.checkpoint,
        "file to write what --resume needs to: at the end, on "
        "interrupt, and every so often")
        .transient();
    add(kRun, "checkpoint-interval", &o.checkpoint_interval, "how often; 0: after each step")
        .range(0, 1e9)
        .unit("seconds");
    add(kRun, "resume", &o.resume, "checkpoint to go on from, of a run with the same flags")
        .transient();
    add_camera_moves(params, o.moves, "the volume");
    add("Picture", "iso-to", &o.iso_to,
        "V[,V...]: values of the last picture's surfaces, on the way to which --iso changes "
        "evenly");
    add("Picture", "frames", &o.frames, "pictures along --camera-path; 0: one for each key")
        .range(0, 100000);
    add(kReport, "convergence", &o.convergence,
        "CSV file: seconds, steps, paths, psnr, ssim, flip against --reference as it goes on")
        .transient();
    add_view_flags(params, o.common);
    add_output_flags(params, o.common);
    add_run_flags(params, o.common);
}

/// One for each picture.
std::vector<Camera> cameras_of(const Options& o) {
    if (o.frames > 0 && o.moves.path.empty())
        fail_input("--frames: {} pictures of what? give --camera-path, or --turntable N", o.frames);
    Camera first = volume_camera();
    if (!o.common.camera.empty()) {
        const std::optional<Camera> given = parse_camera(o.common.camera, UpAxis::z);
        if (!given)
            fail_input("--camera: found '{}', expected \"px,py,pz tx,ty,tz fov\"", o.common.camera);
        first = *given;
    }
    return choose_cameras(o.moves, o.common, first, glm::vec3(0.0f), UpAxis::z, o.frames);
}

/// Of the surfaces in each picture.
std::vector<std::vector<double>> choose_isovalues(
    const Options& o, const VolumeView& view, std::size_t pictures) {
    std::vector<double> first;
    for (const VolumeView::Surface& surface : view.surfaces) first.push_back(surface.value);
    std::vector<std::vector<double>> all(pictures, first);
    if (o.iso_to.empty()) return all;
    const std::vector<float> last = parse_numbers(o.iso_to);
    if (last.empty() || last.size() != first.size()) {
        fail_input("--iso-to: found '{}', expected as many values as --iso has: {}", o.iso_to,
            first.size());
    }
    if (pictures < 2)
        fail_input("--iso-to: one picture has one --iso; give --turntable or --camera-path");
    for (std::size_t picture = 0; picture < pictures; ++picture)
        for (std::size_t i = 0; i < first.size(); ++i)
            all[picture][i] = std::lerp(first[i], double{last[i]},
                static_cast<double>(picture) / static_cast<double>(pictures - 1));
    return all;
}

void check_options(const Options& o, std::size_t pictures) {
    if (!o.convergence.empty() && o.common.reference.empty())
        fail_input("--convergence: there is no --reference to converge to");
    if (pictures > 1 && !o.common.reference.empty())
        fail_input("--reference: {} pictures cannot be measured against one", pictures);
    check_numbered(o.common, pictures);
}

bool chooses(const Options& o) { return o.target_psnr > 0 || o.target_ms > 0; }

void check_targets(const Options& o, const Params& params, std::size_t pictures) {
    if (!chooses(o)) {
        if (!o.chart.empty()) fail_input("--chart: needs --target-psnr or --target-ms");
        return;
    }
    if (o.target_psnr > 0 && o.target_ms > 0)
        fail_input("--target-psnr and --target-ms both choose mode and steps; give one of them");
    if (volume_mode(o.method))
        fail_input("--target-psnr and --target-ms choose the mode; leave --mode out");
    for (const char* other : {"gather", "steps", "time", "target-error", "checkpoint", "resume"}) {
        if (params.given(other))
            fail_input(
                "--target-psnr and --target-ms choose mode and steps; leave --{} out", other);
    }
    if (pictures > 1)
        fail_input("--target-psnr and --target-ms are of one picture, not of {}", pictures);
}

VolumeMode mode_of(
    const Options& o, const Volume& volume, std::size_t pictures, gpu::Device& device) {
    if (const std::optional<VolumeMode> given = volume_mode(o.method)) return *given;
    const ModeChoice choice = choose_mode(volume, pictures,
        static_cast<std::uint32_t>(o.method.cache_scale), device.allocator().budget_bytes());
    log::info("--mode auto: {}, for {}", name_of(choice.mode), choice.why);
    return choice.mode;
}

VolumeGiParams picture_params(const Options& o, VolumeMode mode) {
    VolumeGiParams p = volume_gi_params(o.method, mode);
    p.width = static_cast<std::uint32_t>(o.common.width);
    p.height = static_cast<std::uint32_t>(o.common.height);
    p.keep_on_iso = !o.iso_to.empty();
    if (o.target_error > 0) p.cache_error = o.target_error;
    for (const auto& [name, file] : parse_captures(o.common)) p.captures.push_back(name);
    return p;
}

/// Path traces two halves of a probe with seeds of their own. Errors are those of half their
/// difference.
VolumeProbe probe(gpu::Device& device, const VolumeSource& source, const Camera& camera,
    const VolumeGiParams& params) {
    VolumeGi gi(
        device, source.volume, source.transfer, source.environment, source.view, camera, params);
    gi.execute(); // compiles kernels
    gi.finish();
    VolumeProbe measured{.features = features_of(source)};
    const auto add_time = [&] {
        for (const PassTime& time : gi.executor().times()) measured.gpu_ms += time.milliseconds;
    };
    Image halves[2];
    VolumeView view = source.view;
    for (Image& half : halves) {
        ++view.seed;
        gi.set_view(view);
        gi.execute(kProbeSteps / 2), add_time();
        while (!gi.finished()) gi.drain(), add_time();
        half = gi.picture();
    }
    const double mse = image_error(halves[0], halves[1]).mse / 4;
    measured.psnr = -10 * std::log10(std::max(mse, 1e-12));
    return measured;
}

/// Mode, gather and steps for the target, by the class of scenes that this is most like.
std::optional<VolumeChoice> choose_technique(
    Options& o, gpu::Device& device, const VolumeSource& source, const Camera& camera) {
    if (!chooses(o)) return std::nullopt;
    const VolumeChart chart = o.chart.empty() ? builtin_volume_chart() : load_volume_chart(o.chart);
    VolumeGiParams params = volume_gi_params(o.method, VolumeMode::path);
    params.width = static_cast<std::uint32_t>(o.common.width);
    params.height = static_cast<std::uint32_t>(o.common.height);
    const VolumeProbe measured = probe(device, source, camera, params);
    const VolumeChoice choice = o.target_psnr > 0 ? choose_by_psnr(chart, measured, o.target_psnr)
                                                  : choose_by_time(chart, measured, o.target_ms);
    if (!choice.reached) {
        log::warning("nothing in the chart reaches --target-{} {:g}; the nearest is taken",
            o.target_psnr > 0 ? "psnr" : "ms", o.target_psnr > 0 ? o.target_psnr : o.target_ms);
    }
    o.method.mode = name_of(choice.technique.mode);
    o.method.gather = choice.technique.gather;
    o.steps = static_cast<int>(choice.steps);
    return choice;
}

nlohmann::ordered_json to_json(const VolumeChoice& choice) {
    return {{"class", choice.class_name}, {"technique", name_of(choice.technique)},
        {"steps", choice.steps}, {"predicted_psnr", choice.psnr},
        {"predicted_gpu_ms", choice.gpu_ms}, {"reached", choice.reached}};
}

void print_choice(
    const VolumeChoice& choice, double gpu_ms, const std::optional<ImageError>& error) {
    fmt::print("choice  {}, {:.0f} steps, as for '{}'\n", name_of(choice.technique), choice.steps,
        choice.class_name);
    fmt::print("predicted {:7.2f} dB, {:.2f} ms\n", choice.psnr, choice.gpu_ms);
    fmt::print("obtained  {}, {:.2f} ms\n",
        error ? fmt::format("{:7.2f} dB", error->psnr) : "error unknown without --reference",
        gpu_ms);
}

/// Everything that decides the picture: flags but those of one run and names of files, what these
/// files hold, the program and the driver.
nlohmann::ordered_json identity_of(const Params& params, const VolumeSource& source,
    const std::vector<Camera>& cameras, VolumeMode mode, const gpu::Device& device) {
    static const std::set<std::string> decide_nothing{"allow-external", "checkpoint-interval",
        "exposure", "gpu", "memory-budget", "quiet", "shader-dir", "steps", "strict", "time",
        "tonemap", "validation", "volume", "transfer", "window", "environment", "iso-material",
        "camera-path", "mode"};
    nlohmann::ordered_json identity{{"commit", commit()}, {"device", device.info().name},
        {"driver", device.info().driver_version}, {"mode", name_of(mode)}};
    const nlohmann::json flags = params.to_json();
    for (const auto& [name, value] : flags.items()) {
        const bool decides = name != "target-error" || mode == VolumeMode::caching;
        if (decides && !decide_nothing.contains(name)) identity["--" + name] = value;
    }
    const nlohmann::ordered_json prints = fingerprints_of(source);
    for (const auto& [name, print] : prints.items()) identity[name] = print;
    Fingerprint path;
    for (const Camera& camera : cameras)
        for (const float number : {camera.position.x, camera.position.y, camera.position.z,
                 camera.forward.x, camera.forward.y, camera.forward.z, camera.fov_y_degrees})
            path.mix(std::uint64_t{std::bit_cast<std::uint32_t>(number)});
    identity["cameras"] = fmt::format("{:016x}", path.high);
    return identity;
}

/// The pictures of a run, one after the other, and how far they are.
class Session {
public:
    Session(const Options& options, HeadlessRun& run, gpu::Device& device, VolumeGi& gi,
        const VolumeView& view, const std::vector<Camera>& cameras,
        const std::vector<std::vector<double>>& isovalues, nlohmann::ordered_json identity,
        bool& saved)
        : o_(options), run_(run), device_(device), gi_(gi), view_(view), cameras_(cameras),
          isovalues_(isovalues), identity_(std::move(identity)), saved_(saved) {}

    /// False where it was interrupted; then the checkpoint is written.
    bool render() {
        resume();
        for (;; show(++frame_)) {
            if (!render_frame() || !add_row() || !finish()) {
                save();
                return false;
            }
            run_.save_picture(gi_.picture(), static_cast<int>(frame_));
            if (frame_ + 1 >= cameras_.size()) break;
        }
        save();
        return true;
    }
    double seconds() const { return seconds_; }
    double gpu_ms() const { return gpu_ms_; } ///< of all passes

private:
    std::uint64_t last_step() const {
        if (o_.steps > 0) return static_cast<std::uint64_t>(o_.steps);
        return o_.time > 0 || o_.target_error > 0 ? ~std::uint64_t{0} : kDefaultSteps;
    }

    void show(std::size_t frame) {
        gi_.set_camera(cameras_.at(frame));
        if (o_.iso_to.empty()) return;
        for (std::size_t i = 0; i < view_.surfaces.size(); ++i)
            view_.surfaces[i].value = isovalues_[frame][i];
        gi_.set_view(view_);
    }

    /// The steps of a picture. False where it was interrupted.
    bool render_frame() {
        const std::uint64_t last = last_step();
        const double begin = seconds_;
        Progress progress("step", last == ~std::uint64_t{0} ? 1 : last, o_.common.quiet);
        for (std::uint64_t next_check = 2; gi_.steps() < last;) {
            if (interrupted()) return false;
            step(together(std::min(last, o_.target_error > 0 ? next_check : last),
                o_.time > 0 ? begin + o_.time - seconds_ : kTogetherSeconds));
            progress.update(gi_.steps());
            if (std::has_single_bit(gi_.steps()) && gi_.steps() < last && !add_row()) return false;
            if (!o_.checkpoint.empty() && since_saved_.seconds() >= o_.checkpoint_interval) save();
            if (o_.time > 0 && seconds_ - begin >= o_.time) break;
            if (o_.target_error > 0 && gi_.steps() >= next_check && converged(next_check)) break;
        }
        return true;
    }

    /// Long paths may take many executions. False where it was interrupted.
    bool finish() {
        const Timer timer;
        while (!gi_.finished() && !interrupted()) gi_.drain(), add_gpu_time();
        seconds_ += timer.seconds();
        return gi_.finished();
    }

    /// How many steps to take at once: as many as there were, but not past `last`, nor past a
    /// power of two, where --convergence has its rows, nor for much longer than `seconds`.
    std::uint32_t together(std::uint64_t last, double seconds) const {
        const std::uint64_t steps = gi_.steps();
        if (steps == 0 || !gi_.steps_together()) return 1;
        if (!o_.checkpoint.empty()) seconds = std::min<double>(seconds, o_.checkpoint_interval);
        seconds = std::min(seconds, kTogetherSeconds);
        const double affordable = std::clamp(seconds / step_seconds_, 1.0, double{kMostTogether});
        return static_cast<std::uint32_t>(std::min({2 * std::bit_floor(steps) - steps,
            std::max(last, steps + 1) - steps, static_cast<std::uint64_t>(affordable)}));
    }

    void step(std::uint32_t steps) {
        reload_shaders(device_);
        const Timer timer;
        gi_.execute(steps);
        const double seconds = timer.seconds();
        seconds_ += seconds;
        step_seconds_ = seconds / steps;
        add_gpu_time();
        std::vector<PassTime> times = gi_.executor().times();
        for (PassTime& time : times) time.milliseconds /= steps;
        for (std::uint32_t i = 0; i < steps && (warm_ || o_.steps == 1); ++i) run_.add_times(times);
        warm_ = true; // the first step compiles kernels
    }

    void add_gpu_time() {
        for (const PassTime& time : gi_.executor().times()) gpu_ms_ += time.milliseconds;
    }

    /// Else `next` becomes the step at which it may be so: errors fall with the root of the
    /// samples.
    bool converged(std::uint64_t& next) {
        const VolumeStatistics now = gi_.statistics();
        if (!now.relative_error) return now.cache_converged;
        const double ratio = *now.relative_error / o_.target_error;
        if (ratio <= 1) return now.cells == 0 || now.cache_converged;
        const auto steps = static_cast<double>(gi_.steps());
        next = static_cast<std::uint64_t>(std::min(std::ceil(steps * ratio * ratio), 2 * steps));
        return false;
    }

    /// One more row of --convergence. Measuring takes no time. False where it was interrupted.
    bool add_row() {
        if (o_.convergence.empty()) return true;
        if (!finish()) return false;

        const std::optional<ImageError> error = run_.error_of(gi_.picture());
        rows_ += fmt::format("{:.6g},{},{},{:.6g},{:.6g},{:.6g}\n", seconds_, gi_.steps(),
            gi_.statistics().paths, std::isinf(error->psnr) ? 999.0 : error->psnr, error->ssim,
            error->flip.mean);
        write_text(o_.convergence, "seconds,steps,paths,psnr,ssim,flip\n" + rows_);
        return true;
    }

    void save() {
        if (o_.checkpoint.empty() || gi_.steps() == 0) return;
        save_checkpoint(o_.checkpoint,
            {identity_,
                {{"frame", frame_}, {"steps", gi_.steps()}, {"seconds", seconds_}, {"rows", rows_}},
                gi_.save()});
        saved_ = true;
        since_saved_.restart();
    }

    void resume() {
        if (o_.resume.empty()) return;
        Checkpoint checkpoint = load_checkpoint(o_.resume, identity_);
        frame_ = checkpoint.progress.at("frame");
        if (frame_ > 0) show(frame_);
        gi_.restore(std::move(checkpoint.resources));
        seconds_ = checkpoint.progress.at("seconds");
        rows_ = checkpoint.progress.at("rows");
        log::info("resumed '{}' after {} steps", o_.resume, gi_.steps());
        if (gi_.steps() >= last_step()) gi_.drain(); // no step is left to make the picture
    }

    const Options& o_;
    HeadlessRun& run_;
    gpu::Device& device_;
    VolumeGi& gi_;
    VolumeView view_;
    const std::vector<Camera>& cameras_;
    const std::vector<std::vector<double>>& isovalues_;
    nlohmann::ordered_json identity_;
    bool& saved_; ///< whether this run has written its checkpoint
    std::size_t frame_ = 0;
    double seconds_ = 0;      ///< of executions
    double step_seconds_ = 1; ///< of each step of the last one
    double gpu_ms_ = 0;
    bool warm_ = false;
    Timer since_saved_;
    std::string rows_;
};

nlohmann::ordered_json to_json(const VolumeStatistics& s, VolumeMode mode) {
    nlohmann::ordered_json json{{"mode", name_of(mode)}, {"paths", s.paths}, {"steps", s.steps},
        {"resumed", s.resumed}, {"truncated", s.truncated}, {"cells", s.cells},
        {"cell_bytes", s.cell_bytes}, {"majorant_cells", s.majorant_cells},
        {"mean_variance", nullptr}};
    if (s.mean_variance) json["mean_variance"] = *s.mean_variance;
    return json;
}

void print_summary(const FrameTimes& times, const VolumeGi& gi, const VolumeStatistics& statistics,
    double seconds, const std::optional<ImageError>& error) {
    fmt::print("gpu     {:9.2f} ms per step (median of {}), {} steps in {:.2f} s\n", times.total(),
        times.frames(), gi.steps(), seconds);
    fmt::print("paths   {:9.3g}, {:.3g} lookups of the field\n",
        static_cast<double>(statistics.paths), static_cast<double>(statistics.steps));
    if (statistics.relative_error)
        fmt::print("noise   {:9.2g} of the mean\n", *statistics.relative_error);
    if (statistics.cells > 0) {
        fmt::print("cache   {:9} cells, {:.1f} MiB, {}\n", statistics.cells,
            static_cast<double>(statistics.cell_bytes) / (1 << 20),
            statistics.cache_converged ? "converged" : "not converged yet");
    }
    if (error) print_error(*error);
}

/// All that needs a device. Exit code.
int render_on_device(Options o, const Params& params, const VolumeSource& source,
    const std::vector<Camera>& cameras, const std::vector<std::vector<double>>& isovalues,
    HeadlessRun& run, bool& saved) {
    gpu::Device device(device_options(o.common));
    watch_shaders(device, o.common);
    log::info("{} ({})", device.info().name, device.info().driver_version);
    const std::optional<VolumeChoice> choice = choose_technique(o, device, source, cameras.front());
    const VolumeMode mode = mode_of(o, source.volume, cameras.size(), device);
    VolumeGi gi(device, source.volume, source.transfer, source.environment, source.view,
        cameras.front(), picture_params(o, mode));
    run.announce(device, gi.executor());
    log::info("volume {} MiB, graph {} MiB", gi.gpu().bytes() >> 20,
        gi.executor().plan().bytes_peak >> 20);

    Session session(o, run, device, gi, source.view, cameras, isovalues,
        identity_of(params, source, cameras, mode, device), saved);
    if (!session.render()) return 130;
    expect_no_validation_messages(device);
    run.save_captures(gi.executor(), gi.captures());
    const VolumeStatistics statistics = gi.statistics();
    const std::optional<ImageError> error = run.error_of(gi.picture());
    print_summary(run.times(), gi, statistics, session.seconds(), error);
    nlohmann::ordered_json more{{"volume", to_json(statistics, mode)}};
    if (choice) print_choice(*choice, session.gpu_ms(), error), more["choice"] = to_json(*choice);
    run.report(device, gi.executor(), more, error);
    return 0;
}

int render(int argc, char** argv) {
    Options o;
    Params params;
    declare(params, o);
    if (const std::optional<int> done = parse_command_line(argc, argv,
            "Renders volumes and isosurfaces with global illumination.", params, o.common)) {
        return *done;
    }
    const std::vector<Camera> cameras = cameras_of(o);
    check_options(o, cameras.size());
    check_targets(o, params, cameras.size());
    HeadlessRun run(o.common, argc, argv, {o.checkpoint, o.convergence});

    VolumeSource source = load_volume_source(o.volume);
    apply(o.method, source.view);
    const std::vector<std::vector<double>> isovalues =
        choose_isovalues(o, source.view, cameras.size());
    for (int lost = 1;; ++lost) {
        bool saved = false;
        try {
            return render_on_device(o, params, source, cameras, isovalues, run, saved);
        } catch (const gpu::DeviceLost& error) {
            if (!saved || lost > kMostLosses) throw;
            log::warning("{}; going on from '{}' on a new device", error.what(), o.checkpoint);
            o.resume = o.checkpoint;
        }
    }
}

} // namespace

int main(int argc, char** argv) {
    return run_program([&] { return render(argc, argv); });
}
