// SPDX-License-Identifier: Apache-2.0
#include "samples/chart/peers_suite.hpp"

#include "framework/core/error.hpp"
#include "framework/core/file.hpp"
#include "framework/core/process.hpp"
#include "framework/core/timer.hpp"
#include "framework/image_error/image_error.hpp"
#include "framework/io/image_file.hpp"
#include "framework/io/volume_file.hpp"
#include "samples/chart/volume_runs.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <optional>

namespace ockham::chart {
namespace {

constexpr std::uint32_t kSide = 64;
constexpr const char* kBlender = "Cycles";
constexpr const char* kVtk = "VTK";
constexpr const char* kVtkFine = "VTK, 4 × 4 rays";
constexpr const char* kOurs = "path";
/// As cycles_volume.py looks: from +z, one radian high.
constexpr const char* kCamera = "0,0,2 0,0,0 57.29577951";
/// Debian's own, for Debian's modules: another that comes first in PATH lacks them.
constexpr const char* kPython = "/usr/bin/python3";
constexpr const char* kScreen = "xvfb-run"; ///< VTK's window has OpenGL, the ray caster has not
const std::filesystem::path kScripts = OCKHAM_TRUTH_DIR;

/// The line of JSON after "RESULT " that the scripts of tests/truth print.
nlohmann::json result_of(const std::vector<std::string>& words) {
    const ProcessResult output = run_process(words);
    const std::size_t begin = output.text.rfind("RESULT ");
    if (output.exit_code != 0 || begin == std::string::npos) {
        const std::size_t tail = output.text.size() > 400 ? output.text.size() - 400 : 0;
        fail_input("{} gave no result: {}", words.front(), output.text.substr(tail));
    }
    const std::size_t end = output.text.find('\n', begin);
    return nlohmann::json::parse(output.text.substr(begin + 7, end - begin - 7));
}

/// A medium that both programs know, its extinction in proportion to the value.
struct Medium {
    VolumeScene scene;
    nlohmann::json cycles; ///< keys of cycles_volume.py
};

Medium medium(const std::string& name, const std::string& volume, float extinction) {
    Medium made;
    made.scene.name = name;
    made.scene.options.volume = {volume};
    made.scene.options.window = "0.5,1"; // opacity = value
    made.scene.options.density_scale = extinction;
    made.scene.options.albedo = 0.8f;
    made.scene.options.environment = "1,1,1";
    made.scene.camera = kCamera;
    made.cycles = {{"extinction", extinction}, {"albedo", 0.8}, {"size", kSide}};
    return made;
}

class PeersSuite : public Suite {
public:
    explicit PeersSuite(Context& context);
    std::string name() const override { return "peers"; }
    std::string obstacle() override;
    std::vector<Job> jobs() override { return list_.jobs(); }
    std::size_t together() const override { return 2; }
    std::unique_ptr<Subject> open(const Job& job) override { return list_.open(job); }
    Section report(const Store& store, const std::vector<Point>& points) override;

private:
    Job job(const VolumeScene& scene, const std::string& series, const std::string& flags,
        int repeats) const;
    void add_ours(const Medium& medium, std::function<const VolumeReference&()> reference);
    const VolumeReference& transmittance();
    void add_medium(const Medium& medium);
    void add_absorber();
    std::vector<Row> cycles(const Medium& medium);
    std::vector<Row> vtk_volume(int rays);
    std::vector<Row> surface();
    Table equal_error_table(const std::vector<Point>& points) const;
    Table surface_table(const std::vector<Point>& points) const;

