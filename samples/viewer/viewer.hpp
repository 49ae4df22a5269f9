// SPDX-License-Identifier: Apache-2.0
// The viewer's loop: input to camera and parameters, parameters to pictures, pictures and panels to
// the window. Small pictures while something is dragged, the whole one when all is still. main.cpp
// makes one and runs it.
#pragma once

#include "framework/core/timer.hpp"
#include "samples/viewer/navigation.hpp"
#include "samples/viewer/presenter.hpp"
#include "samples/viewer/subject.hpp"
#include "samples/viewer/window.hpp"

#include <optional>
#include <string>
#include <vector>

namespace ockham::viewer {

/// Sizes of pictures in haste, by the time that the last one took.
class HurryScale {
public:
    /// Divides the picture's sides, 1 to 8.
    int divisor() const { return divisor_; }
    /// A picture at the present divisor took so long.
    void add(double milliseconds);
    /// Of all of them.
    double mean_ms() const { return count_ > 0 ? sum_ / count_ : 0; }
    int count() const { return count_; }

private:
    static constexpr double kMost = 140; ///< milliseconds: five frames a second with the rest
    int divisor_ = 4;
    int slow_ = 0; ///< in a row; the first after a change compiles kernels
    double sum_ = 0;
    int count_ = 0;
};

class Viewer {
public:
    /// All must outlive this object. Throws Error(input) where what `subject` names does not load.
    Viewer(Window& window, gpu::Device& device, Presenter& presenter,
        std::unique_ptr<Subject> subject);
    /// Until the window is closed, or --frames. Writes what the flags ask for.
    void run();

private:
    void open(std::unique_ptr<Subject> subject);
    void take_dropped();
    void load_reference(const std::string& file);

    void layout();
    void handle_mouse();
    void handle_keys();
    void changed_camera();
    void changed_parameters(const std::vector<std::string>& names);
    /// True: there is another picture.
    bool render();
    void show();
    template <class Action>
    void attempt(Action action);

    void draw_panel();
    void draw_parameters();
    void draw_view();
    void draw_graph();
    void draw_status();
    void draw_message();

    void save_outputs();
    void save_session();
    bool hurries() const;
    std::string camera() const;

    Window& window_;
    gpu::Device& device_;
    Presenter& presenter_;
    std::unique_ptr<Subject> subject_;
    Navigation navigation_;
    Timer clock_;
    HurryScale hurry_;

    // Layout, pixels of the window.
    glm::ivec2 area_{0}; ///< of the picture, at the window's upper left
    bool panel_ = true;

    // The picture.
    Image picture_;
    std::optional<Image> reference_;
    std::string reference_name_;
    Canvas canvas_;
    Look look_;
    bool hasty_ = false;  ///< picture_ is
    bool dirty_ = true;   ///< something has changed since picture_
    bool redraw_ = true;  ///< the canvas is older than what it shows
    bool frozen_ = false; ///< no more steps
    double touched_ = -1; ///< clock_, when something was dragged last
    int steps_ = 0;       ///< of whole pictures, since the start
    int frames_ = 0;      ///< of the window
    double render_ms_ = 0, frame_ms_ = 0;
    std::string message_; ///< an error, until something works
    bool message_is_error_ = false;

    std::string overlay_;
    bool fly_ = false;
    std::string camera_text_; ///< being edited
    std::vector<std::pair<std::string, std::string>> facts_;
    double facts_time_ = -1;
    bool want_shot_ = false;
    std::string shot_file_;
};

} // namespace ockham::viewer
