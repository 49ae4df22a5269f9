// SPDX-License-Identifier: Apache-2.0
// The viewer's panel beside the picture. What it changes is taken up by viewer.cpp.
#include "framework/core/error.hpp"
#include "framework/core/false_color.hpp"
#include "framework/core/log.hpp"
#include "samples/viewer/viewer.hpp"
#include "samples/viewer/widgets.hpp"

#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>
#include <cmath>

namespace ockham::viewer {
namespace {

/// A choice among `names`, or "-": none; true where another was made.
bool choose(const char* label, std::string& choice, const std::vector<std::string>& names) {
    bool changed = false;
    ImGui::SetNextItemWidth(-1);
    if (!ImGui::BeginCombo(label, choice.empty() ? "-" : choice.c_str())) return false;
    if (ImGui::Selectable("-", choice.empty())) choice.clear(), changed = true;
    for (const std::string& name : names)
        if (ImGui::Selectable(name.c_str(), name == choice)) choice = name, changed = true;
    ImGui::EndCombo();
    return changed;
}

void heading(const char* text) {
    ImGui::Dummy({0, 3});
    ImGui::TextUnformatted(text);
    ImGui::Separator();
}

/// The false colours from low to high.
void draw_color_bar() {
    const ImVec2 at = ImGui::GetCursorScreenPos();
    const float width = ImGui::GetContentRegionAvail().x;
    constexpr int kParts = 64;
    for (int i = 0; i < kParts; ++i) {
        const Rgb8 c = false_color((static_cast<float>(i) + 0.5f) / kParts);
        const float x0 = at.x + width * static_cast<float>(i) / kParts,
                    x1 = at.x + width * static_cast<float>(i + 1) / kParts;
        ImGui::GetWindowDrawList()->AddRectFilled(
            {x0, at.y}, {x1, at.y + 8}, IM_COL32(c.r, c.g, c.b, 255));
    }
    ImGui::Dummy({width, 10});
}

} // namespace

void Viewer::draw_panel() {
    const glm::ivec2 size = window_.size();
    ImGui::SetNextWindowPos({static_cast<float>(size.x - kPanelWidth), 0});
    ImGui::SetNextWindowSize({kPanelWidth, static_cast<float>(size.y)});
    begin_fixed("panel");
    const auto tab = [&](const char* name, void (Viewer::*draw)()) {
        if (!ImGui::BeginTabItem(name)) return;
        ImGui::BeginChild("content");
        (this->*draw)();
        ImGui::EndChild();
        ImGui::EndTabItem();
    };
    if (ImGui::BeginTabBar("tabs")) {
        tab("Parameters", &Viewer::draw_parameters);
        if (subject_->kind != Kind::surface) tab("Volume", &Viewer::draw_volume);
        tab("View", &Viewer::draw_view);
        tab("Compare", &Viewer::draw_compare);
        tab("Graph", &Viewer::draw_graph);
        ImGui::EndTabBar();
    }
    ImGui::End();
}

void Viewer::draw_parameters() {
    std::vector<std::string> changed;
    std::string group;
    bool open = false;
    for (Param* param : subject_->params.all()) {
        const bool is_elsewhere = param->name == "camera" || param->name == "width" ||
                                  param->name == "height" || param->group_name == "Run";
        if (param->is_transient || is_elsewhere) continue;
        if (param->group_name != group) {
            group = param->group_name;
            const bool starts_open = group != "Scene";
            open = ImGui::CollapsingHeader(group.c_str(),
                starts_open ? ImGuiTreeNodeFlags_DefaultOpen : ImGuiTreeNodeFlags_None);
        }
        if (open && edit(*param)) changed.push_back(param->name);
    }
    if (!changed.empty()) changed_parameters(changed);
}

void Viewer::draw_view() {
    heading("Camera");
    ImGui::SetNextItemWidth(-1);
    if (ImGui::InputText("##camera", &camera_text_, ImGuiInputTextFlags_EnterReturnsTrue)) {
        attempt([&] {
            const Stage stage = subject_->technique->stage();
            const std::optional<Camera> given = parse_camera(camera_text_, stage.up);
            if (!given)
                fail_input("camera: found '{}', expected \"px,py,pz tx,ty,tz fov\"", camera_text_);
            navigation_.reset(*given, stage.pivot, stage.scale, stage.up);
            changed_camera();
        });
    }
    if (ImGui::Button("Copy as --camera")) window_.copy_text("--camera \"" + camera() + "\"");
    ImGui::SameLine();
    if (ImGui::Button("First (R)")) {
        const Stage stage = subject_->technique->stage();
        navigation_.reset(stage.camera, stage.pivot, stage.scale, stage.up);
        changed_camera();
    }
    float fov = navigation_.camera().fov_y_degrees;
    ImGui::SetNextItemWidth(-1);
    if (ImGui::SliderFloat("##fov", &fov, 5, 120, "field of view %.0f degrees")) {
        navigation_.set_fov(fov);
        changed_camera();
    }
    ImGui::Checkbox("fly (F)", &fly_);
    ImGui::SameLine(120);
    ImGui::Checkbox("freeze (P)", &frozen_);
    draw_overlay();
    draw_save();
    heading("Facts");
    for (const auto& [label, value] : facts_) show_fact(label.c_str(), value);
    show_fact("device", device_.info().name);
}

void Viewer::draw_overlay() {
    heading("Overlay");
    std::vector<std::string> names = subject_->technique->overlays();
    if (reference_) names.push_back("error");
    if (choose("##overlay", overlay_, names)) {
        if (look_.overlay <= 0) look_.overlay = 0.85f;
        redraw_ = true;
        const std::string wanted = overlay_ == "error" ? "" : overlay_;
        const Executor* before = subject_->technique->executor();
        attempt([&] { subject_->technique->want_overlay(wanted); });
        if (subject_->technique->executor() != before) dirty_ = true;
    }
    if (overlay_.empty()) return;
    ImGui::SetNextItemWidth(-1);
    if (ImGui::SliderFloat("##opacity", &look_.overlay, 0, 1, "opacity %.2f")) redraw_ = true;
    draw_color_bar();
    ImGui::PushTextWrapPos(0);
    ImGui::TextDisabled("%s", legend_.c_str());
    ImGui::PopTextWrapPos();
}

void Viewer::draw_save() {
    heading("Save");
    const auto row = [&](const char* label, std::string& file, auto action) {
        ImGui::PushID(label);
        ImGui::SetNextItemWidth(-96);
        ImGui::InputText("##file", &file);
        ImGui::SameLine();
        if (ImGui::Button(label, {-1, 0})) attempt(action);
        ImGui::PopID();
    };
    row("Picture", picture_file_, [&] { save_picture(picture_file_); });
    row("Window", shot_file_, [&] { want_shot_ = true; });
    row("Run file", run_file_, [&] {
        save_run_file(run_file_, *subject_, camera(), {picture_.width(), picture_.height()});
        log::info("wrote {}, for {} --config", run_file_, subject_->technique->program());
    });
}

void Viewer::draw_compare() {
    heading("B");
    std::string name = reference_name_;
    if (choose("##rival", name, subject_->technique->rivals())) {
        attempt([&] {
            rival_.reset();
            reference_.reset();
            error_.reset();
            reference_name_ = name;
            rival_steps_ = 0;
            if (!name.empty()) rival_ = subject_->technique->rival(name);
        });
        if (look_.wipe >= 1) look_.wipe = 0.5f;
        redraw_ = true;
    }
    ImGui::PushTextWrapPos(0);
    ImGui::TextDisabled("A method here, or a picture dropped onto the window: .exr or .png.");
    ImGui::PopTextWrapPos();
    if (reference_name_.empty()) return;
    heading("A | B");
    ImGui::SetNextItemWidth(-1);
    if (ImGui::SliderFloat("##wipe", &look_.wipe, 0, 1, "wipe %.2f")) redraw_ = true;
    if (ImGui::Checkbox("flip: B alone (B)", &flip_)) redraw_ = true;
    heading("Difference");
    if (!reference_) {
        ImGui::TextDisabled("being rendered");
    } else if (!error_) {
        ImGui::TextDisabled(rival_ ? "being rendered" : "B has another size");
    } else {
        show_fact("PSNR", fmt::format("{:.2f} dB (peak 1, sRGB)", error_->psnr));
        show_fact("SSIM", fmt::format("{:.4f}", error_->ssim));
        show_fact("FLIP", fmt::format("{:.4f}", error_->flip.mean));
        show_fact("largest", fmt::format("{:.3f}", error_->max));
    }
    if (rival_) {
        heading("B's facts");
        if (rival_steps_ > 0)
            for (const auto& [label, value] : rival_->facts()) show_fact(label.c_str(), value);
    }
}

void Viewer::draw_volume() {
    auto& volume = dynamic_cast<VolumeTechnique&>(*subject_->technique);
    VolumeOptions& options = subject_->options.volume.volume;
    std::string& source = options.transfer;
    heading("Transfer function");
    TransferFunction transfer = volume.transfer();
    std::vector<double> isovalues;
    for (const float value : parse_numbers(options.iso))
        isovalues.push_back(static_cast<double>(value));
    const TransferEdit edited = transfer_.draw(volume.histogram(), transfer, isovalues);
    if (edited.transfer) {
        touched_ = clock_.seconds();
        dirty_ = true;
        error_.reset();
        subject_->drawn = transfer;
        attempt([&] { volume.set_transfer(transfer); });
    }
    static const std::vector<std::string> kPresets{"ct-bone", "ct-soft", "mri", "smoke"};
    std::string preset =
        std::ranges::find(kPresets, source) != kPresets.end() && !subject_->drawn ? source : "";
    if (choose("##preset", preset, kPresets)) {
        source = preset; // none: from the histogram
        options.window.clear();
        changed_parameters({"transfer"});
    }
    if (subject_->drawn && ImGui::Button("Save as transfer.json"))
        attempt([&] { save_transfer("transfer.json", *subject_->drawn); });

    draw_isovalues(std::move(isovalues), edited.isovalues);
    if (subject_->kind == Kind::both) draw_place();
}

void Viewer::draw_isovalues(std::vector<double> isovalues, bool changed) {
    heading("Isovalues");
    const Histogram& h = dynamic_cast<VolumeTechnique&>(*subject_->technique).histogram();
    for (std::size_t i = 0; i < isovalues.size(); ++i) {
        ImGui::PushID(static_cast<int>(i));
        auto value = static_cast<float>(isovalues[i]);
        ImGui::SetNextItemWidth(-72);
        if (ImGui::SliderFloat(
                "##iso", &value, static_cast<float>(h.low), static_cast<float>(h.high), "%.5g")) {
            isovalues[i] = static_cast<double>(value);
            changed = true;
        }
        ImGui::SameLine();
        if (ImGui::Button("remove", {-1, 0})) {
            isovalues.erase(isovalues.begin() + static_cast<std::ptrdiff_t>(i));
            changed = true;
        }
        ImGui::PopID();
    }
    if (isovalues.size() < MAX_SURFACES && ImGui::Button("Add")) {
        isovalues.push_back(otsu_threshold(h));
        changed = true;
    }
    if (!changed) return;
    std::ranges::sort(isovalues);
    std::string& iso = subject_->options.volume.volume.iso;
    iso.clear();
    for (const double value : isovalues)
        iso += fmt::format("{}{:.6g}", iso.empty() ? "" : ",", value);
    changed_parameters({"iso"});
}

/// Where the volume is among the scenes.
void Viewer::draw_place() {
    heading("Place");
    VolumePlacement place = dynamic_cast<SurfaceVolumeTechnique&>(*subject_->technique).placement();
    const float pace = 0.002f * subject_->technique->stage().scale;
    const auto row = [](const char* label) {
        ImGui::AlignTextToFramePadding();
        ImGui::TextUnformatted(label);
        ImGui::SameLine(60);
        ImGui::SetNextItemWidth(-1);
    };
    row("centre");
    bool changed = ImGui::DragFloat3("##centre", &place.translation.x, pace, 0, 0, "%.3g");
    row("turn");
    changed =
        ImGui::DragFloat3("##turn", &place.rotation_degrees.x, 1, -360, 360, "%.0f") || changed;
    row("size");
    changed = ImGui::DragFloat("##size", &place.scale, 0.01f * place.scale, 1e-4f, 1e6f, "%.4g",
                  ImGuiSliderFlags_AlwaysClamp) ||
              changed;
    if (!changed) return;
    const glm::vec3 t = place.translation, r = place.rotation_degrees;
    subject_->options.world.place = fmt::format("{:.6g},{:.6g},{:.6g} {:.6g},{:.6g},{:.6g} {:.6g}",
        t.x, t.y, t.z, r.x, r.y, r.z, place.scale);
    changed_parameters({"place"});
}

void Viewer::draw_graph() {
    const std::vector<PassTime> times = subject_->technique->times();
    const Executor* executor = subject_->technique->executor();
    if (!executor) return;
    double total = 0, longest = 1e-9;
    for (const PassTime& time : times) {
        total += time.milliseconds;
        longest = std::max(longest, time.milliseconds);
    }
    const Plan& plan = executor->plan();
    show_fact("GPU time", fmt::format("{:.1f} ms, {} passes", total, times.size()));
    show_fact("memory", fmt::format("{:.1f} MiB, lower bound {:.1f}",
                            static_cast<double>(plan.bytes_peak) / (1 << 20),
                            static_cast<double>(plan.bytes_lower_bound) / (1 << 20)));
    show_fact("barriers", fmt::format("{}", plan.barriers.size()));
    heading("Passes, in order");
    const std::vector<PassDecl>& passes = executor->graph().declaration().passes;
    for (const PassTime& time : times) {
        const ImVec2 at = ImGui::GetCursorScreenPos();
        const float share = static_cast<float>(time.milliseconds / longest);
        const float width = ImGui::GetContentRegionAvail().x;
        ImGui::GetWindowDrawList()->AddRectFilled({at.x, at.y},
            {at.x + width * share, at.y + ImGui::GetTextLineHeight() + 2},
            IM_COL32(219, 158, 64, 52), 2);
        ImGui::TextUnformatted(time.pass.c_str());
        const bool hovered = ImGui::IsItemHovered();
        const std::string ms =
            time.skipped ? "skipped" : fmt::format("{:.2f} ms", time.milliseconds);
        ImGui::SameLine(width - ImGui::CalcTextSize(ms.c_str()).x);
        ImGui::TextUnformatted(ms.c_str());
        if (!hovered && !ImGui::IsItemHovered()) continue;
        const auto pass = std::ranges::find(passes, time.pass, &PassDecl::name);
        if (pass != passes.end())
            tooltip(pass->reason.empty() ? "what comes after needs it" : pass->reason);
    }
    draw_reasons();
}

/// What the scene does not need, and why.
void Viewer::draw_reasons() {
    const Declaration& declaration = subject_->technique->executor()->graph().declaration();
    heading("Left out");
    ImGui::PushTextWrapPos(0);
    for (const Omission& omission : declaration.omissions) {
        ImGui::TextUnformatted(omission.name.c_str());
        ImGui::Indent(10);
        ImGui::TextDisabled("%s", omission.reason.c_str());
        ImGui::Unindent(10);
    }
    ImGui::PopTextWrapPos();
}

} // namespace ockham::viewer
