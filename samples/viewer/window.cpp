// SPDX-License-Identifier: Apache-2.0
#include "samples/viewer/window.hpp"

#include "framework/core/error.hpp"

#include <GLFW/glfw3.h>

#include <utility>

namespace ockham::viewer {
namespace {

/// What GLFW says of its last failure.
std::string reason() {
    const char* text = nullptr;
    glfwGetError(&text);
    return text ? text : "GLFW gives no reason";
}

} // namespace

Window::Window(int width, int height, const std::string& title) {
    if (!glfwInit())
        fail_device("cannot open a window: {}; viewer needs a desktop, or xvfb-run", reason());
    try {
        if (!glfwVulkanSupported())
            fail_device("cannot open a window: {}; install a Vulkan driver that can present, for "
                        "example the package mesa-vulkan-drivers",
                reason());
        glfwWindowHint(GLFW_CLIENT_API, GLFW_NO_API);
        window_ = glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr);
        if (!window_) fail_device("cannot open a window of {} x {}: {}", width, height, reason());
    } catch (...) {
        glfwTerminate();
        throw;
    }
    glfwSetWindowSizeLimits(window_, 320, 240, GLFW_DONT_CARE, GLFW_DONT_CARE);
    glfwSetWindowUserPointer(window_, this);
    glfwSetDropCallback(window_, [](GLFWwindow* window, int count, const char** files) {
        auto& self = *static_cast<Window*>(glfwGetWindowUserPointer(window));
        self.dropped_.insert(self.dropped_.end(), files, files + count);
    });
}

Window::~Window() {
    glfwDestroyWindow(window_);
    glfwTerminate();
}

std::vector<std::string> Window::instance_extensions() const {
    std::uint32_t count = 0;
    const char** names = glfwGetRequiredInstanceExtensions(&count);
    if (!names) fail_device("Vulkan cannot present to this desktop: {}", reason());
    return {names, names + count};
}

void Window::set_title(const std::string& title) { glfwSetWindowTitle(window_, title.c_str()); }

void Window::poll(double seconds) {
    if (seconds > 0)
        glfwWaitEventsTimeout(seconds);
    else
        glfwPollEvents();
}

bool Window::should_close() const { return glfwWindowShouldClose(window_); }

glm::ivec2 Window::size() const {
    glm::ivec2 size(0);
    if (glfwGetWindowAttrib(window_, GLFW_ICONIFIED)) return size; // some desktops keep its size
    glfwGetFramebufferSize(window_, &size.x, &size.y);
    return size;
}

std::vector<std::string> Window::take_dropped() { return std::exchange(dropped_, {}); }

void Window::copy_text(const std::string& text) { glfwSetClipboardString(window_, text.c_str()); }

} // namespace ockham::viewer
