// SPDX-License-Identifier: Apache-2.0
// The camera of a picture: where its samples lie, and what their stored depth means. Needs `frame`
// (shared/frame.h). Positions are samples of the images, not of the whole picture.

/// Distance along the camera's forward axis, world units. Background: frame.background_depth.
float view_depth(float stored) {
    if (stored <= 0.0) return frame.data.background_depth;
    return frame.data.orthographic != 0u ? frame.data.far_distance * (1.0 - stored)
                                         : frame.data.near_distance / stored;
}

/// What the G-buffer stores for it.
float stored_depth(float view) {
    return frame.data.orthographic != 0u ? 1.0 - view / frame.data.far_distance
                                         : min(frame.data.near_distance / view, 1.0);
}

/// World units across one sample, at view depth 1 under perspective: to the right and down.
vec3 sample_right() { return frame.data.right * (2.0 / float(frame.data.picture.x * frame.data.m)); }
vec3 sample_down() { return frame.data.up * (-2.0 / float(frame.data.picture.y * frame.data.m)); }

/// From the camera's axis to the centre of a sample, in the plane at view depth 1.
vec3 sample_across(ivec2 position) {
    vec2 extent = vec2(frame.data.picture * frame.data.m);
    ivec2 in_picture = position + frame.data.origin * int(frame.data.m);
    vec2 ndc = (vec2(in_picture) + 0.5 + frame.data.jitter) / extent * vec2(2.0, -2.0) + vec2(-1.0, 1.0);
    return ndc.x * frame.data.right + ndc.y * frame.data.up;
}

/// World position of the centre of a sample at a view depth.
vec3 sample_world(ivec2 position, float depth) {
    vec3 across = sample_across(position);
    return frame.data.position + depth * frame.data.forward +
           (frame.data.orthographic != 0u ? across : across * depth);
}

/// Direction from a surface point to the camera, unit.
vec3 to_camera(vec3 world) {
    return frame.data.orthographic != 0u ? -frame.data.forward
                                         : normalize(frame.data.position - world);
}
