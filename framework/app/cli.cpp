// SPDX-License-Identifier: Apache-2.0
#include "framework/app/cli.hpp"

#include "framework/core/error.hpp"
#include "framework/core/file.hpp"
#include "framework/core/json_object.hpp"
#include "framework/core/log.hpp"
#include "framework/core/version.hpp"
#include "framework/gpu/pipeline.hpp"
#include "framework/gpu/shader_folder.hpp"

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <new>
#include <sstream>

namespace ockham {
namespace {

volatile std::sig_atomic_t interrupt_seen = 0;

void on_interrupt(int) {
    interrupt_seen = 1;
    std::signal(SIGINT, SIG_DFL);
}

/// Help text of one parameter: what it is, what it may be, what it is by default.
std::string help_of(const Param& param) {
    std::string text = param.help;
    if (!param.allowed.empty()) text += fmt::format(" [{}]", fmt::join(param.allowed, "|"));
    const std::string& unit = param.unit_name;
    if (std::isfinite(param.low) || std::isfinite(param.high)) {
        text += fmt::format("; {} ... {}{}", param.low, param.high, unit.empty() ? "" : " " + unit);
    } else if (!unit.empty()) {
        text += fmt::format(" ({})", unit);
    }
    if (!param.is_flag() && !param.default_text.empty()) {
        text += fmt::format("; default {}", param.default_text);
    }
    return text;
}

void add_option(CLI::App& app, Param& param) {
    const std::string flag =
        (param.alias != 0 ? fmt::format("-{},", param.alias) : "") + "--" + param.name;
    CLI::Option* option = nullptr;
    if (param.is_positional) {
        option = app.add_option_function<std::vector<std::string>>(
            param.name,
            [&param](const std::vector<std::string>& values) {
                for (const std::string& value : values) param.set(value);
            },
            help_of(param));
    } else if (param.is_flag()) {
        option = app.add_flag_callback(
            flag, [&param] { param.set("on"); }, help_of(param));
    } else {
        option = app.add_option_function<std::vector<std::string>>(
            flag,
            [&param](const std::vector<std::string>& values) {
                if (!param.is_list() && values.size() > 1) {
                    fail_input("--{}: given {} times, expected once", param.name, values.size());
                }
                for (const std::string& value : values) param.set(value);
            },
            help_of(param));
        option->type_name(param.is_list() ? "TEXT ..." : "")->expected(1);
        option->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
        option->allow_extra_args(false); // the next word is a scene, not a second value
    }
    if (!param.group_name.empty()) option->group(param.group_name);
}

double now_seconds() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

} // namespace

void add_run_flags(Params& params, CommonOptions& o) {
    const char* kRun = "Run";
    params.add("gpu", &o.gpu, "device, by index or part of its name").group(kRun);
    params.add("list-gpus", &o.list_gpus, "list the devices with their scores, and stop")
        .group(kRun)
        .transient();
    params.add("validation", &o.validation, "Vulkan validation; any message is an error")
        .choices({"off", "core", "sync", "gpu"})
        .group(kRun);
    params
        .add("shader-dir", &o.shader_dir,
            "folder of GLSL in place of built-in shaders of the same name, watched for changes")
        .group(kRun);
    params
        .add("memory-budget", &o.memory_budget,
            "device memory to use at most; 0: what the device reports")
        .range(0, 1 << 30)
        .unit("MiB")
        .group(kRun);
    params.add("strict", &o.strict, "refuse what is otherwise tolerated with a warning")
        .group(kRun);
    params
        .add("allow-external", &o.allow_external,
            "let scene files name resources outside their folder")
        .group(kRun);
    params.add("config", &o.config, "JSON run file with parameters; the command line wins")
        .group(kRun)
        .transient();
    params.add("dump-config", &o.dump_config, "write all parameters as a run file, and stop")
        .group(kRun)
        .transient();
    params.add("quiet", &o.quiet, "print warnings and errors only").group(kRun);
    params.add("version", &o.version, "print the version, and stop").group(kRun).transient();
}

void add_view_flags(Params& params, CommonOptions& o) {
    const char* kPicture = "Picture";
    params.add("width", &o.width, "picture width").range(1, 16384).unit("pixels").group(kPicture);
    params.add("height", &o.height, "picture height")
        .range(1, 16384)
        .unit("pixels")
        .group(kPicture);
    params
        .add("camera", &o.camera,
            "\"px,py,pz tx,ty,tz fov\" (vertical, degrees) or the name of a scene's camera")
        .group(kPicture);
    params.add("orthographic", &o.orthographic, "orthographic view of this height; 0: perspective")
        .range(0, 1e9)
        .unit("world units")
        .group(kPicture);
}

void add_output_flags(Params& params, CommonOptions& o) {
    const char* kPicture = "Picture";
    const char* kReport = "Reports";
    params.add("output", &o.output, "picture to write: .exr (linear) or .png (sRGB)")
        .letter('o')
        .group(kPicture)
        .transient();
    params.add("exposure", &o.exposure, "exposure of .png files")
        .range(-32, 32)
        .unit("stops")
        .group(kPicture);
    params.add("tonemap", &o.tonemap, "tone curve of .png files")
        .choices({"none", "aces"})
        .group(kPicture);
    params.add("stats", &o.stats, "JSON file with times, memory, samples and image error")
        .group(kReport)
        .transient();
    params
        .add("trace", &o.trace, "JSON file with the GPU times of all frames as Chrome trace events")
        .group(kReport)
        .transient();
    params.add("plan", &o.plan, "file with the graph's plan: .txt, .json, .dot or .html")
        .group(kReport)
        .transient();
    params.add("explain", &o.explain, "print why each pass and resource is there or absent")
        .group(kReport)
        .transient();
    params
        .add("capture", &o.captures,
            "NAME=FILE: write an intermediate image (.exr; .png: false colour); repeatable")
        .group(kReport)
        .transient();
    params.add("reference", &o.reference, "picture (.exr or .png) to measure the error against")
        .group(kReport)
        .transient();
}

void add_frames_flag(Params& params, CommonOptions& o) {
    params
        .add("frames", &o.frames,
            "executions of the graph; default 1, with --stats 5 after one that warms up")
        .range(1, 1000000)
        .group("Run");
}

std::optional<int> parse_command_line(
    int argc, char** argv, const std::string& description, Params& params, CommonOptions& options) {
    CLI::App app{description};
    app.get_formatter()->column_width(32);
    for (Param* param : params.all()) add_option(app, *param);
    try {
        app.parse(argc, argv);
    } catch (const CLI::CallForHelp&) {
        fmt::print("{}", app.help());
        return 0;
    } catch (const CLI::ParseError& error) {
        fail_input("{}; --help lists all flags", error.what());
    }
    if (options.version) {
        fmt::print("Ockham {} ({})\n", version(), commit());
        return 0;
    }
    if (options.list_gpus) {
        fmt::print("{}", gpu::list_gpus());
        return 0;
    }
    if (!options.config.empty()) {
        params.from_json(
            parse_json(options.config, "run file"), fmt::format("'{}'", options.config));
    }
    if (!options.dump_config.empty()) {
        write_text(options.dump_config,
            params.to_json().dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
        return 0;
    }
    if (options.quiet) log::set_level(log::Level::warning);
    if (!options.stats.empty() && !params.given("frames")) options.frames = 5;
    return {};
}

int run_program(const std::function<int()>& body) {
    std::signal(SIGINT, on_interrupt);
    std::signal(SIGXFSZ, SIG_IGN); // a file size limit then shows as a failed write
    try {
        return body();
    } catch (const Error& error) {
        log::error("{}", error.what());
        return error.exit_code();
    } catch (const std::bad_alloc&) {
        log::error("out of memory; use a smaller picture or scene");
        return 3;
    } catch (const std::exception& error) {
        log::error("{}", error.what());
        return 2;
    }
}

bool interrupted() { return interrupt_seen != 0; }

gpu::DeviceOptions device_options(const CommonOptions& options) {
    gpu::DeviceOptions device;
    device.gpu = options.gpu;
    device.memory_budget_bytes = static_cast<std::uint64_t>(options.memory_budget) << 20;
    device.validation = options.validation == "core"   ? gpu::Validation::core
                        : options.validation == "sync" ? gpu::Validation::sync
                        : options.validation == "gpu"  ? gpu::Validation::gpu
                                                       : gpu::Validation::off;
    return device;
}

void watch_shaders(gpu::Device& device, const CommonOptions& options) {
    if (options.shader_dir.empty()) return;
    device.pipelines().reload_from(std::make_unique<gpu::ShaderFolder>(options.shader_dir));
}

void reload_shaders(gpu::Device& device) { device.pipelines().reload(); }

void expect_no_validation_messages(const gpu::Device& device) {
    const std::vector<std::string> messages = device.validation_messages();
    if (!messages.empty()) {
        fail_device("validation found {} problems, first: {}", messages.size(), messages.front());
    }
}

std::vector<float> parse_numbers(const std::string& text, char separator) {
    std::vector<float> numbers;
    std::istringstream stream(text);
    std::string word;
    while (std::getline(stream, word, separator)) {
        char* end = nullptr;
        const float value = std::strtof(word.c_str(), &end);
        if (word.empty() || *end != 0 || !std::isfinite(value)) return {};
        numbers.push_back(value);
    }
    return numbers;
}

glm::vec3 parse_color(const std::string& flag, const std::string& text) {
    const std::vector<float> c = parse_numbers(text);
    if (c.size() != 3 || !(c[0] >= 0 && c[1] >= 0 && c[2] >= 0))
        fail_input("--{}: found '{}', expected r,g,b, each at least 0", flag, text);
    return {c[0], c[1], c[2]};
}

std::optional<Camera> parse_camera(const std::string& text, UpAxis up) {
    std::istringstream words(text);
    std::string position_text, target_text, fov_text, more;
    words >> position_text >> target_text >> fov_text >> more;
    const std::vector<float> p = parse_numbers(position_text), t = parse_numbers(target_text),
                             f = parse_numbers(fov_text);
    if (p.size() != 3 || t.size() != 3 || f.size() != 1 || !more.empty()) return {};
    const glm::vec3 position(p[0], p[1], p[2]), target(t[0], t[1], t[2]);
    const float square = glm::dot(target - position, target - position);
    if (!(square > 1e-30f)) fail_input("--camera: position and target are both {}", position_text);
    if (!std::isfinite(square))
        fail_input(
            "--camera: position {} and target {} are too far apart", position_text, target_text);
    if (!(f[0] > 0.0f && f[0] < 180.0f))
        fail_input("--camera: found a field of view of {} degrees, expected 0 to 180", f[0]);
    return look_at(position, target, f[0], up);
}

Camera choose_camera(const CommonOptions& options, const Scene& scene, const Bounds& bounds) {
    Camera camera = scene.cameras.empty() ? default_camera(bounds) : scene.cameras.front();
    if (!options.camera.empty()) {
        const auto named = std::find_if(scene.cameras.begin(), scene.cameras.end(),
            [&](const Camera& c) { return c.name == options.camera; });
        if (named != scene.cameras.end()) {
            camera = *named;
        } else if (const std::optional<Camera> given = parse_camera(options.camera, UpAxis::y)) {
            camera = *given;
        } else {
            std::vector<std::string> names;
            for (const Camera& c : scene.cameras) names.push_back("'" + c.name + "'");
            fail_input("--camera: found '{}', expected \"px,py,pz tx,ty,tz fov\" or a camera of "
                       "the scene ({})",
                options.camera,
                names.empty() ? "it has none" : fmt::format("{}", fmt::join(names, ", ")));
        }
    }
    if (options.orthographic > 0.0f) camera.orthographic_height = options.orthographic;
    return camera;
}

std::vector<std::pair<std::string, std::string>> parse_captures(const CommonOptions& options) {
    std::vector<std::pair<std::string, std::string>> captures;
    for (const std::string& text : options.captures) {
        const std::size_t equals = text.find('=');
        if (equals == std::string::npos || equals == 0 || equals + 1 == text.size()) {
            fail_input("--capture: found '{}', expected NAME=FILE", text);
        }
        captures.emplace_back(text.substr(0, equals), text.substr(equals + 1));
    }
    return captures;
}

Progress::Progress(std::string what, std::size_t steps, bool quiet)
    : what_(std::move(what)), steps_(steps),
      active_(!quiet && steps > 1 && ::isatty(STDERR_FILENO)), start_(now_seconds()) {}

Progress::~Progress() {
    if (active_) fmt::print(stderr, "\r\033[K");
}

void Progress::update(std::size_t done) {
    if (!active_) return;
    const double elapsed = now_seconds() - start_;
    const double left =
        done == 0 ? 0 : elapsed * static_cast<double>(steps_ - done) / static_cast<double>(done);
    fmt::print(stderr, "\r\033[K{} {}/{} ({} %), {:.0f} s left", what_, done, steps_,
        100 * done / steps_, left);
    std::fflush(stderr);
}

} // namespace ockham
