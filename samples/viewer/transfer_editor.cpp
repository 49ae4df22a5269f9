// SPDX-License-Identifier: Apache-2.0
#include "samples/viewer/transfer_editor.hpp"

#include "framework/core/image.hpp"
#include "samples/viewer/widgets.hpp"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>

namespace ockham::viewer {
namespace {

constexpr float kHeight = 150, kReach = 8; ///< pixels

ImU32 color_of(glm::dvec3 linear, int alpha = 255) {
    const auto code = [](double v) {
        return static_cast<int>(std::lround(255 * srgb_encode(static_cast<float>(v))));
    };
    return IM_COL32(code(linear.x), code(linear.y), code(linear.z), alpha);
}

/// Where values and opacities are on the screen.
struct Axes {
    ImVec2 origin; ///< lower left
    float width = 1;
    double low = 0, high = 1;

    float x(double value) const {
        return origin.x + width * static_cast<float>((value - low) / (high - low));
    }
    float y(double opacity) const { return origin.y - kHeight * static_cast<float>(opacity); }
    double value(float at) const {
        return low + (high - low) * static_cast<double>((at - origin.x) / width);
    }
    double opacity(float at) const { return static_cast<double>((origin.y - at) / kHeight); }
};

/// Counts by their logarithm: emptiness would hide all else.
void draw_histogram(ImDrawList& list, const Axes& axes, const Histogram& histogram) {
    double most = 1;
    for (const std::uint64_t count : histogram.counts)
        most = std::max(most, std::log1p(static_cast<double>(count)));
    const auto bins = static_cast<float>(histogram.counts.size());
    for (std::size_t i = 0; i < histogram.counts.size(); ++i) {
        const double share = std::log1p(static_cast<double>(histogram.counts[i])) / most;
        const float x0 = axes.origin.x + axes.width * static_cast<float>(i) / bins,
                    x1 = axes.origin.x + axes.width * static_cast<float>(i + 1) / bins;
        list.AddRectFilled({x0, axes.y(0.92 * share)}, {std::max(x1, x0 + 1), axes.y(0)},
            IM_COL32(66, 72, 82, 255));
    }
}

void draw_function(ImDrawList& list, const Axes& axes, const TransferFunction& transfer) {
    constexpr int kParts = 128;
    for (int i = 0; i < kParts; ++i) { // the colour at its opacity
        const double a = axes.low + (axes.high - axes.low) * i / kParts,
                     b = axes.low + (axes.high - axes.low) * (i + 1) / kParts;
        const TransferPoint point = transfer.at(0.5 * (a + b));
        list.AddRectFilled(
            {axes.x(a), axes.y(point.opacity)}, {axes.x(b), axes.y(0)}, color_of(point.color, 60));
    }
    ImVec2 last{axes.x(axes.low), axes.y(transfer.at(axes.low).opacity)};
    for (const TransferPoint& point : transfer.points) {
        const ImVec2 next{
            std::clamp(axes.x(point.value), axes.origin.x, axes.origin.x + axes.width),
            axes.y(point.opacity)};
        list.AddLine(last, next, IM_COL32(230, 230, 230, 255), 1.5f);
        last = next;
    }
    list.AddLine(last, {axes.x(axes.high), last.y}, IM_COL32(230, 230, 230, 255), 1.5f);
}

int nearest_point(const Axes& axes, const TransferFunction& transfer, ImVec2 mouse) {
    int best = -1;
    float least = kReach * kReach;
    for (std::size_t i = 0; i < transfer.points.size(); ++i) {
        const float dx = axes.x(transfer.points[i].value) - mouse.x,
                    dy = axes.y(transfer.points[i].opacity) - mouse.y;
        if (dx * dx + dy * dy < least) least = dx * dx + dy * dy, best = static_cast<int>(i);
    }
    return best;
}

int nearest_isovalue(const Axes& axes, const std::vector<double>& isovalues, ImVec2 mouse) {
    for (std::size_t i = 0; i < isovalues.size(); ++i)
        if (std::abs(axes.x(isovalues[i]) - mouse.x) < 0.6f * kReach) return static_cast<int>(i);
    return -1;
}

bool edit_color(const char* label, glm::dvec3& linear) {
    float encoded[3];
    for (int c = 0; c < 3; ++c) encoded[c] = srgb_encode(static_cast<float>(linear[c]));
    if (!ImGui::ColorEdit3(label, encoded, ImGuiColorEditFlags_NoInputs)) return false;
    for (int c = 0; c < 3; ++c) linear[c] = static_cast<double>(srgb_decode(encoded[c]));
    return true;
}

} // namespace

void move_point(TransferFunction& transfer, std::size_t point, double value, double opacity,
    double low, double high) {
    std::vector<TransferPoint>& points = transfer.points;
    const double left = point > 0 ? points[point - 1].value : low;
    const double right = point + 1 < points.size() ? points[point + 1].value : high;
    points[point].value = std::clamp(value, std::min(left, right), std::max(left, right));
    points[point].opacity = std::clamp(opacity, 0.0, 1.0);
}

TransferEdit TransferEditor::draw(
    const Histogram& histogram, TransferFunction& transfer, std::vector<double>& isovalues) {
    TransferEdit edit;
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    Axes axes{.origin = {corner.x, corner.y + kHeight},
        .width = ImGui::GetContentRegionAvail().x,
        .low = histogram.low,
        .high = std::max(histogram.high, histogram.low + 1e-9)};
    ImDrawList& list = *ImGui::GetWindowDrawList();
    list.AddRectFilled(
        corner, {corner.x + axes.width, corner.y + kHeight}, IM_COL32(36, 38, 42, 255));
    draw_histogram(list, axes, histogram);
    draw_function(list, axes, transfer);
    for (const double value : isovalues)
        list.AddLine({axes.x(value), corner.y}, {axes.x(value), corner.y + kHeight},
            IM_COL32(219, 158, 64, 255), 2);
    for (std::size_t i = 0; i < transfer.points.size(); ++i) {
        const TransferPoint& point = transfer.points[i];
        const ImVec2 at{axes.x(point.value), axes.y(point.opacity)};
        list.AddCircleFilled(at, 5, color_of(point.color));
        list.AddCircle(at, 5,
            static_cast<int>(i) == point_ ? IM_COL32(219, 158, 64, 255) : IM_COL32(20, 20, 20, 255),
            16, 2);
    }

    ImGui::InvisibleButton("transfer", {axes.width, kHeight},
        ImGuiButtonFlags_MouseButtonLeft | ImGuiButtonFlags_MouseButtonRight);
    const ImVec2 mouse = ImGui::GetIO().MousePos;
    const int under = nearest_point(axes, transfer, mouse);
    if (ImGui::IsItemClicked(0)) {
        dragged_ = under;
        dragged_iso_ = under < 0 ? nearest_isovalue(axes, isovalues, mouse) : -1;
        if (under >= 0) point_ = under;
        if (under < 0 && dragged_iso_ < 0 && ImGui::IsMouseDoubleClicked(0)) {
            const double value = axes.value(mouse.x);
            TransferPoint point = transfer.at(value);
            point.value = value;
            point.opacity = std::clamp(axes.opacity(mouse.y), 0.0, 1.0);
            const auto after =
                std::ranges::upper_bound(transfer.points, value, {}, &TransferPoint::value);
            point_ = dragged_ = static_cast<int>(after - transfer.points.begin());
            transfer.points.insert(after, point);
            edit.transfer = true;
        }
    }
    if (ImGui::IsItemClicked(1) && under >= 0 && transfer.points.size() > 1) {
        transfer.points.erase(transfer.points.begin() + under);
        point_ = dragged_ = -1;
        edit.transfer = true;
    }
    const ImVec2 moved = ImGui::GetIO().MouseDelta;
    if (ImGui::IsItemActive() && (moved.x != 0 || moved.y != 0)) {
        if (dragged_ >= 0) {
            move_point(transfer, static_cast<std::size_t>(dragged_), axes.value(mouse.x),
                axes.opacity(mouse.y), axes.low, axes.high);
            edit.transfer = true;
        } else if (dragged_iso_ >= 0) {
            isovalues[static_cast<std::size_t>(dragged_iso_)] =
                std::clamp(axes.value(mouse.x), axes.low, axes.high);
            edit.isovalues = true;
        }
    }
    if (ImGui::IsItemHovered() && !ImGui::IsItemActive())
        tooltip(fmt::format("{:.5g}\ndrag points and isovalues; double click adds a point, a right "
                            "click removes one",
            axes.value(mouse.x)));

    if (point_ >= 0 && point_ < static_cast<int>(transfer.points.size())) {
        TransferPoint& point = transfer.points[static_cast<std::size_t>(point_)];
        ImGui::TextDisabled("value %.5g, opacity %.3f", point.value, point.opacity);
        edit.transfer = edit_color("colour", point.color) || edit.transfer;
        ImGui::SameLine();
        const auto most = [](glm::dvec3 v) { return std::max({v.x, v.y, v.z}); };
        auto glow = static_cast<float>(most(point.emission) / std::max(most(point.color), 1e-3));
        ImGui::SetNextItemWidth(-70);
        if (ImGui::SliderFloat("emission", &glow, 0, 20, "%.2f", ImGuiSliderFlags_Logarithmic)) {
            point.emission = glm::dvec3(static_cast<double>(glow)) * point.color;
            edit.transfer = true;
        }
    }
    return edit;
}

} // namespace ockham::viewer
