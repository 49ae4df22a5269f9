// SPDX-License-Identifier: Apache-2.0
// compare A B: every image metric of picture A against reference B, error maps, and false-colour
// pictures of single channels (samples per pixel, depth, ...). Runs on the CPU alone.
#include "framework/core/error.hpp"
#include "framework/core/false_color.hpp"
#include "framework/core/file.hpp"
#include "framework/core/log.hpp"
#include "framework/image_error/image_error.hpp"
#include "framework/io/image_file.hpp"
#include "samples/metrics/network_metric.hpp"
#include "samples/metrics/vmaf.hpp"

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace {

using namespace ockham;

struct Arguments {
    std::string test, reference;
    std::string error_map, flip_map, side_by_side, json, heat;
    float scale = 10;
    std::vector<float> range;
    bool vmaf = false;
    std::string ffmpeg, vmaf_model, onnx;
};

/// What other programs and networks say, by name; `key` is that of --json.
struct Opinion {
    std::string key, title, made_by;
    double value = 0;
};

/// JSON has no infinity: equal pictures get 999.
double finite_psnr(double psnr) { return std::isinf(psnr) ? 999.0 : psnr; }

void print(const Arguments& arguments, const Image& test, const ImageError& error) {
    fmt::print("test       {}\nreference  {}\nsize       {} x {}\n\n", arguments.test,
        arguments.reference, test.width(), test.height());
    const auto row = [](const char* name, double value, const char* meaning) {
        fmt::print("{:<10} {:<12.6g} {}\n", name, value, meaning);
    };
    row("MSE", error.mse, "sRGB-encoded [0,1], mean over pixels and R, G, B");
    row("PSNR", error.psnr, "dB, peak 1");
    row("max", error.max, "sRGB-encoded [0,1], largest absolute difference");
    row("p99", error.p99, "sRGB-encoded [0,1], 99 % of the pixels differ by at most this");
    row("SSIM", error.ssim, "luma, Gaussian window, 1 = equal");
    row("SSIM RGB", error.ssim_rgb, "mean of R, G, B, 1 = equal");
    row("FLIP", error.flip.mean, "mean, 67 pixels per degree, 0 = equal");
    row("FLIP max", error.flip.max, "0 = equal");
    row("relMSE", error.relmse, "linear, divided by reference^2 + 0.01");
    if (error.hdr_flip) {
        row("HDR-FLIP", error.hdr_flip->mean,
            fmt::format("mean, {} exposures from {:+.4f} to {:+.4f} EV, 0 = equal",
                error.hdr_flip->exposures, error.hdr_flip->start_exposure,
                error.hdr_flip->stop_exposure)
                .c_str());
    }
    if (error.non_finite > 0) {
        fmt::print("\n{} of {} pixels of the test picture are NaN or infinite; each counts as an "
                   "error of 1\n",
            error.non_finite, test.pixels());
    }
}

void print(const std::vector<Opinion>& opinions) {
    for (const Opinion& opinion : opinions)
        fmt::print("{:<10} {:<12.6g} {}\n", opinion.title, opinion.value, opinion.made_by);
}

nlohmann::json to_json(const Arguments& arguments, const Image& test, const ImageError& error,
    const std::vector<Opinion>& opinions) {
    nlohmann::json json{{"test", arguments.test}, {"reference", arguments.reference},
        {"width", test.width()}, {"height", test.height()}, {"mse", error.mse},
        {"psnr", finite_psnr(error.psnr)}, {"max", error.max}, {"p99", error.p99},
        {"ssim", error.ssim}, {"ssim_rgb", error.ssim_rgb}, {"flip", error.flip.mean},
        {"flip_max", error.flip.max}, {"relmse", error.relmse}, {"hdr", error.hdr},
        {"non_finite", error.non_finite}};
    if (error.hdr_flip) json["hdr_flip"] = error.hdr_flip->mean;
    for (const Opinion& opinion : opinions) {
        json[opinion.key] = opinion.value;
        json[opinion.key + "_by"] = opinion.made_by;
    }
    return json;
}

std::vector<std::uint8_t> error_colors(const ImageError& error, float scale) {
    return false_color(error.map.plane(0), 0.0f, 1.0f / scale);
}

/// Test, reference and error map from left to right.
void save_side_by_side(const std::string& path, const Image& test, const Image& reference,
    const std::vector<std::uint8_t>& error_map) {
    const int width = test.width();
    Image panels(3 * width, test.height(), {"R", "G", "B"});
    constexpr const char* kColors[] = {"R", "G", "B"};
    for (int c = 0; c < 3; ++c) {
        const int test_channel = test.find(kColors[c]).value();
        const int reference_channel = reference.find(kColors[c]).value();
        for (int y = 0; y < test.height(); ++y) {
            for (int x = 0; x < width; ++x) {
                const std::size_t byte =
                    3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                            static_cast<std::size_t>(x)) +
                    static_cast<std::size_t>(c);
                panels.at(x, y, c) = test.at(x, y, test_channel);
                panels.at(x + width, y, c) = reference.at(x, y, reference_channel);
                panels.at(x + 2 * width, y, c) =
                    srgb_decode(static_cast<float>(error_map[byte]) / 255.0f);
            }
        }
    }
    save_png8(path, panels);
}

