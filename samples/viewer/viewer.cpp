// SPDX-License-Identifier: Apache-2.0
#include "samples/viewer/viewer.hpp"

#include "framework/core/error.hpp"
#include "framework/core/log.hpp"
#include "framework/io/image_file.hpp"
#include "samples/viewer/widgets.hpp"

#include <imgui.h>

#include <algorithm>
#include <cmath>

namespace ockham::viewer {
namespace {

constexpr int kPanelWidth = 352, kStatusHeight = 28;
constexpr double kSettle = 0.25; ///< seconds without input, after which all counts as still
constexpr float kRadiansPerPixel = 0.006f;

} // namespace

void HurryScale::add(double milliseconds) {
    sum_ += milliseconds;
    ++count_;
    if (milliseconds > kMost) {
        if (++slow_ >= 2 && divisor_ < 8) ++divisor_, slow_ = 0;
        return;
    }
    slow_ = 0;
    const double finer = divisor_ > 1 ? static_cast<double>(divisor_) / (divisor_ - 1) : 1e9;
    if (milliseconds * finer * finer < 0.6 * kMost) --divisor_;
}

Viewer::Viewer(
    Window& window, gpu::Device& device, Presenter& presenter, std::unique_ptr<Subject> subject)
    : window_(window), device_(device), presenter_(presenter) {
    open(std::move(subject));
    if (!subject_->common.reference.empty()) load_reference(subject_->common.reference);
}

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
    dirty_ = true;
}

/// Errors of what a person does show in the window, and the viewer goes on.
template <class Action>
void Viewer::attempt(Action action) {
    try {
        action();
        if (message_is_error_) message_.clear(), message_is_error_ = false;
    } catch (const Error& error) {
        if (subject_->frames > 0) throw; // nobody is there to read
        message_ = error.what();
        message_is_error_ = true;
        log::warning("{}", message_);
    }
}

void Viewer::take_dropped() {
    for (const std::string& file : window_.take_dropped()) {
        attempt([&] {
            const std::string extension = std::filesystem::path(file).extension().string();
            if (extension == ".exr" || extension == ".png") {
                load_reference(file);
                return;
            }
            const Kind kind = kind_of(file);
            auto next = std::make_unique<Subject>(kind);
            next->set_source(file);
            // Two scenes seldom fit the memory that one takes.
            subject_->technique.reset();
            try {
                open(std::move(next));
            } catch (const Error&) {
                subject_->open(device_);
                subject_->technique->set_camera(navigation_.camera());
                dirty_ = true;
                throw;
            }
        });
    }
}

void Viewer::load_reference(const std::string& file) {
    reference_ = load_image(file);
    reference_name_ = file;
    look_.wipe = 0.5f;
    redraw_ = true;
}

std::string Viewer::camera() const {
    return camera_text(navigation_.camera(), navigation_.distance());
}

bool Viewer::hurries() const {
    return subject_->frames == 0 && touched_ >= 0 && clock_.seconds() - touched_ < kSettle;
}

void Viewer::changed_camera() {
    touched_ = clock_.seconds();
    dirty_ = true;
    camera_text_ = camera();
    subject_->technique->set_camera(navigation_.camera());
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
    touched_ = clock_.seconds();
    dirty_ = true;
    attempt([&] { subject_->technique->change(others); });
}

void Viewer::layout() {
    area_ = window_.size() - glm::ivec2(panel_ ? kPanelWidth : 0, kStatusHeight);
    area_ = glm::max(area_, glm::ivec2(16));
}

void Viewer::handle_mouse() {
    const ImGuiIO& io = ImGui::GetIO();
    if (io.WantCaptureMouse) return;
    const float right = io.MouseDelta.x, down = io.MouseDelta.y;
    const bool moved = right != 0 || down != 0;
    const auto height = static_cast<float>(area_.y);
    if (moved && ImGui::IsMouseDown(0)) {
        if (fly_)
            navigation_.look(kRadiansPerPixel * 0.5f * right, -kRadiansPerPixel * 0.5f * down);
        else
            navigation_.orbit(kRadiansPerPixel * right, -kRadiansPerPixel * down);
        changed_camera();
    } else if (moved && (ImGui::IsMouseDown(1) || ImGui::IsMouseDown(2))) {
        navigation_.pan(-right / height, down / height);
        changed_camera();
    }
    if (io.MouseWheel != 0) {
        navigation_.zoom(std::pow(0.88f, io.MouseWheel));
        changed_camera();
    }
}

