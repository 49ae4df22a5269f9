// SPDX-License-Identifier: Apache-2.0
// What the viewer shows: a scene, a volume or both, with its declared parameters, its pictures step
// by step, and what can be laid over them. One implementation per pipeline; none knows of windows.
#pragma once

#include "framework/app/cli.hpp"
#include "framework/runtime/executor.hpp"
#include "framework/scene/camera.hpp"
#include "samples/viewer/canvas.hpp"
#include "samples/viewer/loupe.hpp"

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace ockham::viewer {

/// Where navigation begins.
struct Stage {
    Camera camera;
    glm::vec3 pivot{0.0f};
    float scale = 1; ///< a length of the scene
    UpAxis up = UpAxis::y;
    bool inside = false; ///< the camera is in the midst of it: turning beats orbiting
};

class Technique {
public:
    virtual ~Technique() = default;

    /// The program that takes the same flags and run files.
    virtual const char* program() const = 0;
    /// What of it was loaded, in a few words.
    virtual std::string title() const = 0;
    virtual Stage stage() const = 0;

    /// Its declared parameters have changed: `names`. Takes place with the next render(); Throws
    /// Error(input) naming the flag where they do not fit together.
    virtual void change(const std::vector<std::string>& names) = 0;
    virtual void set_camera(const Camera& camera) = 0;

    /// One step of the picture, `size` pixels. `hurry`: something is being dragged; short steps
    /// matter more than exact ones. Throws Error, also later for what change() could not see.
    virtual void render(glm::uvec2 size, bool hurry) = 0;
    /// Nothing would get better by another step that is not in a hurry.
    virtual bool finished() const = 0;
    /// Linear R, G, B, A of the last step.
    virtual Image picture() = 0;

    /// Names of what overlay() gives; the wanted one may cost something in render().
    virtual std::vector<std::string> overlays() const = 0;
    virtual void want_overlay(const std::string& name) = 0;
    virtual std::optional<Overlay> overlay(const std::string& name) = 0;

    /// The samples of one pixel of the picture; nothing where it has none that are known by place.
    virtual std::optional<SampleGrid> samples(glm::ivec2) { return {}; }
    /// What samples() keeps for its next call, which makes it anew.
    virtual void forget_samples() {}

    /// How this one renders, and other ways, by name; one of them with all else equal: B of an A/B.
    virtual std::string method() const = 0;
    virtual std::vector<std::string> rivals() const = 0;
    virtual std::unique_ptr<Technique> rival(const std::string& name) = 0;

    /// (label, value) for people, of the last step.
    virtual std::vector<std::pair<std::string, std::string>> facts() = 0;
    /// Null before the first render().
    virtual Executor* executor() = 0;
    virtual std::vector<PassTime> times() = 0;
};

} // namespace ockham::viewer