/// Smallest and largest finite value; 0, 0 for none.
std::pair<float, float> range_of(std::span<const float> values) {
    std::pair<float, float> range{0.0f, 0.0f};
    bool first = true;
    for (const float value : values) {
        if (!std::isfinite(value)) continue;
        if (first) range = {value, value};
        first = false;
        range = {std::min(range.first, value), std::max(range.second, value)};
    }
    return range;
}

/// `heat` is CHANNEL=FILE.
std::pair<std::string, std::string> split_heat(const std::string& heat) {
    const std::size_t equals = heat.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == heat.size()) {
        fail_input("--heat: expected CHANNEL=FILE.png, found '{}'", heat);
    }
    return {heat.substr(0, equals), heat.substr(equals + 1)};
}

void save_heat(const Arguments& arguments, const Image& image) {
    const auto [channel, path] = split_heat(arguments.heat);
    if (!image.find(channel)) {
        fail_input("--heat: '{}' has no channel '{}', only {}", arguments.test, channel,
            fmt::join(image.channels(), ", "));
    }
    const std::span<const float> values = image.plane(channel);
    const auto [low, high] = arguments.range.empty()
                                 ? range_of(values)
                                 : std::pair{arguments.range[0], arguments.range[1]};
    save_png_srgb(path, image.width(), image.height(), false_color(values, low, high));
    fmt::print("{}: channel {} from {:g} (dark) to {:g} (light)\n", path, channel, low, high);
}

/// Refuses bad outputs before anything is computed or written.
void check_outputs(const Arguments& arguments) {
    std::vector<std::string> pictures{
        arguments.error_map, arguments.flip_map, arguments.side_by_side};
    if (!arguments.heat.empty()) pictures.push_back(split_heat(arguments.heat).second);
    for (const std::string& path : pictures) {
        if (path.empty()) continue;
        if (is_exr_path(path)) fail_input("'{}': this picture can only be written as .png", path);
        check_writable(path);
    }
    if (!arguments.json.empty()) check_writable(arguments.json);
    if (arguments.reference.empty()) {
        if (arguments.heat.empty()) fail_input("a reference is missing: compare TEST REFERENCE");
        if (!arguments.error_map.empty() || !arguments.flip_map.empty() ||
            !arguments.side_by_side.empty() || !arguments.json.empty() || arguments.vmaf ||
            !arguments.onnx.empty()) {
            fail_input("only --heat works without a reference");
        }
    }
    if (!arguments.vmaf && !(arguments.ffmpeg.empty() && arguments.vmaf_model.empty()))
        fail_input("--ffmpeg and --vmaf-model are for --vmaf");
    if (!(arguments.scale > 0) || std::isinf(arguments.scale)) {
        fail_input("--scale: expected a number above 0, found {}", arguments.scale);
    }
    if (!arguments.range.empty() && !(arguments.range[0] < arguments.range[1])) {
        fail_input("--range: expected LOW,HIGH with LOW below HIGH, found {},{}",
            arguments.range[0], arguments.range[1]);
    }
}