void Viewer::handle_keys() {
    const ImGuiIO& io = ImGui::GetIO();
    if (io.WantTextInput) return;
    const auto pressed = [](char key) { return ImGui::IsKeyPressed(key, false); };
    if (pressed('H')) panel_ = !panel_;
    if (pressed('F')) fly_ = !fly_;
    if (pressed('P')) frozen_ = !frozen_;
    if (pressed('R')) {
        const Stage stage = subject_->technique->stage();
        navigation_.reset(stage.camera, stage.pivot, stage.scale, stage.up);
        changed_camera();
    }
    const auto axis = [](char minus, char plus) {
        return static_cast<float>(ImGui::IsKeyDown(plus)) -
               static_cast<float>(ImGui::IsKeyDown(minus));
    };
    const glm::vec3 way(axis('A', 'D'), axis('Q', 'E'), axis('S', 'W'));
    if (way == glm::vec3(0.0f)) return;
    const float pace = (io.KeyShift ? 1.2f : 0.3f) * std::min(io.DeltaTime, 0.2f);
    navigation_.walk(pace * way);
    changed_camera();
}

bool Viewer::render() {
    const bool hurry = hurries();
    Technique& technique = *subject_->technique;
    bool wants = dirty_ || (hasty_ && !hurry) || (!hurry && !technique.finished());
    if (subject_->frames > 0) wants = steps_ < subject_->frames;
    if (frozen_ || (message_is_error_ && !dirty_) || !wants) return false;
    reload_shaders(device_);
    const glm::ivec2 size = glm::max(area_ / (hurry ? hurry_.divisor() : 1), glm::ivec2(8));
    attempt([&] {
        const Timer timer;
        technique.render(glm::uvec2(size), hurry);
        picture_ = technique.picture();
        render_ms_ = timer.milliseconds();
        hasty_ = hurry;
        if (!hurry) ++steps_;
    });
    dirty_ = false;
    redraw_ = true;
    return true;
}

void Viewer::show() {
    if (!redraw_ || picture_.empty()) return;
    redraw_ = false;
    look_.exposure = subject_->common.exposure;
    look_.curve = subject_->common.tonemap == "aces" ? Tonemap::aces : Tonemap::none;
    std::optional<Overlay> overlay;
    if (!overlay_.empty()) {
        overlay = overlay_ == "error" && reference_
                      ? Overlay{"error", "codes of 255, of the worst channel",
                            code_error(picture_, *reference_, look_), 0, 64}
                      : subject_->technique->overlay(overlay_);
    }
    canvas_ = compose(
        picture_, reference_ ? &*reference_ : nullptr, overlay ? &*overlay : nullptr, look_);
}

void Viewer::draw_parameters() {
    std::vector<std::string> changed;
    std::string group;
    bool open = false;
    for (Param* param : subject_->params.all()) {
        if (param->is_transient || param->group_name == "Run" || param->name == "camera" ||
            param->name == "width" || param->name == "height")
            continue;
        if (param->group_name != group) {
            group = param->group_name;
            open = ImGui::CollapsingHeader(group.c_str(),
                group == "Scene" ? ImGuiTreeNodeFlags_None : ImGuiTreeNodeFlags_DefaultOpen);
        }
        if (open && edit(*param)) changed.push_back(param->name);
    }
    if (!changed.empty()) changed_parameters(changed);
}

void Viewer::draw_view() {
    ImGui::TextDisabled("camera");
    ImGui::SetNextItemWidth(-1);
    std::array<char, 256> text{};
    camera_text_.copy(text.data(), text.size() - 1);
    if (ImGui::InputText(
            "##camera", text.data(), text.size(), ImGuiInputTextFlags_EnterReturnsTrue)) {
        attempt([&] {
            const Stage stage = subject_->technique->stage();
            const std::optional<Camera> given = parse_camera(text.data(), stage.up);
            if (!given) fail_input("camera: expected \"px,py,pz tx,ty,tz fov\"");
            navigation_.reset(*given, stage.pivot, stage.scale, stage.up);
            changed_camera();
        });
    }
    if (ImGui::Button("Copy")) window_.copy_text("--camera \"" + camera() + "\"");
    ImGui::SameLine();
    if (ImGui::Button("Reset (R)")) {
        const Stage stage = subject_->technique->stage();
        navigation_.reset(stage.camera, stage.pivot, stage.scale, stage.up);
        changed_camera();
    }
    ImGui::SameLine();
    ImGui::Checkbox("fly (F)", &fly_);
    ImGui::SameLine();
    ImGui::Checkbox("freeze (P)", &frozen_);
    float fov = navigation_.camera().fov_y_degrees;
    ImGui::SetNextItemWidth(-1);
    if (ImGui::SliderFloat("##fov", &fov, 5, 120, "field of view %.0f degrees")) {
        navigation_.set_fov(fov);
        changed_camera();
    }
}

void Viewer::draw_graph() {
    for (const PassTime& time : subject_->technique->times()) {
        ImGui::TextUnformatted(time.pass.c_str());
        ImGui::SameLine(240);
        ImGui::Text("%8.2f ms", time.milliseconds);
    }
}

