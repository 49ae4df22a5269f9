// SPDX-License-Identifier: Apache-2.0
// The viewer's widgets over and below the picture: status, wipe, loupe, messages.
#include "samples/viewer/viewer.hpp"
#include "samples/viewer/widgets.hpp"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>

namespace ockham::viewer {

void Viewer::draw_status() {
    if (clock_.seconds() - facts_time_ > 0.5 && !hasty_ && !picture_.empty()) {
        facts_ = subject_->technique->facts();
        facts_time_ = clock_.seconds();
    }
    const glm::ivec2 size = window_.size();
    ImGui::SetNextWindowPos({0, static_cast<float>(size.y - kStatusHeight)});
    ImGui::SetNextWindowSize({static_cast<float>(area_.x), kStatusHeight});
    ImGui::PushStyleVar(ImGuiStyleVar_WindowMinSize, {8, 8});
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {12, 6});
    begin_fixed("status", false);
    std::string text;
    if (!picture_.empty())
        text = fmt::format("{} x {}   {:.0f} ms", picture_.width(), picture_.height(), render_ms_);
    for (const auto& [label, value] : facts_) {
        if (label == "samples" || label == "steps" || label == "noise" || label == "cache")
            text += fmt::format("   {} {}", label, value);
    }
    // What a narrow window cuts off is in the tooltip.
    const char* state = frozen_ ? "frozen" : hasty_ ? "in haste" : "";
    const float end = static_cast<float>(area_.x) - ImGui::CalcTextSize(state).x - 12;
    ImGui::PushClipRect({0, 0}, {end - 12, static_cast<float>(size.y)}, true);
    ImGui::TextUnformatted(text.c_str());
    ImGui::PopClipRect();
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", text.c_str());
    ImGui::SameLine(end);
    ImGui::TextDisabled("%s", state);
    ImGui::End();
    ImGui::PopStyleVar(2);
}

/// Where A ends, and what is on either side.
void Viewer::draw_wipe() {
    if (!reference_ || picture_.empty()) return;
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    const auto width = static_cast<float>(area_.x), height = static_cast<float>(area_.y);
    const float x = flip_ ? 0 : std::round(look_.wipe * width);
    if (x > 0 && x < width) list.AddLine({x, 0}, {x, height}, IM_COL32(240, 175, 70, 200));
    const auto label = [&](float left, const std::string& text) {
        const ImVec2 size = ImGui::CalcTextSize(text.c_str());
        list.AddRectFilled(
            {left, height - 26}, {left + size.x + 12, height - 6}, IM_COL32(20, 21, 23, 190), 3);
        list.AddText({left + 6, height - 24}, IM_COL32(225, 225, 228, 255), text.c_str());
    };
    if (x > 40) label(8, "A  " + subject_->technique->method());
    if (x < width - 40) label(x + 8, "B  " + reference_name_);
}

void Viewer::draw_loupe_window() {
    if (samples_old_ && !dirty_ && !hasty_ && !hurries()) {
        samples_old_ = false;
        samples_.reset();
        const glm::ivec2 size(picture_.width(), picture_.height());
        if (canvas_.size == size && glm::all(glm::lessThan(*loupe_, size)))
            attempt([&] { samples_ = subject_->technique->samples(*loupe_); });
    }
    ImGui::SetNextWindowPos({12, static_cast<float>(area_.y) - 36}, ImGuiCond_Always, {0, 1});
    ImGui::SetNextWindowSize({264, 0});
    ImGui::SetNextWindowBgAlpha(0.93f);
    begin_fixed("loupe");
    draw_loupe(canvas_, *loupe_);
    ImGui::Text("pixel %d, %d", loupe_->x, loupe_->y);
    const auto show_value = [&](const char* label, const Image& image) {
        if (loupe_->x >= image.width() || loupe_->y >= image.height()) return;
        ImGui::Text("%s  %.4g  %.4g  %.4g", label, image.at(loupe_->x, loupe_->y, 0),
            image.at(loupe_->x, loupe_->y, 1), image.at(loupe_->x, loupe_->y, 2));
    };
    show_value("A", picture_);
    if (reference_) show_value("B", *reference_);
    if (samples_) {
        ImGui::TextDisabled("%u of %u samples shaded%s", samples_->count, samples_->m * samples_->m,
            samples_->by_rank ? "" : ", by surface");
        draw_samples(*samples_, look_);
    }
    if (ImGui::SmallButton("close")) {
        loupe_.reset();
        subject_->technique->forget_samples();
    }
    ImGui::End();
}

void Viewer::draw_message() {
    if (message_.empty() && complaints_.empty()) return;
    ImGui::SetNextWindowPos({16, 16});
    ImGui::SetNextWindowSize({std::min(560.0f, static_cast<float>(area_.x) - 32), 0});
    ImGui::PushStyleColor(ImGuiCol_WindowBg, {0.17f, 0.09f, 0.07f, 0.94f});
    begin_fixed("message");
    ImGui::PushTextWrapPos(0);
    if (!message_.empty()) ImGui::TextUnformatted(message_.c_str());
    constexpr std::size_t kMost = 4;
    const std::size_t first = complaints_.size() > kMost ? complaints_.size() - kMost : 0;
    for (std::size_t i = first; i < complaints_.size(); ++i)
        if (complaints_[i] != message_) ImGui::TextUnformatted(complaints_[i].c_str());
    ImGui::PopTextWrapPos();
    if (ImGui::SmallButton("dismiss")) {
        message_.clear();
        complaints_.clear();
    }
    ImGui::End();
    ImGui::PopStyleColor();
}

} // namespace ockham::viewer
