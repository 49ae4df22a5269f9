// SPDX-License-Identifier: Apache-2.0
// The viewer's loop: input to camera and parameters, parameters to pictures, pictures and panels to
// the window. Small pictures while something is dragged, the whole one when all is still. main.cpp
// makes one and runs it.
#pragma once

#include "framework/core/timer.hpp"
#include "framework/image_error/image_error.hpp"
#include "samples/viewer/hurry_scale.hpp"
#include "samples/viewer/navigation.hpp"
#include "samples/viewer/presenter.hpp"
#include "samples/viewer/subject.hpp"
#include "samples/viewer/transfer_editor.hpp"
#include "samples/viewer/window.hpp"

#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace ockham::viewer {

class Viewer {
public:
    /// All must outlive this object. Throws Error(input) where what `subject` names does not load.
    Viewer(Window& window, gpu::Device& device, Presenter& presenter,
        std::unique_ptr<Subject> subject);
    ~Viewer();
    Viewer(const Viewer&) = delete;
    Viewer& operator=(const Viewer&) = delete;
    /// Until the window is closed, or --frames or --orbit are done. Writes what the flags ask for.
    void run();

    /// Takes what has happened, renders a step if there is something to do, and shows it. False
    /// where that was the last one.
    bool frame();
    /// What was rendered last, linear, in haste or whole; empty before.
    const Image& picture() const { return picture_; }
    /// That is as good as it gets, and whole.
    bool still() const { return !dirty_ && !hasty_ && subject_->technique->finished(); }
    const Subject& subject() const { return *subject_; }

private:
    static constexpr int kPanelWidth = 352, kStatusHeight = 28; ///< pixels

    void open(std::unique_ptr<Subject> subject);
    void take_dropped();
    bool takes(const std::string& file);
    void replace(const std::vector<std::string>& sources);
    void load_reference(const std::string& file);
    void restart_rival();
    bool render_rival();
    void save_picture(const std::string& file);
    void listen();

    void layout();
    void handle_mouse();
    void handle_keys();
    void turn(float right, float down);
    void changed_camera();
    void changed_parameters(const std::vector<std::string>& names);
    /// True: there is another picture.
    bool render();
    void show();
    bool present(bool last);
    void attempt(const std::function<void()>& action);

    void draw_panel();
    void draw_parameters();
    void draw_view();
    void draw_overlay();
    void draw_compare();
    void draw_save();
    void draw_volume();
    void draw_isovalues(std::vector<double> isovalues, bool changed);
    void draw_place();
    void draw_graph();
    void draw_reasons();
    void draw_status();
    void draw_message();
    void draw_wipe();
    void draw_loupe_window();

    void save_outputs();
    void save_session();
    bool attended() const { return subject_->frames == 0 && subject_->orbit == 0; }
    bool hurries() const;
    bool rests() const;
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
    std::optional<Image> reference_; ///< B: a stored picture, or the rival's
    std::string reference_name_;     ///< file or method; empty: there is none
    std::unique_ptr<Technique> rival_;
    int rival_steps_ = 0;
    std::optional<ImageError> error_; ///< of the picture against B, once both are done
    bool flip_ = false;               ///< B alone
    Canvas canvas_;
    Look look_;
    bool hasty_ = false;  ///< picture_ is
    bool dirty_ = true;   ///< something has changed since picture_
    bool redraw_ = true;  ///< the canvas is older than what it shows
    bool frozen_ = false; ///< no more steps
    double touched_ = -1; ///< clock_, when something was dragged last
    int steps_ = 0;       ///< of whole pictures, since the start
    int frames_ = 0;      ///< of the window
    double input_ = -1;   ///< clock_, of the last input of any kind
    double render_ms_ = 0;
    double full_ms_ = 0;  ///< of the last whole picture
    std::string message_; ///< an error, until something works
    bool failed_ = false; ///< render() did, and need not try again before something changes

    std::string overlay_;
    std::optional<glm::ivec2> loupe_; ///< pixel of the canvas
    std::optional<SampleGrid> samples_;
    bool samples_old_ = false;
    TransferEditor transfer_;
    bool fly_ = false;
    std::string camera_text_; ///< being edited
    std::string legend_;      ///< of the overlay
    std::vector<std::pair<std::string, std::string>> facts_;
    double facts_time_ = -1;
    std::string picture_file_ = "picture.exr", shot_file_ = "window.png", run_file_ = "run.json";
    bool want_shot_ = false;
    std::set<std::string> said_;          ///< messages so far
    std::vector<std::string> complaints_; ///< warnings and errors that were logged since
};

} // namespace ockham::viewer
