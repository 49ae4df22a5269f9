// SPDX-License-Identifier: Apache-2.0
// The viewer's loop, frame by frame, in a window of a virtual X server: what a person sees while
// an isovalue is dragged, files that another program drops, and a window that is minimised.
#include "framework/core/file.hpp"
#include "samples/viewer/viewer.hpp"
#include "samples/viewer/widgets.hpp"
#include "tests/support/virtual_screen.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <memory>

// Xlib defines words as macros, and must come last.
#include <X11/Xatom.h>
#include <X11/Xlib.h>
#include <X11/Xutil.h>
#undef None

namespace ockham::viewer {
namespace {

/// Another program on the same screen: it looks at pixels, moves the mouse, and drops files.
class OtherProgram {
public:
    explicit OtherProgram(const std::string& screen)
        : screen_(screen), display_(XOpenDisplay(screen.c_str())),
          root_(DefaultRootWindow(display_)),
          own_(XCreateSimpleWindow(display_, root_, 0, 0, 1, 1, 0, 0, 0)) {}
    ~OtherProgram() { XCloseDisplay(display_); }

    void mouse(const std::string& action) const {
        const std::string command = "DISPLAY=" + screen_ + " xdotool " + action;
        ASSERT_EQ(std::system(command.c_str()), 0) << command;
    }

    /// The column of the screen, from `left` on, that has most pixels of a colour, if it has
    /// `least` of them, and the row of the middle one; -1 without.
    glm::ivec2 find_line(glm::ivec3 color, int left, int least) const {
        XWindowAttributes all{};
        XGetWindowAttributes(display_, root_, &all);
        XImage* const image = XGetImage(display_, root_, 0, 0, static_cast<unsigned>(all.width),
            static_cast<unsigned>(all.height), AllPlanes, ZPixmap);
        const unsigned long wanted =
            static_cast<unsigned long>(color.r << 16 | color.g << 8 | color.b);
        glm::ivec2 best(-1);
        for (int x = left; x < all.width; ++x) {
            int count = 0, sum = 0;
            for (int y = 0; y < all.height; ++y)
                if ((XGetPixel(image, x, y) & 0xffffff) == wanted) ++count, sum += y;
            if (count >= least) best = {x, sum / count}, least = count + 1;
        }
        XDestroyImage(image);
        return best;
    }

    ::Window viewer_window() const {
        ::Window root = 0, parent = 0, *children = nullptr;
        unsigned count = 0;
        XQueryTree(display_, root_, &root, &parent, &children, &count);
        ::Window found = 0;
        for (unsigned i = 0; i < count; ++i) {
            char* name = nullptr;
            if (XFetchName(display_, children[i], &name) && name &&
                std::string(name).find("Ockham") != std::string::npos)
                found = children[i];
            if (name) XFree(name);
        }
        XFree(children);
        return found;
    }

    /// As a window manager says it.
    void set_minimised(bool minimised) const {
        const long state[] = {minimised ? IconicState : NormalState, 0};
        XChangeProperty(display_, viewer_window(), atom("WM_STATE"), atom("WM_STATE"), 32,
            PropModeReplace, reinterpret_cast<const unsigned char*>(state), 2);
        XSync(display_, False);
    }

    /// Drags files onto the window and drops them, by the protocol XDND 5.
    void begin_drop(const std::vector<std::string>& files) {
        uris_.clear();
        for (const std::string& file : files) uris_ += "file://" + file + "\r\n";
        XSetSelectionOwner(display_, atom("XdndSelection"), own_, CurrentTime);
        send("XdndEnter", {5L << 24, static_cast<long>(atom("text/uri-list")), 0, 0});
        send("XdndPosition",
            {0, 100L << 16 | 100, CurrentTime, static_cast<long>(atom("XdndActionCopy"))});
    }
    /// Answers; true once the viewer has taken the files.
    bool finish_drop() {
        bool finished = false;
        while (XPending(display_) > 0) {
            XEvent event;
            XNextEvent(display_, &event);
            if (event.type == SelectionRequest) give(event.xselectionrequest);
            if (event.type != ClientMessage) continue;
            if (event.xclient.message_type == atom("XdndStatus") && (event.xclient.data.l[1] & 1))
                send("XdndDrop", {0, CurrentTime, 0, 0});
            finished = finished || event.xclient.message_type == atom("XdndFinished");
        }
        return finished;
    }

private:
    Atom atom(const char* name) const { return XInternAtom(display_, name, False); }

    void send(const char* type, const std::array<long, 4>& data) const {
        XEvent event{};
        event.xclient.type = ClientMessage;
        event.xclient.window = viewer_window();
        event.xclient.message_type = atom(type);
        event.xclient.format = 32;
        event.xclient.data.l[0] = static_cast<long>(own_);
        for (std::size_t i = 0; i < data.size(); ++i) event.xclient.data.l[i + 1] = data[i];
        XSendEvent(display_, event.xclient.window, False, NoEventMask, &event);
        XFlush(display_);
    }

