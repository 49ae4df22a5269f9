// SPDX-License-Identifier: Apache-2.0
#include "samples/viewer/widgets.hpp"

#include "framework/core/error.hpp"

#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace ockham::viewer {
namespace {

constexpr const char* kFont = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";

ImVec4 grey(float value, float alpha = 1.0f) {
    return {value, value + 0.004f, value + 0.012f, alpha};
}

/// Quiet greys, so that the picture's colours are the only ones; one accent for what is active.
void set_look() {
    ImGui::StyleColorsDark();
    ImGuiStyle& style = ImGui::GetStyle();
    style.WindowRounding = 0;
    style.WindowBorderSize = 0;
    style.WindowPadding = {12, 10};
    style.FrameRounding = style.GrabRounding = style.PopupRounding = 3;
    style.FramePadding = {7, 3};
    style.ItemSpacing = {8, 5};
    style.ScrollbarSize = 11;
    style.GrabMinSize = 9;
    style.TabRounding = 3;
    const ImVec4 accent{0.86f, 0.62f, 0.25f, 1}, dim{0.86f, 0.62f, 0.25f, 0.55f};
    ImVec4* c = style.Colors;
    c[ImGuiCol_Text] = grey(0.88f);
    c[ImGuiCol_TextDisabled] = grey(0.52f);
    c[ImGuiCol_WindowBg] = grey(0.095f);
    c[ImGuiCol_PopupBg] = grey(0.12f, 0.98f);
    c[ImGuiCol_Border] = grey(0.22f);
    c[ImGuiCol_FrameBg] = grey(0.165f);
    c[ImGuiCol_FrameBgHovered] = grey(0.21f);
    c[ImGuiCol_FrameBgActive] = grey(0.24f);
    c[ImGuiCol_Button] = grey(0.20f);
    c[ImGuiCol_ButtonHovered] = grey(0.27f);
    c[ImGuiCol_ButtonActive] = grey(0.33f);
    c[ImGuiCol_Header] = grey(0.17f);
    c[ImGuiCol_HeaderHovered] = grey(0.23f);
    c[ImGuiCol_HeaderActive] = grey(0.27f);
    c[ImGuiCol_Separator] = grey(0.2f);
    c[ImGuiCol_Tab] = grey(0.12f);
    c[ImGuiCol_TabHovered] = grey(0.27f);
    c[ImGuiCol_TabActive] = grey(0.22f);
    c[ImGuiCol_SliderGrab] = dim;
    c[ImGuiCol_SliderGrabActive] = c[ImGuiCol_CheckMark] = accent;
    c[ImGuiCol_TableRowBgAlt] = grey(1.0f, 0.025f);
    c[ImGuiCol_ScrollbarBg] = grey(0.095f);
    c[ImGuiCol_ScrollbarGrab] = grey(0.25f);
}

std::string help_text(const Param& param) {
    std::string text = param.help + "\n--" + param.name;
    const bool below = std::isfinite(param.low), above = std::isfinite(param.high);
    if (below || above)
        text += fmt::format("   {} ... {}", below ? fmt::format("{:g}", param.low) : "-inf",
            above ? fmt::format("{:g}", param.high) : "inf");
    if (!param.unit_name.empty()) text += "   " + param.unit_name;
    if (!param.default_text.empty()) text += "   default " + param.default_text;
    return text;
}

/// True and `text` where another was chosen.
bool choose(const Param& param, const char* label, std::string& text) {
    bool changed = false;
    if (!ImGui::BeginCombo(label, text.c_str())) return false;
    for (const std::string& name : param.allowed) {
        if (ImGui::Selectable(name.c_str(), name == text) && name != text) {
            text = name;
            changed = true;
        }
    }
    ImGui::EndCombo();
    return changed;
}

bool slide(const Param& param, const char* label, std::string& text) {
    const SliderRange range = slider_range(param);
    const ImGuiSliderFlags flags =
        range.logarithmic ? ImGuiSliderFlags_Logarithmic : ImGuiSliderFlags_None;
    if (const auto* target = std::get_if<float*>(&param.target)) {
        float value = std::min(**target, std::numeric_limits<float>::max());
        const float span = static_cast<float>(range.high - range.low);
        // The digits also say how near to 0 a logarithmic slider comes: a millionth.
        const int digits = range.logarithmic
                               ? std::clamp(static_cast<int>(6 - std::log10(range.high)), 0, 9)
                           : span > 20 ? 1
                                       : 3;
        const std::string format = fmt::format("%.{}f", digits);
        if (!ImGui::SliderFloat(label, &value, static_cast<float>(range.low),
                static_cast<float>(range.high), format.c_str(), flags))
            return false;
        text = fmt::format("{}", value);
    } else {
        int value = *std::get<int*>(param.target);
        if (!ImGui::SliderInt(label, &value, static_cast<int>(range.low),
                static_cast<int>(range.high), "%d", flags))
            return false;
        text = fmt::format("{}", value);
    }
    return true;
}

/// What the widget of a parameter wants it to be.
bool widget(const Param& param, const char* label, std::string& text) {
    if (param.is_list()) {
        std::string end = text.empty() ? "-" : text; // of a long path
        const float width = ImGui::GetContentRegionAvail().x;
        while (end.size() > 4 && ImGui::CalcTextSize(end.c_str()).x > width)
            end = "..." + end.substr(4);
        ImGui::TextUnformatted(end.c_str());
        if (end != text && ImGui::IsItemHovered()) tooltip(text);
        return false;
    }
    if (!param.allowed.empty()) return choose(param, label, text);
    if (const auto* flag = std::get_if<bool*>(&param.target)) {
        bool value = **flag;
        const bool changed = ImGui::Checkbox(label, &value);
        text = value ? "on" : "off";
        return changed;
    }
    if (std::holds_alternative<float*>(param.target) || std::holds_alternative<int*>(param.target))
        return slide(param, label, text);
    return ImGui::InputText(label, &text, ImGuiInputTextFlags_EnterReturnsTrue);
}

} // namespace

