// SPDX-License-Identifier: Apache-2.0
// How a person moves a camera: around a point, or through the scene. Angles and distances in,
// camera out; knows no mouse and no window. Called by the viewer.
#pragma once

#include "framework/scene/camera.hpp"

#include <string>

namespace ockham::viewer {

class Navigation {
public:
    /// `pivot`: what orbit() keeps in the middle; `scale`: a length of the scene, > 0, by which
    /// walk() is paced.
    void reset(const Camera& camera, glm::vec3 pivot, float scale, UpAxis up);

    const Camera& camera() const { return camera_; }
    float distance() const { return distance_; }

    /// Around the pivot by angles in radians: to the right about the vertical, and up, as far as
    /// the poles.
    void orbit(float right, float up);
    /// Turns where it stands.
    void look(float right, float up);
    /// Moves sideways with the pivot, in heights of the picture at the pivot's distance.
    void pan(float right, float up);
    /// Multiplies the distance to the pivot, or the height of an orthographic view; factor > 0.
    void zoom(float factor);
    /// Along the view's right, the vertical, and forward, in the scene's lengths.
    void walk(const glm::vec3& right_up_forward);
    /// Keeps everything in view where the pivot should be; distance > 0.
    void set_pivot_distance(float distance) { distance_ = distance; }
    void set_fov(float degrees) { camera_.fov_y_degrees = degrees; }

private:
    void turn(float right, float up);
    glm::vec3 vertical() const;

    Camera camera_;
    float distance_ = 1; ///< of the pivot, along the view
    float scale_ = 1;
    UpAxis up_ = UpAxis::y;
};

/// "px,py,pz tx,ty,tz fov", as --camera takes it; the target is `distance` ahead.
std::string camera_text(const Camera& camera, float distance);

} // namespace ockham::viewer
