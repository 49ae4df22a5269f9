// SPDX-License-Identifier: Apache-2.0
#include "samples/viewer/loupe.hpp"

#include "samples/viewer/widgets.hpp"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>

namespace ockham::viewer {
namespace {

constexpr int kAround = 6; ///< pixels on each side of the middle
constexpr ImU32 kAccent = IM_COL32(240, 175, 70, 255);

ImU32 shown(glm::vec3 radiance, const Look& look) {
    int code[3];
    for (int c = 0; c < 3; ++c) {
        const float linear = tonemap(std::exp2(look.exposure) * radiance[c], look.curve);
        code[c] = static_cast<int>(std::lround(255 * srgb_encode(linear)));
    }
    return IM_COL32(code[0], code[1], code[2], 255);
}

} // namespace

void draw_loupe(const Canvas& canvas, glm::ivec2 pixel) {
    ImDrawList& list = *ImGui::GetWindowDrawList();
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    constexpr int kSide = 2 * kAround + 1;
    const float cell = std::floor(ImGui::GetContentRegionAvail().x / kSide);
    for (int y = -kAround; y <= kAround; ++y) {
        for (int x = -kAround; x <= kAround; ++x) {
            const glm::ivec2 at = pixel + glm::ivec2(x, y);
            ImU32 color = IM_COL32(0, 0, 0, 255);
            if (at.x >= 0 && at.y >= 0 && at.x < canvas.size.x && at.y < canvas.size.y) {
                const std::uint8_t* p =
                    canvas.rgba.data() +
                    4 * (static_cast<std::size_t>(at.y) * static_cast<std::size_t>(canvas.size.x) +
                            static_cast<std::size_t>(at.x));
                color = IM_COL32(p[0], p[1], p[2], 255);
            }
            const ImVec2 from{corner.x + cell * static_cast<float>(x + kAround),
                corner.y + cell * static_cast<float>(y + kAround)};
            list.AddRectFilled(from, {from.x + cell, from.y + cell}, color);
        }
    }
    const ImVec2 middle{corner.x + cell * kAround, corner.y + cell * kAround};
    list.AddRect(middle, {middle.x + cell, middle.y + cell}, kAccent, 0, 0, 2);
    ImGui::Dummy({cell * kSide, cell * kSide});
}

void draw_samples(const SampleGrid& grid, const Look& look) {
    ImDrawList& list = *ImGui::GetWindowDrawList();
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    const auto m = static_cast<int>(grid.m);
    const float cell =
        std::floor(std::min(ImGui::GetContentRegionAvail().x, 240.0f) / static_cast<float>(m));
    const ImVec2 mouse = ImGui::GetIO().MousePos;
    for (int y = 0; y < m; ++y) {
        for (int x = 0; x < m; ++x) {
            const auto index = static_cast<std::size_t>(y * m + x);
            const ImVec2 a{
                corner.x + cell * static_cast<float>(x), corner.y + cell * static_cast<float>(y)};
            const ImVec2 b{a.x + cell - 2, a.y + cell - 2};
            list.AddRectFilled(a, b, shown(grid.radiance[index], look));
            // Where surfaces share k, all that is known here is that the first is among them.
            const bool taken = grid.ranks[index] < (grid.by_rank ? grid.count : 1u);
            if (taken) list.AddRect(a, b, kAccent, 0, 0, 2);
            const std::string rank = fmt::format("{}", grid.ranks[index] + 1);
            list.AddText({a.x + 4, a.y + 2}, IM_COL32(0, 0, 0, 160), rank.c_str());
            list.AddText({a.x + 3, a.y + 1}, IM_COL32(255, 255, 255, 220), rank.c_str());
            const bool hovered = mouse.x >= a.x && mouse.x < b.x && mouse.y >= a.y && mouse.y < b.y;
            const glm::vec3 v = grid.radiance[index];
            if (hovered)
                tooltip(fmt::format("sample {} of {}{}\nR {:.5g}\nG {:.5g}\nB {:.5g}{}",
                    grid.ranks[index] + 1, m * m, taken ? ", shaded" : "", v.x, v.y, v.z,
                    grid.paths > 0 ? fmt::format("\nmean of {} paths", grid.paths) : ""));
        }
    }
    ImGui::Dummy({cell * static_cast<float>(m), cell * static_cast<float>(m)});
}

} // namespace ockham::viewer