void run(const Arguments& arguments) {
    check_outputs(arguments);
    std::optional<Vmaf> vmaf;
    std::optional<NetworkMetric> network;
    if (arguments.vmaf) vmaf.emplace(arguments.ffmpeg, arguments.vmaf_model);
    if (!arguments.onnx.empty()) network.emplace(arguments.onnx);
    const Image test = load_image(arguments.test);
    if (!arguments.reference.empty()) {
        const Image reference = load_image(arguments.reference);
        const ImageError error = image_error(test, reference);
        print(arguments, test, error);
        std::vector<Opinion> opinions;
        if (vmaf) opinions.push_back({"vmaf", "VMAF", vmaf->made_by(), (*vmaf)(test, reference)});
        if (network)
            opinions.push_back(
                {"network", "network", network->name(), (*network)(test, reference)});
        print(opinions);
        const std::vector<std::uint8_t> colors = error_colors(error, arguments.scale);
        if (!arguments.error_map.empty()) {
            save_png_srgb(arguments.error_map, test.width(), test.height(), colors);
        }
        if (!arguments.flip_map.empty()) {
            save_png_srgb(arguments.flip_map, test.width(), test.height(),
                false_color(error.flip.map.plane(0), 0.0f, 1.0f));
        }
        if (!arguments.side_by_side.empty()) {
            save_side_by_side(arguments.side_by_side, test, reference, colors);
        }
        if (!arguments.json.empty()) {
            write_text(arguments.json, to_json(arguments, test, error, opinions).dump(2) + "\n");
        }
    }
    if (!arguments.heat.empty()) save_heat(arguments, test);
    if (std::fflush(stdout) != 0) fail_input("cannot write the results to standard output");
}

} // namespace

int main(int argc, char** argv) {
    Arguments arguments;
    CLI::App app{"Image metrics of a picture against a reference, error maps, and false-colour "
                 "pictures of single channels. Exit code: 0 done, 2 bad input or output."};
    app.add_option("test", arguments.test, "picture, .exr or .png")->required();
    app.add_option("reference", arguments.reference, "reference of the same size, .exr or .png");
    app.add_option("--error-map", arguments.error_map,
        "PNG of the largest difference of R, G, B per pixel, times --scale");
    app.add_option("--scale", arguments.scale, "error that is drawn lightest is 1 / scale [10]");
    app.add_option("--flip-map", arguments.flip_map, "PNG of LDR-FLIP, from 0 to 1");
    app.add_option("--side-by-side", arguments.side_by_side, "PNG of test, reference, error map");
    app.add_option("--json", arguments.json, "all metrics as JSON; an infinite PSNR is 999");
    app.add_flag("--vmaf", arguments.vmaf, "VMAF too, by an FFmpeg that has libvmaf");
    app.add_option("--ffmpeg", arguments.ffmpeg, "that FFmpeg [$OCKHAM_FFMPEG, else ffmpeg]");
    app.add_option("--vmaf-model", arguments.vmaf_model,
        "model of VMAF, .json or .pkl [$OCKHAM_VMAF_MODEL, else libvmaf's own]");
    app.add_option("--onnx", arguments.onnx,
        "ONNX file of a network that compares two pictures, such as LPIPS: its distance too");
    app.add_option("--heat", arguments.heat,
        "CHANNEL=FILE.png: a channel of the test picture in false colour; needs no reference");
    app.add_option("--range", arguments.range, "LOW,HIGH of --heat [smallest,largest value]")
        ->delimiter(',')
        ->expected(2);
    try {
        app.parse(argc, argv);
        run(arguments);
        return 0;
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : 2;
    } catch (const Error& error) {
        log::error("{}", error.what());
        return error.exit_code();
    } catch (const std::exception& error) {
        log::error("{}", error.what());
        return 2;
    }
}