    void give(const XSelectionRequestEvent& request) const {
        XChangeProperty(display_, request.requestor, request.property, request.target, 8,
            PropModeReplace, reinterpret_cast<const unsigned char*>(uris_.data()),
            static_cast<int>(uris_.size()));
        XEvent event{};
        event.xselection.type = SelectionNotify;
        event.xselection.requestor = request.requestor;
        event.xselection.selection = request.selection;
        event.xselection.target = request.target;
        event.xselection.property = request.property;
        event.xselection.time = request.time;
        XSendEvent(display_, request.requestor, False, NoEventMask, &event);
        XFlush(display_);
    }

    std::string screen_, uris_;
    Display* display_;
    ::Window root_, own_;
};

class ViewerWindow : public testing::Test {
protected:
    ViewerWindow() {
        std::filesystem::create_directories(folder);
        // A ball whose values fall from 255 in the middle to 0 at the sides.
        std::string ball(kSide * kSide * kSide, '\0');
        for (int i = 0; i < kSide * kSide * kSide; ++i) {
            const glm::vec3 p(i % kSide, i / kSide % kSide, i / kSide / kSide);
            const float r = glm::distance(p, glm::vec3(0.5f * (kSide - 1))) / (0.5f * kSide);
            ball[static_cast<std::size_t>(i)] =
                static_cast<char>(std::lround(255 * std::max(0.0f, 1 - r)));
        }
        write_text(folder / "ball.raw", ball);
        write_text(folder / "ball.json",
            R"({"file": "ball.raw", "dims": [24, 24, 24], "type": "uint8", "spacing_mm": [1, 1, 1]})");
        write_text(folder / "fog.json", R"({"points": [{"value": 0, "opacity": 0},
            {"value": 30, "opacity": 0.3}, {"value": 255, "opacity": 0.3}]})");
    }
    ~ViewerWindow() override { std::filesystem::remove_all(folder); }

    void SetUp() override {
        ASSERT_FALSE(screen.name.empty()) << "Xvfb does not start";
        ::setenv("DISPLAY", screen.name.c_str(), 1);
        ::unsetenv("WAYLAND_DISPLAY");
        ::setenv("XDG_CONFIG_HOME", folder.c_str(), 1);
        other = std::make_unique<OtherProgram>(screen.name);
    }

    void open(std::unique_ptr<Subject> subject) {
        gui = std::make_unique<Gui>();
        window = std::make_unique<viewer::Window>(kSize.x, kSize.y, "Ockham viewer");
        gpu::DeviceOptions options;
        options.instance_extensions = window->instance_extensions();
        options.device_extensions = Presenter::device_extensions();
        // Not `sync`, whose layer forgets that the host has waited before memory is used again.
        options.validation = gpu::Validation::core;
        device = std::make_unique<gpu::Device>(options);
        presenter = std::make_unique<Presenter>(*window, *device);
        viewer = std::make_unique<Viewer>(*window, *device, *presenter, std::move(subject));
    }
    void TearDown() override {
        viewer.reset();
        presenter.reset();
        if (device) {
            EXPECT_NO_THROW(expect_no_validation_messages(*device));
        }
    }

    template <class Done>
    void frames_until(Done done, const char* what) {
        const Timer timer;
        bool is_done = done();
        for (; !is_done && timer.seconds() < 60; is_done = done()) viewer->frame();
        ASSERT_TRUE(is_done) << what;
    }

    static constexpr int kSide = 24;             ///< voxels
    static constexpr glm::ivec2 kSize{440, 340}; ///< of the window
    const std::filesystem::path folder =
        std::filesystem::temp_directory_path() / ("ockham_window." + std::to_string(::getpid()));
    test::VirtualScreen screen;
    std::unique_ptr<OtherProgram> other;
    std::unique_ptr<Gui> gui;
    std::unique_ptr<viewer::Window> window;
    std::unique_ptr<gpu::Device> device;
    std::unique_ptr<Presenter> presenter;
    std::unique_ptr<Viewer> viewer;
};

float luminance(const Image& image, int x, int y) {
    return 0.2126f * image.at(x, y, 0) + 0.7152f * image.at(x, y, 1) + 0.0722f * image.at(x, y, 2);
}

/// How a picture in haste differs from the whole one of the same view.
struct Haste {
    double brightness = 0; ///< mean, in those of the whole picture
    double noise = 0;      ///< mean absolute difference, likewise
};

Haste compare(const Image& hasty, const Image& whole) {
    double sum = 0, wanted = 0, difference = 0;
    for (int y = 0; y < hasty.height(); ++y) {
        for (int x = 0; x < hasty.width(); ++x) {
            const int u = (2 * x + 1) * whole.width() / (2 * hasty.width()),
                      v = (2 * y + 1) * whole.height() / (2 * hasty.height());
            const double a = luminance(hasty, x, y), b = luminance(whole, u, v);
            sum += a;
            wanted += b;
            difference += std::abs(a - b);
        }
    }
    return {sum / wanted, difference / wanted};
}

