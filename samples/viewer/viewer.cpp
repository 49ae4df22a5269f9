// SPDX-License-Identifier: Apache-2.0
#include "samples/viewer/viewer.hpp"

#include "framework/core/error.hpp"
#include "framework/core/file.hpp"
#include "framework/core/log.hpp"
#include "framework/io/image_file.hpp"
#include "samples/viewer/widgets.hpp"

#include <imgui.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

namespace ockham::viewer {
namespace {

constexpr double kSettle = 0.25; ///< seconds without input, after which all counts as still

} // namespace

Viewer::Viewer(
    Window& window, gpu::Device& device, Presenter& presenter, std::unique_ptr<Subject> subject)
    : window_(window), device_(device), presenter_(presenter) {
    if (subject->frames > 0 && subject->orbit > 0)
        fail_input("--frames and --orbit both say when the window closes; give one of them");
    open(std::move(subject));
    if (!subject_->common.reference.empty()) load_reference(subject_->common.reference);
    listen();
}

Viewer::~Viewer() { log::set_sink({}); }

void Viewer::open(std::unique_ptr<Subject> subject) {
    subject->open(device_);
    subject_ = std::move(subject);
    const Stage stage = subject_->technique->stage();
    navigation_.reset(stage.camera, stage.pivot, stage.scale, stage.up);
    subject_->technique->set_camera(navigation_.camera());
    window_.set_title(subject_->technique->title() + " - Ockham viewer");
    camera_text_ = camera();
    fly_ = stage.inside;
    overlay_.clear();
    loupe_.reset();
    rival_.reset();
    reference_.reset();
    reference_name_.clear();
    dirty_ = true;
    touched_ = clock_.seconds(); // something small at once, then all of it
}

/// Errors of what a person does show in the window, and the viewer goes on.
void Viewer::attempt(const std::function<void()>& action) {
    try {
        action();
    } catch (const Error& error) {
        if (!attended()) throw; // nobody is there to read
        message_ = error.what();
        log::warning("{}", message_);
    }
}

/// A JSON file that is a value of a parameter: a transfer function or a rig.
bool Viewer::takes(const std::string& file) {
    const nlohmann::json json = nlohmann::json::parse(read_text(file), nullptr, false);
    if (subject_->kind != Kind::surface && json.contains("points")) {
        VolumeOptions& volume = subject_->options.volume.volume;
        volume.transfer = file;
        volume.window.clear();
        changed_parameters({"transfer"});
        return true;
    }
    if (subject_->kind != Kind::volume && !json.contains("dims")) {
        subject_->options.surface.scene.rig = file;
        changed_parameters({"rig"});
        return true;
    }
    return false; // raw voxels
}

/// Scenes and volumes that are dropped together are shown together.
void Viewer::take_dropped() {
    std::vector<std::string> sources;
    for (const std::string& file : window_.take_dropped()) {
        attempt([&] {
            const std::string extension = std::filesystem::path(file).extension().string();
            if (extension == ".exr" || extension == ".png")
                load_reference(file);
            else if (extension != ".json" || !takes(file))
                sources.push_back(file);
        });
    }
    if (!sources.empty()) attempt([&] { replace(sources); });
}

void Viewer::replace(const std::vector<std::string>& sources) {
    auto next = std::make_unique<Subject>(kind_of(sources));
    next->common = subject_->common;
    next->set_sources(sources);
    // Two scenes seldom fit the memory that one takes.
    rival_.reset();
    subject_->technique.reset();
    try {
        open(std::move(next));
    } catch (const Error&) {
        subject_->open(device_);
        subject_->technique->set_camera(navigation_.camera());
        dirty_ = true;
        throw;
    }
}

void Viewer::load_reference(const std::string& file) {
    reference_ = load_image(file);
    rival_.reset();
    reference_name_ = file;
    error_.reset();
    look_.wipe = 0.5f;
    redraw_ = true;
}

/// B by another method, with A's parameters as they are now.
void Viewer::restart_rival() {
    if (!rival_) return;
    rival_.reset();
    rival_ = subject_->technique->rival(reference_name_);
    rival_->set_camera(navigation_.camera());
    rival_steps_ = 0;
    reference_.reset();
    error_.reset();
}

/// A step of B, in the time that A leaves. True: there is another picture.
bool Viewer::render_rival() {
    if (!rival_ || hasty_ || hurries() || !rests() || frozen_ || picture_.empty() ||
        (rival_steps_ > 0 && rival_->finished()))
        return false;
    attempt([&] {
        rival_->render(glm::uvec2(picture_.width(), picture_.height()), false);
        reference_ = rival_->picture();
        ++rival_steps_;
    });
    redraw_ = true;
    return true;
}

/// What is logged goes on to the terminal, and shows in the window where somebody should act.
void Viewer::listen() {
    log::set_sink([this](log::Level level, std::string_view text) {
        const bool reloaded = text.starts_with("reloaded shaders:");
        if (reloaded) complaints_.clear(), dirty_ = true;
        // Sliders would repeat what is inferred all the way.
        if (level <= log::Level::info && !reloaded && !said_.emplace(text).second) return;
        const char* prefix = level == log::Level::warning ? "warning: "
                             : level == log::Level::error ? "error: "
                                                          : "";
        fmt::print(stderr, "{}{}\n", prefix, text);
        if (level >= log::Level::warning) complaints_.emplace_back(text);
    });
}

void Viewer::save_picture(const std::string& file) {
    save_image(file, picture_, look_.exposure, look_.curve);
    log::info("wrote {}", file);
}

std::string Viewer::camera() const {
    return camera_text(navigation_.camera(), navigation_.distance());
}

bool Viewer::hurries() const {
    return subject_->frames == 0 && touched_ >= 0 && clock_.seconds() - touched_ < kSettle;
}

/// Long steps wait for a hand at rest: nothing is drawn before they end.
bool Viewer::rests() const {
    constexpr double kLong = 120, kRest = 0.4; // ms, seconds
    return subject_->frames > 0 || full_ms_ < kLong || clock_.seconds() - input_ > kRest;
}

void Viewer::changed_parameters(const std::vector<std::string>& names) {
    const auto is_display = [](const std::string& name) {
        return name == "exposure" || name == "tonemap";
    };
    redraw_ = true;
    std::vector<std::string> others;
    for (const std::string& name : names)
        if (!is_display(name)) others.push_back(name);
    if (others.empty()) return;
    for (const std::string& name : others)
        if (name == "transfer" || name == "window") subject_->drawn.reset();
    touched_ = clock_.seconds();
    dirty_ = true;
    attempt([&] {
        subject_->technique->change(others);
        restart_rival();
    });
    error_.reset();
}

void Viewer::layout() {
    area_ = window_.size() - glm::ivec2(panel_ ? kPanelWidth : 0, kStatusHeight);
    area_ = glm::max(area_, glm::ivec2(16));
}

bool Viewer::render() {
    const bool hurry = hurries();
    Technique& technique = *subject_->technique;
    bool wants = dirty_ || (hasty_ && !hurry) || (!hurry && !technique.finished());
    if (subject_->frames > 0) wants = steps_ < subject_->frames;
    if (frozen_ || (failed_ && !dirty_) || !wants) return false;
    if (!hurry && !rests()) return false;
    const glm::ivec2 size = glm::max(area_ / (hurry ? hurry_.divisor() : 1), glm::ivec2(8));
    failed_ = true; // until it has not
    attempt([&] {
        const Timer timer;
        technique.render(glm::uvec2(size), hurry);
        picture_ = technique.picture();
        render_ms_ = timer.milliseconds();
        hasty_ = hurry;
        message_.clear();
        failed_ = false;
        if (!hurry) ++steps_, full_ms_ = render_ms_;
    });
    dirty_ = false;
    redraw_ = true;
    samples_old_ = true;
    return true;
}

void Viewer::show() {
    if (!redraw_ || picture_.empty()) return;
    redraw_ = false;
    look_.exposure = subject_->common.exposure;
    look_.curve = subject_->common.tonemap == "aces" ? Tonemap::aces : Tonemap::none;
    std::optional<Overlay> overlay;
    legend_.clear();
    if (!overlay_.empty() && !hasty_) {
        overlay = overlay_ == "error" && reference_
                      ? Overlay{"error", "codes of 255, of the worst channel",
                            code_error(picture_, *reference_, look_), 0, 64}
                      : subject_->technique->overlay(overlay_);
    }
    if (overlay)
        legend_ = fmt::format("{}: {:.4g} to {:.4g}", overlay->legend, overlay->low, overlay->high);
    const Image* const other = reference_ ? &*reference_ : nullptr;
    if (flip_ && other)
        canvas_ = compose(*other, nullptr, nullptr, look_);
    else
        canvas_ = compose(picture_, other, overlay ? &*overlay : nullptr, look_);
    const bool done = !hasty_ && (!rival_ || rival_->finished());
    if (done && other && !error_ && other->width() == picture_.width() &&
        other->height() == picture_.height())
        error_ = image_error(picture_, *other);
}

void Viewer::run() {
    while (!window_.should_close() && !interrupted() && frame()) {
    }
    save_outputs();
}

bool Viewer::frame() {
    const bool idle = !dirty_ && !redraw_ && !hasty_ &&
                      (frozen_ || failed_ || subject_->technique->finished()) &&
                      (!rival_ || frozen_ || rival_->finished()) && !want_shot_ && attended();
    window_.poll(idle ? 0.5 : 0);
    take_dropped();
    reload_shaders(device_);
    const Timer timer;
    if (!presenter_.begin()) {
        window_.poll(0.1); // minimised
        return true;
    }
    layout();
    handle_mouse();
    handle_keys();
    if (subject_->orbit > 0) turn(3, 0);
    if (panel_) draw_panel();
    draw_status();
    draw_message();
    draw_wipe();
    if (loupe_) draw_loupe_window();
    const bool rendered = render();
    if (!rendered) render_rival();
    attempt([&] { show(); });
    // The widgets need some frames to settle.
    const bool last = !attended() && steps_ >= subject_->frames &&
                      hurry_.count() >= subject_->orbit && frames_ >= 3;
    const bool shown = present(last);
    if (rendered && hasty_) hurry_.add(timer.milliseconds());
    ++frames_;
    return !last || !shown;
}

/// `last`: with the screenshot that was asked for. False: the window was not ready.
bool Viewer::present(bool last) {
    const bool shoots = want_shot_ || (last && !subject_->screenshot.empty());
    Canvas shot;
    if (!presenter_.end(canvas_, glm::ivec2(0), area_, shoots ? &shot : nullptr)) return false;
    if (!shoots) return true;
    std::vector<std::uint8_t> rgb;
    for (std::size_t i = 0; i < shot.rgba.size(); ++i)
        if (i % 4 != 3) rgb.push_back(shot.rgba[i]);
    save_png_srgb(last ? subject_->screenshot : shot_file_, shot.size.x, shot.size.y, rgb);
    want_shot_ = false;
    return true;
}

void Viewer::save_outputs() {
    if (!subject_->common.output.empty() && !picture_.empty())
        save_picture(subject_->common.output);
    if (hurry_.count() > 0) {
        const double ms = hurry_.median_ms();
        const std::string text = fmt::format(
            "{} frames while something moved, {:.1f} ms each "
            "(median of the later half): {:.1f} a second, of {} x {} pixels",
            hurry_.count(), ms, 1000 / ms, area_.x / hurry_.divisor(), area_.y / hurry_.divisor());
        if (subject_->orbit > 0)
            fmt::print("{}\n", text);
        else
            log::info("{}", text);
    }
    if (attended()) save_session();
}

void Viewer::save_session() {
    const std::filesystem::path file = session_path();
    if (file.empty()) return;
    std::error_code failed;
    std::filesystem::create_directories(file.parent_path(), failed);
    attempt([&] { save_run_file(file, *subject_, camera(), window_.size()); });
}

} // namespace ockham::viewer
