// SPDX-License-Identifier: Apache-2.0
#include "samples/chart/peers_suite.hpp"

#include "framework/core/error.hpp"
#include "framework/core/file.hpp"
#include "framework/core/timer.hpp"
#include "framework/image_error/image_error.hpp"
#include "framework/io/image_file.hpp"
#include "framework/io/volume_file.hpp"
#include "samples/chart/volume_runs.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <sys/wait.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace ockham::chart {
namespace {

constexpr std::uint32_t kSide = 64;
constexpr const char* kBlender = "Cycles";
constexpr const char* kOurs = "path";
/// As cycles_volume.py looks: from +z, one radian high.
constexpr const char* kCamera = "0,0,2 0,0,0 57.29577951";
/// Debian's own, for Debian's modules: another that comes first in PATH lacks them.
constexpr const char* kPython = "/usr/bin/python3";
const std::filesystem::path kScripts = OCKHAM_TRUTH_DIR;

bool in_path(const std::string& program) {
    const char* path = std::getenv("PATH");
    std::string folders = path == nullptr ? "" : path;
    for (std::size_t begin = 0; begin < folders.size();) {
        const std::size_t end = std::min(folders.find(':', begin), folders.size());
        std::error_code error;
        if (std::filesystem::exists(
                std::filesystem::path(folders.substr(begin, end - begin)) / program, error))
            return true;
        begin = end + 1;
    }
    return false;
}

struct Output {
    int status = 0;
    std::string text; ///< stdout and stderr
};

Output run(const std::vector<std::string>& words) {
    std::string command;
    for (const std::string& word : words) {
        command += '\'';
        for (const char c : word) command += c == '\'' ? std::string("'\\''") : std::string(1, c);
        command += "' ";
    }
    Output output;
    std::FILE* pipe = ::popen((command + "2>&1 </dev/null").c_str(), "r");
    if (pipe == nullptr) fail_input("cannot start '{}'", words.front());
    char part[4096];
    while (std::fgets(part, sizeof(part), pipe) != nullptr) output.text += part;
    output.status = ::pclose(pipe);
    return output;
}

/// The line of JSON after "RESULT " that the scripts of tests/truth print.
nlohmann::json result_of(const std::vector<std::string>& words) {
    const Output output = run(words);
    const std::size_t begin = output.text.rfind("RESULT ");
    if (!WIFEXITED(output.status) || WEXITSTATUS(output.status) != 0 ||
        begin == std::string::npos) {
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
    void add_medium(const Medium& medium);
    std::vector<Row> cycles(const Medium& medium);
    std::vector<Row> surface();
    Table equal_error_table(const std::vector<Point>& points) const;
    Table surface_table(const std::vector<Point>& points) const;

    Context& context_;
    VolumeReferences references_;
    std::vector<Medium> media_;
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
    if (!in_path("blender")) return "blender is not installed: apt-get install blender";
    const Output modules = run({kPython, "-c", "import vtk, OpenImageIO, numpy"});
    if (modules.status != 0)
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

void PeersSuite::add_medium(const Medium& medium) {
    list_.add(job(medium.scene, kOurs, "--mode path", 0), [this, medium] {
        VolumeGiParams params;
        params.width = params.height = kSide;
        return std::make_unique<VolumeRun>(context_.device(), medium.scene, params,
            references_.of(medium.scene, VolumeMode::path), context_.options.quick ? 0.8 : 12);
    });
    Job theirs = job(medium.scene, kBlender, "", 0);
    theirs.command =
        fmt::format("blender -b --factory-startup -P tests/truth/cycles_volume.py -- '{}'",
            medium.cycles.dump());
    list_.add(theirs, [this, medium] {
        return std::make_unique<Once>([this, medium](auto&) { return cycles(medium); });
    });
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
                "by VTK. Both know other things that are not asked of them here."};
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
    section.tables = {equal_error_table(points), surface_table(points)};
    return section;
}

} // namespace

std::unique_ptr<Suite> make_peers_suite(Context& context) {
    return std::make_unique<PeersSuite>(context);
}

} // namespace ockham::chart