TEST_F(ViewerWindow, IsovaluesMoveWithoutABlackOrNoisyRestart) {
    auto subject = std::make_unique<Subject>(Kind::volume);
    VolumeViewerOptions& o = subject->options.volume;
    o.volume.volume = {(folder / "ball.json").string()};
    o.volume.transfer = (folder / "fog.json").string();
    o.volume.iso = "120";
    o.volume.density_scale = 20;
    o.method.max_bounces = 4;
    o.volume.environment = "1,1,1"; // met by chance alone: a cell that begins anew is noisy
    o.method.cache_scale = 4;
    o.method.gather = false; // whole pictures and those in haste from the same cells
    o.steps = 8;
    open(std::move(subject));
    const auto still = [&] { return viewer->still(); };
    frames_until(still, "the first picture");

    // The tab that has isovalues, by looking: they are lines in the accent's colour.
    const glm::ivec3 accent(219, 158, 64);
    const int left = kSize.x - 352;
    glm::ivec2 line(-1);
    for (int x = left + 20; line.x < 0 && x < kSize.x; x += 40) {
        other->mouse("mousemove " + std::to_string(x) + " 20 click 1");
        for (int i = 0; i < 3; ++i) viewer->frame();
        line = other->find_line(accent, left, 100);
    }
    ASSERT_GE(line.x, 0) << "no isovalue on the screen";
    frames_until(still, "the picture beside another tab");

    double iso = 120;
    for (const int pixels : {12, 12, -30}) { // smaller, smaller, larger than ever
        other->mouse(
            "mousemove " + std::to_string(line.x) + " " + std::to_string(line.y) + " mousedown 1");
        for (int i = 0; i < 3; ++i) viewer->frame();
        std::vector<Image> seen;
        for (int i = 0; i < 3; ++i) {
            line.x += pixels / 3;
            other->mouse("mousemove " + std::to_string(line.x) + " " + std::to_string(line.y));
            for (int k = 0; k < 2; ++k) {
                viewer->frame();
                if (i == 2) seen.push_back(viewer->picture());
            }
        }
        other->mouse("mouseup 1");
        const std::string& text = viewer->subject().options.volume.volume.iso;
        const double now = std::stod(text);
        EXPECT_GT((now - iso) * pixels, 0) << "the isovalue did not move: " << text;
        iso = now;
        frames_until(still, "the picture of another isovalue");
        for (const Image& hasty : seen) {
            const Haste haste = compare(hasty, viewer->picture());
            EXPECT_NEAR(haste.brightness, 1, 0.05) << "isovalue " << iso;
            EXPECT_LT(haste.noise, 0.05) << "isovalue " << iso;
        }
    }
}

TEST_F(ViewerWindow, FilesOfOtherProgramsAreDroppedOntoIt) {
    const std::string ball = (folder / "ball.json").string(),
                      plinth = OCKHAM_SOURCE_DIR "/samples/surface_volume/plinth.gltf";
    auto subject = std::make_unique<Subject>(Kind::surface);
    subject->options.surface.scene.scenes = {plinth};
    subject->options.surface.method.m = 1;
    open(std::move(subject));
    const auto drop = [&](const std::vector<std::string>& files) {
        other->begin_drop(files);
        frames_until([&] { return other->finish_drop(); }, "the end of the drop");
        viewer->frame();
    };
    drop({ball});
    EXPECT_EQ(viewer->subject().kind, Kind::volume);
    drop({ball, plinth});
    EXPECT_EQ(viewer->subject().kind, Kind::both);
    EXPECT_EQ(viewer->subject().options.world.inputs.size(), 2u);
    drop({(folder / "ball.raw").string()}); // says nothing of its shape
    EXPECT_EQ(viewer->subject().kind, Kind::both) << "what was shown is gone";
    drop({(folder / "fog.json").string()});
    EXPECT_EQ(viewer->subject().options.volume.volume.transfer, folder / "fog.json");
    frames_until([&] { return !viewer->picture().empty(); }, "a picture");
}

TEST_F(ViewerWindow, RestsWhileMinimised) {
    auto subject = std::make_unique<Subject>(Kind::surface);
    subject->options.surface.scene.scenes = {"builtin:plane"};
    subject->options.surface.method.m = 2;
    open(std::move(subject));
    frames_until([&] { return viewer->still(); }, "the first picture");
    other->set_minimised(true);
    EXPECT_EQ(window->size(), glm::ivec2(0));
    for (int i = 0; i < 3; ++i) EXPECT_TRUE(viewer->frame());
    other->set_minimised(false);
    EXPECT_EQ(window->size(), kSize);
    for (int i = 0; i < 3; ++i) EXPECT_TRUE(viewer->frame());
}

} // namespace
} // namespace ockham::viewer
