// SPDX-License-Identifier: Apache-2.0
// What mouse and keys do in the picture.
#include "samples/viewer/viewer.hpp"

#include <imgui.h>

#include <algorithm>
#include <cmath>

namespace ockham::viewer {
namespace {

constexpr float kRadiansPerPixel = 0.006f;

} // namespace

void Viewer::changed_camera() {
    touched_ = clock_.seconds();
    dirty_ = true;
    camera_text_ = camera();
    subject_->technique->set_camera(navigation_.camera());
    error_.reset();
    if (!rival_) return;
    rival_->set_camera(navigation_.camera());
    rival_steps_ = 0;
    reference_.reset(); // it looks from elsewhere
}

/// By so many pixels of a drag.
void Viewer::turn(float right, float down) {
    if (fly_)
        navigation_.look(kRadiansPerPixel * 0.5f * right, -kRadiansPerPixel * 0.5f * down);
    else
        navigation_.orbit(kRadiansPerPixel * right, -kRadiansPerPixel * down);
    changed_camera();
}

void Viewer::handle_mouse() {
    const ImGuiIO& io = ImGui::GetIO();
    const bool busy = io.MouseDelta.x != 0 || io.MouseDelta.y != 0 || io.MouseWheel != 0 ||
                      ImGui::IsAnyMouseDown();
    if (busy) input_ = clock_.seconds();
    if (io.WantCaptureMouse) return;
    const float right = io.MouseDelta.x, down = io.MouseDelta.y;
    const bool moved = right != 0 || down != 0;
    const auto height = static_cast<float>(area_.y);
    if (moved && ImGui::IsMouseDown(0)) {
        turn(right, down);
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
    if (pressed('B')) flip_ = !flip_, redraw_ = true;
    if (pressed('L') && !canvas_.rgba.empty()) {
        const glm::vec2 mouse(io.MousePos.x, io.MousePos.y);
        loupe_ = glm::clamp(glm::ivec2(mouse * glm::vec2(canvas_.size) / glm::vec2(area_)),
            glm::ivec2(0), canvas_.size - 1);
        samples_old_ = true;
    }
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

} // namespace ockham::viewer