    Context& context_;
    VolumeReferences references_;
    std::vector<Medium> media_;
    std::optional<VolumeReference> transmittance_;
    Medium absorber_; ///< what VTK's volume rendering knows: no scattering, no shadows
    VolumeScene shells_;
    int seed_ = 0;
    JobList list_;
};

PeersSuite::PeersSuite(Context& context) : context_(context), references_(context, kSide) {
    media_.push_back(medium("cube", "builtin:constant:16", 4));
    // A grid needs a file that Blender reads beside the one that this program does.
    for (const std::string& volume : context.options.volumes) {
        std::filesystem::path grid(volume);
        grid.replace_extension(".vdb");
        if (volume.starts_with("builtin:") || !std::filesystem::exists(grid)) continue;
        media_.push_back(medium(grid.stem().string(), volume, 20));
        media_.back().cycles["vdb"] = grid.string();
        media_.back().cycles["side"] = load_volume(volume).dims.x;
    }
    for (const Medium& one : media_) add_medium(one);
    absorber_ = medium("absorbing cloud", "builtin:cloud:64", 20);
    absorber_.scene.options.window = "127.5,255"; // opacity = voxel / 255
    absorber_.scene.options.albedo = 0;
    add_absorber();
    shells_.name = "shells";
    shells_.options.volume = {"builtin:shells:64"};
    shells_.options.iso = "100";
    list_.add(job(shells_, "surface", "--surface-search exact", 1),
        [this] { return std::make_unique<Once>([this](auto&) { return surface(); }); });
}

std::string PeersSuite::obstacle() {
    if (!std::filesystem::exists(kScripts / "cycles_volume.py"))
        return fmt::format("the scripts of tests/truth are not at '{}', where this program was "
                           "built",
            kScripts.string());
    if (!find_program("blender")) return "blender is not installed: apt-get install blender";
    if (!find_program(kScreen)) return "VTK draws on a screen: apt-get install xvfb xauth";
    if (!find_program(kPython) ||
        run_process({kPython, "-c", "import vtk, OpenImageIO, numpy"}).exit_code != 0)
        return "Python modules are missing: apt-get install python3-vtk9 python3-openimageio "
               "python3-numpy";
    return {};
}

Job PeersSuite::job(const VolumeScene& scene, const std::string& series, const std::string& flags,
    int repeats) const {
    return {.suite = name(),
        .scene = scene.name,
        .series = series,
        .setting = {},
        .inputs = fmt::format("{} {} {} {} {}", scene.inputs(), flags, context_.options.quick,
            cpu_name(), context_.device_text()),
        .command = fmt::format(
            "volume_gi {} {} --width {} --height {}", scene.flags(), flags, kSide, kSide),
        .repeats = repeats};
}

void PeersSuite::add_ours(const Medium& medium, std::function<const VolumeReference&()> reference) {
    list_.add(job(medium.scene, kOurs, "--mode path", 0), [this, medium, reference] {
        VolumeGiParams params;
        params.width = params.height = kSide;
        return std::make_unique<VolumeRun>(context_.device(), medium.scene, params, reference(),
            context_.options.quick ? 0.8 : 12);
    });
}

void PeersSuite::add_medium(const Medium& medium) {
    add_ours(medium, [this, medium]() -> const VolumeReference& {
        return references_.of(medium.scene, VolumeMode::path);
    });
    Job theirs = job(medium.scene, kBlender, "", 0);
    theirs.command =
        fmt::format("blender -b --factory-startup -P tests/truth/cycles_volume.py -- '{}'",
            medium.cycles.dump());
    list_.add(theirs, [this, medium] {
        return std::make_unique<Once>([this, medium](auto&) { return cycles(medium); });
    });
}

void PeersSuite::add_absorber() {
    add_ours(absorber_, [this]() -> const VolumeReference& { return transmittance(); });
    for (const auto& [series, rays] : {std::pair{kVtk, 1}, {kVtkFine, 4}}) {
        Job theirs = job(absorber_.scene, series, "", 0);
        theirs.command = fmt::format("{} {} tests/truth/vtk_volume.py …", kScreen, kPython);
        list_.add(theirs, [this, rays = rays] {
            return std::make_unique<Once>([this, rays](auto&) { return vtk_volume(rays); });
        });
    }
}

/// How much of the world gets through the absorber: 8 x 8 rays a pixel, the midpoint rule over
/// quarters of voxels in double precision. It shares nothing with the kernels.
const VolumeReference& PeersSuite::transmittance() {
    if (transmittance_) return *transmittance_;
    constexpr int kRays = 8;
    const VolumeSource source = absorber_.scene.load();
    const VolumePlace place = place_of(source.volume);
    const glm::dvec3 eye(0, 0, 2), half = -place.corner;
    const double high = std::tan(0.5), step = 0.25 / source.volume.dims.x;
    const auto through = [&](double x, double y) {
        const glm::dvec3 direction = glm::normalize(glm::dvec3(x * high, y * high, -1));
        const glm::dvec3 a = (-half - eye) / direction, b = (half - eye) / direction;
        const glm::dvec3 in = glm::min(a, b), out = glm::max(a, b);
        const double first = std::max({in.x, in.y, in.z}), last = std::min({out.x, out.y, out.z});
        double depth = 0;
        for (double t = first + 0.5 * step; t < last; t += step) {
            const glm::dvec3 unit = (eye + t * direction + half) / (2.0 * half);
            depth += step * source.transfer.at(source.volume.sample(unit)).opacity;
        }
        return std::exp(-depth * double{source.view.density_scale});
    };
    VolumeReference reference{.picture = Image(kSide, kSide, {"R", "G", "B"})};
    for (int y = 0; y < int{kSide}; ++y)
        for (int x = 0; x < int{kSide}; ++x) {
            double sum = 0;
            for (int ray = 0; ray < kRays * kRays; ++ray) {
                const double px = (x + (ray % kRays + 0.5) / kRays) / kSide,
                             py = (y + (ray / kRays + 0.5) / kRays) / kSide;
                sum += through(2 * px - 1, 1 - 2 * py);
            }
            for (int c = 0; c < 3; ++c)
                reference.picture.at(x, y, c) = static_cast<float>(sum / (kRays * kRays));
        }
    return transmittance_.emplace(std::move(reference));
}

/// A row for each distance between samples.
std::vector<Row> PeersSuite::vtk_volume(int rays) {
    const Volume volume = absorber_.scene.load().volume;
    std::vector<float> values;
    for (const std::byte voxel : volume.voxels)
        values.push_back(static_cast<float>(std::to_integer<int>(voxel)) / 255.0f);
    const std::filesystem::path raw = context_.options.out / "absorber.raw";
    write_file(raw, std::as_bytes(std::span(values)));
    const std::vector<double> steps{8, 4, 2, 1, 0.5, 0.25};
    const nlohmann::json request{{"raw", raw.string()},
        {"dims", {volume.dims.x, volume.dims.y, volume.dims.z}},
        {"extinction", absorber_.scene.options.density_scale}, {"size", kSide}, {"steps", steps},
        {"rays", rays}, {"output", context_.options.out.string()}};
    const nlohmann::json pictures =
        result_of({kScreen, "-a", kPython, (kScripts / "vtk_volume.py").string(), request.dump()});
    const VolumeReference& reference = transmittance();
    std::vector<Row> rows;
    for (const nlohmann::json& one : pictures) {
        const std::vector<std::byte> bytes = read_file(one.at("picture").get<std::string>());
        Image picture(kSide, kSide, {"R", "G", "B"});
        for (const char* channel : {"R", "G", "B"})
            std::memcpy(picture.plane(channel).data(), bytes.data(),
                std::min(bytes.size(), picture.plane(channel).size_bytes()));
        const ImageError error = image_error(picture, reference.picture);
        rows.push_back({.knob = one.at("step"),
            .values = {{"gpu_seconds", one.at("seconds")}, {"cpu_seconds", one.at("cpu_seconds")},
                {"psnr", error.psnr}, {"relmse", error.relmse}, {"mean", one.at("mean")}}});
    }
    return rows;
}

std::vector<Row> PeersSuite::cycles(const Medium& medium) {
    const VolumeReference& reference = references_.of(medium.scene, VolumeMode::path);
    std::vector<Row> rows;
    const int most = context_.options.quick ? 64 : 1024;
    for (int samples = 4; samples <= most && !interrupted(); samples *= 4) {
        nlohmann::json request = medium.cycles;
        const std::filesystem::path output = context_.options.out / "cycles.exr";
        request.update({{"samples", samples}, {"seed", ++seed_}, {"output", output.string()}});
        const nlohmann::json result = result_of({"blender", "-b", "--factory-startup", "-P",
            (kScripts / "cycles_volume.py").string(), "--", request.dump()});
        const ImageError error = image_error(load_image(output), reference.picture);
        rows.push_back({.knob = double(samples),
            .values = {{"samples", double(samples)}, {"gpu_seconds", result.at("seconds")},
                {"cpu_seconds", result.at("cpu_seconds")}, {"psnr", error.psnr},
                {"relmse", error.relmse}, {"mean", result.at("mean")}}});
    }
    return rows;
}

/// Along +z, a pixel for each voxel of x and y: what vtk_surface.py compares.
std::vector<Row> PeersSuite::surface() {
    const VolumeSource source = shells_.load();
    const Volume& volume = source.volume;
    const std::filesystem::path folder = context_.options.out;
    write_file(folder / "shells.raw", volume.voxels);
    write_text(folder / "shells.json",
        nlohmann::json{{"file", "shells.raw"}, {"type", ockham::name_of(volume.type)},
            {"dims", {volume.dims.x, volume.dims.y, volume.dims.z}}, {"spacing_mm", {1, 1, 1}}}
            .dump());
    Camera camera = look_at({0, 0, -2}, {0, 0, 0}, 40, UpAxis::z);
    camera.orthographic_height = float(volume.dims.y) / float(volume.dims.z);
    VolumeGiParams params;
    params.width = volume.dims.x;
    params.height = volume.dims.y;
    params.mode = VolumeMode::noncaching;
    params.captures = {"surface_depth"};
    VolumeGi gi(context_.device(), volume, source.transfer, source.environment, source.view, camera,
        params);
    std::vector<double> seconds;
    for (int turn = 0; turn < 8; ++turn) {
        gi.set_camera(camera); // the depth is found anew for a new view
        gi.execute();
        for (const PassTime& time : gi.executor().times())
            if (turn > 0 && time.pass.starts_with("surface_depth"))
                seconds.push_back(1e-3 * time.milliseconds);
    }
    save_image(folder / "shells_depth.exr", gi.executor().read(gi.captures().front()));
    const nlohmann::json vtk = result_of(
        {kPython, (kScripts / "vtk_surface.py").string(), (folder / "shells.json").string(),
            shells_.options.iso, (folder / "shells_depth.exr").string()});
    return {{.knob = 0,
        .values = {{"pixels", vtk.at("pixels")},
            {"agreement_percent", 100 * vtk.at("agreement").get<double>()},
            {"difference_mean", vtk.at("mean")}, {"difference_max", vtk.at("max")},
            {"seconds_mesh", vtk.at("seconds_mesh")}, {"seconds_tree", vtk.at("seconds_tree")},
            {"seconds_rays", vtk.at("seconds_rays")},
            {"seconds_ours", seconds.empty() ? 0.0 : spread(seconds).median}}}};
}

/// Both are Monte Carlo estimates, so error squared times time is constant but for the set-up: it
/// is read off the differences between the least and the most samples.
Table PeersSuite::equal_error_table(const std::vector<Point>& points) const {
    Table table{.name = "peers_equal_error",
        .title = "Time to an error of 1 %: this program and Cycles",
        .columns = {"medium", "program", "CPU µs per path", "relMSE × samples",
            "CPU seconds to a root of relMSE of 0.01", "mean of the middle, Cycles"},
        .rows = {},
        .caption = fmt::format(
            "{0} × {0} pixels, white world, albedo 0.8; processor seconds of all threads. The cost "
            "of a path is that between the fewest and the most samples, so that set-up does not "
            "count. Error against the same reference of mode path.",
            kSide)};
    for (const Medium& medium : media_)
        for (const char* series : {kOurs, kBlender}) {
            const Point *first = nullptr, *last = nullptr;
            for (const Point& point : points) {
                if (point.job->scene != medium.scene.name || point.job->series != series) continue;
                if (first == nullptr) first = &point;
                last = &point;
            }
            if (first == nullptr || first == last) continue;
            const double samples = last->knob - first->knob;
            const double per_sample =
                ((*last)["cpu_seconds"].median - (*first)["cpu_seconds"].median) / samples;
            const double variance = (*first)["relmse"].median * first->knob;
            table.rows.push_back({medium.scene.name, series,
                fmt::format("{:.2f}", 1e6 * per_sample / (kSide * kSide)),
                fmt::format("{:.3g}", variance),
                fmt::format("{:.3g}", per_sample * variance / 1e-4),
                last->has("mean") ? fmt::format("{:.5f}", (*last)["mean"].median) : ""});
        }
    return table;
}

Table PeersSuite::surface_table(const std::vector<Point>& points) const {
    Table table{.name = "peers_surface",
        .title = "The first isosurface along rays: this program and VTK",
        .columns = {"rays", "agree on a hit (%)", "mean difference (voxels)", "largest",
            "exact search (ms)", "VTK: mesh (ms)", "tree (ms)", "rays (ms, from Python)"},
        .rows = {},
        .caption = "builtin:shells:64 at 100, rays through voxel centres, along which both are "
                   "roots of a linear function. VTK 9: flying edges, static cell locator."};
    for (const Point& p : points) {
        if (p.job->series != "surface") continue;
        const auto text = [&](const char* value, double factor, const char* format) {
            return fmt::format(fmt::runtime(format), factor * p[value].median);
        };
        table.rows.push_back({text("pixels", 1, "{:.0f}"), text("agreement_percent", 1, "{:.3f}"),
            text("difference_mean", 1, "{:.1e}"), text("difference_max", 1, "{:.1e}"),
            text("seconds_ours", 1e3, "{:.2f}"), text("seconds_mesh", 1e3, "{:.1f}"),
            text("seconds_tree", 1e3, "{:.1f}"), text("seconds_rays", 1e3, "{:.0f}")});
    }
    return table;
}

Section PeersSuite::report(const Store&, const std::vector<Point>& points) {
    Section section{.title = "Other programs",
        .text = "The same media and the same isosurface on this machine, by Blender's Cycles and "
                "by VTK, whose volume rendering has no scattering and is compared without any. "
                "Both know other things that are not asked of them here."};
    for (const Medium& medium : media_) {
        Plot plot{.name = "peers_" + medium.scene.name,
            .question = "Error against time, beside Cycles: " + medium.scene.name,
            .x = {"cpu_seconds", "processor time (s)", true, Better::less},
            .y = {"relmse", "relMSE", true, Better::less},
            .caption = "Cycles: the render call after a first one of one sample, with its "
                       "preparation; without Blender's start."};
        for (const char* series : {kOurs, kBlender})
            plot.curves.push_back(curve(points, medium.scene.name, series, plot, series));
        section.plots.push_back(std::move(plot));
    }
    Plot plot{.name = "peers_absorbing_cloud",
        .question = "Error against time, beside VTK: a cloud that only absorbs",
        .x = {"cpu_seconds", "processor time (s)", true, Better::less},
        .y = {"relmse", "relMSE", true, Better::less},
        .caption =
            "Before a white world, albedo 0: what VTK's ray caster "
            "(<code>vtkFixedPointVolumeRayCastMapper</code>) and this program both know. VTK "
            "marches in equal steps of 8 to 1/4 voxels, of which it has an error for good, "
            "like that of 15-bit opacities and of a window of 8 bits per channel; one ray "
            "through each pixel's centre, or 16 averaged. The reference is the mean of 64 rays per "
            "pixel in double precision on the host. Path tracing knows no step, converges, and "
            "would scatter in "
            "the same time; for a medium that does not, marching is the better tool."};
    for (const char* series : {kOurs, kVtk, kVtkFine})
        plot.curves.push_back(curve(points, absorber_.scene.name, series, plot, series));
    section.plots.push_back(std::move(plot));
    section.tables = {equal_error_table(points), surface_table(points)};
    return section;
}

} // namespace

std::unique_ptr<Suite> make_peers_suite(Context& context) {
    return std::make_unique<PeersSuite>(context);
}

} // namespace ockham::chart
