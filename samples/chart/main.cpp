// SPDX-License-Identifier: Apache-2.0
// chart: measures speed against accuracy and draws it: CSV, SVG and one HTML page. README.md beside
// this file has examples, docs/chart.md says how to read the result.
#include "framework/app/report.hpp"
#include "framework/core/error.hpp"
#include "framework/core/log.hpp"
#include "framework/core/version.hpp"
#include "samples/chart/aa_suite.hpp"
#include "samples/chart/graph_suite.hpp"
#include "samples/chart/papers_suite.hpp"
#include "samples/chart/peers_suite.hpp"
#include "samples/chart/stability_suite.hpp"
#include "samples/chart/suite.hpp"
#include "samples/chart/volume_suite.hpp"

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <set>

using namespace ockham;
using namespace ockham::chart;

namespace {

struct Kind {
    const char* name;
    std::unique_ptr<Suite> (*make)(Context&);
};
/// In the order of the page.
constexpr Kind kSuites[] = {{"aa", make_aa_suite}, {"volume", make_volume_suite},
    {"papers", make_papers_suite}, {"stability", make_stability_suite}, {"graph", make_graph_suite},
    {"peers", make_peers_suite}};

std::string suite_names() {
    std::string names;
    for (const Kind& kind : kSuites) names += std::string(kind.name) + ", ";
    return names + "all";
}

/// The words of comma-separated texts.
std::vector<std::string> words(const std::vector<std::string>& texts) {
    std::vector<std::string> result;
    for (const std::string& text : texts) {
        for (std::size_t begin = 0; begin <= text.size();) {
            const std::size_t end = std::min(text.find(',', begin), text.size());
            if (end > begin) result.push_back(text.substr(begin, end - begin));
            begin = end + 1;
        }
    }
    return result;
}

/// Those asked for. One that cannot run here is refused if it was asked for by name, else left out
/// with a warning.
std::vector<std::unique_ptr<Suite>> make_suites(
    const std::vector<std::string>& names, Context& context, Manifest& manifest) {
    for (const std::string& name : names) {
        const bool known =
            name == "all" || std::any_of(std::begin(kSuites), std::end(kSuites),
                                 [&](const Kind& kind) { return kind.name == name; });
        if (!known) fail_input("--suite: '{}' is none of {}", name, suite_names());
    }
    std::vector<std::unique_ptr<Suite>> suites;
    for (const Kind& kind : kSuites) {
        const bool by_name = std::find(names.begin(), names.end(), kind.name) != names.end();
        if (!by_name && std::find(names.begin(), names.end(), "all") == names.end()) continue;
        std::unique_ptr<Suite> suite = kind.make(context);
        const std::string obstacle = suite->obstacle();
        if (obstacle.empty()) {
            suites.push_back(std::move(suite));
        } else if (by_name) {
            fail_input("--suite {}: {}", kind.name, obstacle);
        } else {
            log::warning("suite {} is left out: {}", kind.name, obstacle);
            manifest.emplace_back("left out", fmt::format("{}: {}", kind.name, obstacle));
        }
    }
    return suites;
}

std::string load_average() {
    double load[3] = {};
    if (::getloadavg(load, 3) != 3) return "unknown";
    return fmt::format("{:.2f}, {:.2f}, {:.2f} (1, 5, 15 minutes)", load[0], load[1], load[2]);
}

std::string now() {
    const std::time_t time = std::time(nullptr);
    char text[64] = {};
    std::strftime(text, sizeof(text), "%Y-%m-%d %H:%M UTC", std::gmtime(&time));
    return text;
}

/// Each measurement loads its volume anew, but what a loader inferred is news once.
void tell_once() {
    log::set_sink([told = std::set<std::string, std::less<>>()](
                      log::Level level, std::string_view text) mutable {
        if (level <= log::Level::info && !told.emplace(text).second) return;
        const char* prefix = level == log::Level::warning ? "warning: "
                             : level == log::Level::error ? "error: "
                                                          : "";
        fmt::print(stderr, "{}{}\n", prefix, text);
    });
}

int run(int argc, char** argv) {
    ChartOptions o;
    std::vector<std::string> names;
    std::string out = "chart";
    Params params;
    const auto add = [&](const char* name, Param::Target target,
                         const std::string& help) -> Param& {
        return params.add(name, target, help).group("Chart");
    };
    add("suite", &names, "what to measure: " + suite_names() + "; several by commas");
    add("scenes", &o.scenes, ".gltf, .glb or builtin: scenes of suite aa, by commas");
    add("rig", &o.rig, "camera, background and lights of scenes that are files, as JSON");
    add("volumes", &o.volumes, "files or builtin: names of suite volume, by commas");
    add("out", &out, "folder for measurements, CSV, SVG and index.html; run again, it continues")
        .transient();
    add("target-psnr", &o.target_psnr,
        "suite aa: mark the setting that reaches so many decibels; 0: none")
        .range(0, 200)
        .unit("dB");
    add("target-ms", &o.target_ms, "suite aa: mark the best that takes so long; 0: none")
        .range(0, 1e9)
        .unit("ms");
    add("ffmpeg", &o.ffmpeg, "an FFmpeg with libvmaf, for VMAF; none: $OCKHAM_FFMPEG, else ffmpeg");
    add("vmaf-model", &o.vmaf_model,
        "model of VMAF, .json or .pkl; none: $OCKHAM_VMAF_MODEL, else libvmaf's own");
    add("onnx", &o.onnx, "network that compares two pictures, such as LPIPS; none: not measured");
    add("quick", &o.quick, "small pictures and few settings");
    add("repeats", &o.repeats, "executions of each setting").range(1, 1000);
    o.common.width = 512, o.common.height = 384;
    add("width", &o.common.width, "of pictures; with --quick 192").range(1, 16384).unit("pixels");
    add("height", &o.common.height, "of pictures; with --quick 144").range(1, 16384).unit("pixels");
    add_run_flags(params, o.common);
    if (const auto done =
            parse_command_line(argc, argv, "Charts speed against accuracy.", params, o.common)) {
        return *done;
    }
    names = words(names);
    if (names.empty()) fail_input("--suite is missing: one or several of {}", suite_names());
    o.scenes = words(o.scenes);
    o.volumes = words(o.volumes);
    o.out = out;
    if (o.quick && !params.given("width")) o.common.width = 192;
    if (o.quick && !params.given("height")) o.common.height = 144;
    if (o.quick && !params.given("repeats")) o.repeats = 3;

    tell_once();
    Context context(o);
    Manifest manifest{{"command", command_text(argc, argv)},
        {"program", fmt::format("Ockham {}, commit {}", version(), commit())},
        {"processor", cpu_name()}};
    for (const auto& line : context.metrics().manifest()) manifest.push_back(line);
    const std::vector<std::unique_ptr<Suite>> suites = make_suites(names, context, manifest);
    for (const auto& suite : suites)
        (void)suite->jobs(); // refuses bad input before a folder is made
    Store store(o.out);
    manifest.emplace_back("load average before", load_average());
    const bool complete = run_suites(suites, context, store);
    if (context.has_device()) expect_no_validation_messages(context.device());
    if (!complete) {
        log::info("interrupted; the same command continues");
        return 130;
    }
    manifest.emplace_back("load average after", load_average());
    if (context.has_device()) manifest.emplace_back("device", context.device_text());
    manifest.emplace_back("date", now());

    std::vector<Section> sections;
    for (const auto& suite : suites) {
        const std::vector<Job> jobs = suite->jobs();
        sections.push_back(suite->report(store, points_of(store, jobs)));
        if (auto table = context.metrics().table(suite->name(), sections.back().wipes))
            sections.back().tables.push_back(std::move(*table));
    }
    write_page(o.out, "Speed against accuracy", sections, manifest);
    fmt::print("{}\n", (o.out / "index.html").string());
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    return run_program([&] { return run(argc, argv); });
}