void Viewer::draw_panel() {
    const glm::ivec2 size = window_.size();
    ImGui::SetNextWindowPos({static_cast<float>(size.x - kPanelWidth), 0});
    ImGui::SetNextWindowSize({kPanelWidth, static_cast<float>(size.y)});
    ImGui::Begin("panel", nullptr,
        ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
            ImGuiWindowFlags_NoCollapse);
    if (ImGui::BeginTabBar("tabs")) {
        if (ImGui::BeginTabItem("Parameters")) {
            draw_parameters();
            ImGui::EndTabItem();
        }
        if (ImGui::BeginTabItem("View")) {
            draw_view();
            ImGui::EndTabItem();
        }
        if (ImGui::BeginTabItem("Graph")) {
            draw_graph();
            ImGui::EndTabItem();
        }
        ImGui::EndTabBar();
    }
    ImGui::End();
}

void Viewer::draw_status() {
    if (clock_.seconds() - facts_time_ > 0.5 && !hasty_) {
        facts_ = subject_->technique->facts();
        facts_time_ = clock_.seconds();
    }
    const glm::ivec2 size = window_.size();
    ImGui::SetNextWindowPos({0, static_cast<float>(size.y - kStatusHeight)});
    ImGui::SetNextWindowSize({static_cast<float>(area_.x), kStatusHeight});
    ImGui::PushStyleVar(ImGuiStyleVar_WindowMinSize, {8, 8});
    ImGui::Begin("status", nullptr,
        ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
            ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoCollapse);
    std::string text = fmt::format("{} x {}   {:.0f} ms", picture_.empty() ? 0 : picture_.width(),
        picture_.empty() ? 0 : picture_.height(), render_ms_);
    for (const auto& [label, value] : facts_) {
        if (label == "samples" || label == "steps" || label == "noise" || label == "cache")
            text += fmt::format("   {} {}", label, value);
    }
    ImGui::TextUnformatted(text.c_str());
    ImGui::End();
    ImGui::PopStyleVar();
}

void Viewer::draw_message() {
    if (message_.empty()) return;
    ImGui::SetNextWindowPos({16, 16});
    ImGui::SetNextWindowSize({std::min(520.0f, static_cast<float>(area_.x) - 32), 0});
    ImGui::Begin("message", nullptr,
        ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
            ImGuiWindowFlags_NoCollapse);
    ImGui::PushTextWrapPos(0);
    ImGui::TextUnformatted(message_.c_str());
    ImGui::PopTextWrapPos();
    if (ImGui::SmallButton("dismiss")) message_.clear(), message_is_error_ = false;
    ImGui::End();
}

void Viewer::run() {
    while (!window_.should_close() && !interrupted()) {
        const bool idle = !dirty_ && !redraw_ && !hasty_ &&
                          (frozen_ || message_is_error_ || subject_->technique->finished()) &&
                          subject_->frames == 0;
        window_.poll(idle ? 0.5 : 0);
        take_dropped();
        const Timer frame;
        if (!presenter_.begin()) {
            window_.poll(0.1); // minimised
            continue;
        }
        layout();
        handle_mouse();
        handle_keys();
        if (panel_) draw_panel();
        draw_status();
        draw_message();
        const bool rendered = render();
        show();
        // The widgets need some frames to settle.
        const bool last = subject_->frames > 0 && steps_ >= subject_->frames && frames_ >= 3;
        Canvas shot;
        const bool shoots = want_shot_ || (last && !subject_->screenshot.empty());
        const bool shown = presenter_.end(canvas_, glm::ivec2(0), area_, shoots ? &shot : nullptr);
        if (shoots && shown) {
            std::vector<std::uint8_t> rgb;
            for (std::size_t i = 0; i < shot.rgba.size(); ++i)
                if (i % 4 != 3) rgb.push_back(shot.rgba[i]);
            save_png_srgb(last ? subject_->screenshot : shot_file_, shot.size.x, shot.size.y, rgb);
            want_shot_ = false;
        }
        frame_ms_ = frame.milliseconds();
        if (rendered && hasty_) hurry_.add(frame_ms_);
        ++frames_;
        if (last && shown) break;
    }
    save_outputs();
}

void Viewer::save_outputs() {
    if (!subject_->common.output.empty() && !picture_.empty()) {
        save_image(subject_->common.output, picture_, subject_->common.exposure,
            subject_->common.tonemap == "aces" ? Tonemap::aces : Tonemap::none);
        log::info("wrote {}", subject_->common.output);
    }
    if (hurry_.count() > 0)
        log::info("{} frames while something was dragged, {:.0f} ms each", hurry_.count(),
            hurry_.mean_ms());
    if (subject_->frames == 0) save_session();
}

void Viewer::save_session() {
    const std::filesystem::path file = session_path();
    if (file.empty()) return;
    std::error_code failed;
    std::filesystem::create_directories(file.parent_path(), failed);
    attempt([&] { save_run_file(file, *subject_, camera(), window_.size()); });
}

} // namespace ockham::viewer
