// SPDX-License-Identifier: Apache-2.0
// A window of the desktop: GLFW's, with what is dropped onto it. No drawing (presenter.hpp), no
// widgets. Made before the device, which needs the names of its extensions. Called by the viewer.
#pragma once

#include <glm/glm.hpp>

#include <string>
#include <vector>

struct GLFWwindow;

namespace ockham::viewer {

class Window {
public:
    /// Throws Error(device) where there is no desktop, or none that Vulkan can present to.
    Window(int width, int height, const std::string& title);
    ~Window();
    Window(const Window&) = delete;
    Window& operator=(const Window&) = delete;

    /// Of the instance, to present here.
    std::vector<std::string> instance_extensions() const;
    GLFWwindow* handle() const { return window_; }
    void set_title(const std::string& title);

    /// Takes what has happened; waits up to `seconds` for something to happen.
    void poll(double seconds);
    bool should_close() const;
    /// Of what can be drawn to, in pixels; 0 while minimised.
    glm::ivec2 size() const;
    /// Files dropped since; then forgotten.
    std::vector<std::string> take_dropped();
    void copy_text(const std::string& text);

private:
    GLFWwindow* window_ = nullptr;
    std::vector<std::string> dropped_;
};

} // namespace ockham::viewer
