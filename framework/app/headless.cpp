// SPDX-License-Identifier: Apache-2.0
#include "framework/app/headless.hpp"

#include "framework/core/error.hpp"
#include "framework/core/file.hpp"
#include "framework/core/log.hpp"
#include "framework/core/version.hpp"
#include "framework/graph/explain/explain.hpp"
#include "framework/io/image_file.hpp"

#include <nlohmann/json.hpp>

#include <set>

namespace ockham {
namespace {

void check_outputs(const CommonOptions& o, const std::vector<std::string>& more) {
    std::vector<std::string> files{o.stats, o.plan, o.trace};
    files.insert(files.end(), more.begin(), more.end());
    if (!o.output.empty()) {
        is_exr_path(o.output);
        files.push_back(numbered(o.output, 0));
    }
    for (const auto& [name, file] : parse_captures(o)) {
        is_exr_path(file);
        files.push_back(file);
    }
    if (!o.plan.empty()) check_plan_path(o.plan);
    std::set<std::string> seen;
    for (const std::string& file : files) {
        if (file.empty()) continue;
        check_writable(file);
        if (!seen.insert(file).second) fail_input("'{}' is named as two outputs", file);
    }
}

Image load_reference(const CommonOptions& o, const std::string& file) {
    Image reference = load_image(file);
    if (reference.width() != o.width || reference.height() != o.height) {
        fail_input("--reference: '{}' has {} x {} pixels, the picture {} x {}", file,
            reference.width(), reference.height(), o.width, o.height);
    }
    return reference;
}

/// Where a name has %d or %0Nd: its place, its length and N.
struct NumberField {
    std::size_t at = std::string::npos, length = 0;
    int digits = 0;
};

NumberField find_number(const std::string& name) {
    for (std::size_t at = name.find('%'); at != std::string::npos; at = name.find('%', at + 1)) {
        if (name.compare(at, 2, "%d") == 0) return {at, 2, 0};
        const std::string field = name.substr(at, 4);
        if (field.size() == 4 && field[1] == '0' && field[2] >= '1' && field[2] <= '9' &&
            field[3] == 'd')
            return {at, 4, field[2] - '0'};
    }
    return {};
}

} // namespace

HeadlessRun::HeadlessRun(
    const CommonOptions& options, int argc, char** argv, const std::vector<std::string>& more)
    : options_(options), command_(command_text(argc, argv)) {
    check_outputs(options, more);
    if (!options.reference.empty()) {
        Image first = load_reference(options, numbered(options.reference, 0));
        if (!is_numbered(options.reference)) reference_ = std::move(first);
    }
    wall_.restart();
}

void HeadlessRun::write_plan_file(
    const gpu::Device& device, const Executor& executor, const FrameTimes& times) const {
    if (options_.plan.empty()) return;
    write_plan(options_.plan, executor.graph().declaration(), executor.plan(),
        capabilities_of(device), {}, times);
}

void HeadlessRun::announce(const gpu::Device& device, const Executor& executor) const {
    write_plan_file(device, executor, {});
    if (options_.explain) {
        fmt::print("{}", explain(executor.graph().declaration(), executor.plan()));
    }
}

std::optional<Image> HeadlessRun::reference(int frame) const {
    if (reference_ || options_.reference.empty()) return reference_;
    return load_reference(options_, numbered(options_.reference, frame));
}

std::optional<ImageError> HeadlessRun::error_of(const Image& picture, int frame) const {
    const std::optional<Image> against = reference(frame);
    if (!against) return {};
    return image_error(picture, *against);
}

void HeadlessRun::save_picture(Image picture, int frame) const {
    if (options_.output.empty()) return;
    picture.metadata = {
        {"ockham.version", version()}, {"ockham.commit", commit()}, {"ockham.command", command_}};
    const std::string file = numbered(options_.output, frame);
    save_image(file, picture, options_.exposure,
        options_.tonemap == "aces" ? Tonemap::aces : Tonemap::none);
    log::info("wrote {}", file);
}

void HeadlessRun::save_captures(Executor& executor, const std::vector<ImageHandle>& images) const {
    const auto captures = parse_captures(options_);
    check(captures.size() == images.size(), "an image for each --capture");
    for (std::size_t i = 0; i < captures.size(); ++i) {
        write_capture(captures[i].second, executor.read(images[i]));
        log::info("wrote {}", captures[i].second);
    }
}

void HeadlessRun::report(const gpu::Device& device, const Executor& executor,
    const nlohmann::ordered_json& more, const std::optional<ImageError>& error) const {
    expect_no_validation_messages(device);
    write_plan_file(device, executor, times_);
    if (!options_.trace.empty()) {
        write_text(options_.trace,
            times_.to_trace(executor.graph().declaration(), executor.plan()).dump() + "\n");
        log::info("wrote {}", options_.trace);
    }
    if (options_.stats.empty()) return;
    nlohmann::ordered_json json = statistics(device, executor.plan(), times_);
    json["command"] = command_;
    json["width"] = options_.width;
    json["height"] = options_.height;
    json["wall_ms"] = wall_.milliseconds();
    json.update(more);
    if (error) json["image"] = to_json(*error);
    write_text(
        options_.stats, json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
    log::info("wrote {}", options_.stats);
}

bool is_numbered(const std::string& name) { return find_number(name).at != std::string::npos; }

std::string numbered(const std::string& name, int number) {
    const NumberField field = find_number(name);
    if (field.at == std::string::npos) return name;
    return name.substr(0, field.at) + fmt::format("{:0{}}", number, field.digits) +
           name.substr(field.at + field.length);
}

void print_error(const ImageError& error) {
    fmt::print("error   {:9.2f} dB PSNR (peak 1, sRGB), SSIM {:.4f}, FLIP {:.4f}, MSE {:.3g}, "
               "largest {:.3f}\n",
        error.psnr, error.ssim, error.flip.mean, error.mse, error.max);
}

} // namespace ockham