Gui::Gui() {
    IMGUI_CHECKVERSION();
    ImGui::CreateContext();
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr; // the layout is fixed
    if (std::filesystem::exists(kFont)) io.Fonts->AddFontFromFileTTF(kFont, 13.5f);
    set_look();
}

Gui::~Gui() { ImGui::DestroyContext(); }

void begin_fixed(const char* name, bool scrolls) {
    ImGui::Begin(name, nullptr,
        ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
            ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoSavedSettings |
            (scrolls ? ImGuiWindowFlags_None : ImGuiWindowFlags_NoScrollbar));
}

SliderRange slider_range(const Param& param) {
    constexpr double kWide = 2000;
    if (param.high - param.low <= kWide) return {param.low, param.high, false};
    double value = 0;
    if (const auto* number = std::get_if<float*>(&param.target)) value = **number;
    if (const auto* number = std::get_if<int*>(&param.target)) value = **number;
    if (!std::isfinite(value)) value = 0;
    double normal = 0;
    try {
        normal = std::stod(param.default_text);
    } catch (const std::exception&) { // no number, or an infinite one
    }
    if (!std::isfinite(normal)) normal = 0;
    const double least = !std::holds_alternative<float*>(param.target) ? 100 : normal == 0 ? 10 : 0;
    const double reach = std::max({100 * std::abs(normal), std::abs(value), least});
    return {std::max(param.low, param.low < 0 && param.low >= -1 ? param.low : -reach),
        std::min(param.high, reach), param.low >= 0};
}

bool edit(Param& param) {
    ImGui::PushID(&param);
    std::string text = param.text();
    ImGui::AlignTextToFramePadding();
    const bool is_default = text == param.default_text;
    if (is_default)
        ImGui::TextDisabled("%s", param.name.c_str());
    else
        ImGui::TextUnformatted(param.name.c_str());
    if (ImGui::IsItemHovered()) tooltip(help_text(param));
    bool changed = false;
    if (ImGui::IsItemClicked(1) && !is_default && !param.is_list()) {
        text = param.default_text;
        changed = true;
    }
    ImGui::SameLine(128);
    ImGui::SetNextItemWidth(-1);
    changed = widget(param, "##value", text) || changed;
    if (ImGui::IsItemHovered() && !ImGui::IsItemActive()) tooltip(help_text(param));
    ImGui::PopID();
    if (!changed) return false;
    try {
        param.set(text);
    } catch (const Error&) { // typed beyond the range
        return false;
    }
    return true;
}

void show_fact(const char* label, const std::string& value) {
    ImGui::TextDisabled("%s", label);
    ImGui::SameLine(128);
    ImGui::TextUnformatted(value.c_str());
}

void tooltip(const std::string& text) {
    ImGui::BeginTooltip();
    ImGui::PushTextWrapPos(360);
    ImGui::TextUnformatted(text.c_str());
    ImGui::PopTextWrapPos();
    ImGui::EndTooltip();
}

} // namespace ockham::viewer
