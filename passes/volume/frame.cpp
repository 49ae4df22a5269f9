// SPDX-License-Identifier: Apache-2.0
#include "passes/volume/frame.hpp"

#include "framework/core/error.hpp"

#include <algorithm>
#include <cmath>

namespace ockham {
namespace {

void check_view(const VolumeView& view) {
    if (view.surfaces.size() > MAX_SURFACES) {
        fail_input("the view has {} isovalues; at most {} are shown at once", view.surfaces.size(),
            MAX_SURFACES);
    }
    if (view.clip_planes.size() > MAX_CLIP_PLANES) {
        fail_input("the view has {} clip planes; at most {} are kept beside the crop box",
            view.clip_planes.size(), MAX_CLIP_PLANES);
    }
    for (const glm::vec4& plane : view.clip_planes) {
        if (!(glm::length(glm::vec3(plane)) > 0)) {
            fail_input("clip plane ({}, {}, {}, {}): its normal has no length", plane.x, plane.y,
                plane.z, plane.w);
        }
    }
    for (int axis = 0; axis < 3; ++axis) {
        if (view.crop_min[axis] < view.crop_max[axis]) continue;
        fail_input("the crop box is empty along axis {}: {} to {}", "xyz"[axis],
            view.crop_min[axis], view.crop_max[axis]);
    }
    const auto demand = [](bool holds, const char* name, float value, const char* range) {
        if (!holds) fail_input("{} is {}; expected a number in {}", name, value, range);
    };
    demand(std::isfinite(view.density_scale) && view.density_scale >= 0, "the density scale",
        view.density_scale, "[0, infinity)");
    demand(view.albedo >= 0 && view.albedo <= 1, "the albedo", view.albedo, "[0, 1]");
    demand(std::abs(view.phase_g) < 1, "the phase function's g", view.phase_g, "(-1, 1)");
    const float light = glm::length(view.light_direction);
    demand(light > 0 && std::isfinite(light), "the length of the light's direction", light,
        "(0, infinity)");
}

void set_place(shader::VolumeFrame& frame, const VolumePlace& place, const VolumeView& view) {
    const glm::dmat3 inverse = glm::inverse(place.edges);
    const glm::dvec3 offset = inverse * place.corner;
    for (int row = 0; row < 3; ++row) {
        frame.unit_from_world[row] =
            glm::vec4(inverse[0][row], inverse[1][row], inverse[2][row], -offset[row]);
    }
    frame.world_from_unit = place.edges;
    frame.corner = place.corner;
    frame.crop_min = glm::max(view.crop_min, glm::vec3(0.0f));
    frame.crop_max = glm::min(view.crop_max, glm::vec3(1.0f));
    frame.clip_count = static_cast<std::uint32_t>(view.clip_planes.size());
    for (std::size_t i = 0; i < view.clip_planes.size(); ++i) {
        const glm::vec4 plane = view.clip_planes[i];
        frame.clip_planes[i] = plane / glm::length(glm::vec3(plane));
    }
}

void set_medium(shader::VolumeFrame& frame, const VolumeGpu& volume, const VolumeView& view) {
    const TransferTable& table = volume.table();
    frame.dims = volume.facts().dims;
    frame.cells = volume.facts().cells;
    frame.table_size = static_cast<std::uint32_t>(table.entries.size());
    frame.table_first = volume.texel_of(table.first);
    frame.table_scale = static_cast<float>(frame.table_size - 1) /
                        (volume.texel_of(table.last) - frame.table_first);
    frame.density_scale = view.density_scale;
    frame.albedo = view.albedo;
    frame.phase_g = view.phase_g;
    frame.majorant = view.density_scale * volume.max_opacity();
    for (const glm::vec3& emission : table.emission) {
        const float luminance = glm::dot(emission, glm::vec3(0.2126f, 0.7152f, 0.0722f));
        frame.emission_most = std::max(frame.emission_most, luminance);
    }
}

void set_camera(shader::VolumeFrame& frame, const Camera& camera, glm::uvec2 size) {
    const float aspect = static_cast<float>(size.x) / static_cast<float>(size.y);
    const bool orthographic = camera.orthographic_height > 0.0f;
    const float half_height = orthographic ? 0.5f * camera.orthographic_height
                                           : std::tan(0.5f * glm::radians(camera.fov_y_degrees));
    const glm::vec3 right = glm::normalize(glm::cross(camera.forward, camera.up));
    frame.position = camera.position;
    frame.right = right * half_height * aspect;
    frame.up = glm::cross(right, camera.forward) * half_height;
    frame.forward = camera.forward;
    frame.orthographic = orthographic ? 1u : 0u;
    frame.size = size;
}

} // namespace

shader::VolumeFrame make_volume_frame(const VolumePlace& place, const VolumeGpu& volume,
    const Camera& camera, std::uint32_t width, std::uint32_t height, const VolumeView& view) {
    check_view(view);
    shader::VolumeFrame frame{};
    set_place(frame, place, view);
    set_medium(frame, volume, view);
    set_camera(frame, camera, {width, height});
    frame.light_direction = glm::normalize(view.light_direction);
    frame.light_irradiance = view.light_irradiance;
    const bool map = volume.facts().environment_map;
    frame.environment = map ? volume.environment_mean() : view.environment;
    frame.environment_size = volume.environment_size();
    frame.surface_count = static_cast<std::uint32_t>(view.surfaces.size());
    for (std::size_t i = 0; i < view.surfaces.size(); ++i) {
        const VolumeView::Surface& surface = view.surfaces[i];
        // A voxel of just this value is inside, however samplers round the quotient of its code.
        const float value = volume.texel_of(surface.value);
        frame.surfaces[i] = {value - 0x1p-22f * std::abs(value), surface.opacity, surface.material};
    }
    frame.shading = view.shading;
    frame.surface_gain = view.surface_gain;
    frame.volume_gain = view.volume_gain;
    frame.seed = view.seed;
    frame.max_bounces = view.max_bounces;
    return frame;
}

void set_part(shader::VolumeFrame& frame, glm::uvec2 size, glm::uvec2 origin) {
    const glm::vec2 picture(frame.size), part(size), corner(origin);
    const glm::vec2 center = (2.0f * corner + part) / picture - 1.0f; // -1 ... 1, down
    const glm::vec3 aside = center.x * frame.right - center.y * frame.up;
    (frame.orthographic != 0 ? frame.position : frame.forward) += aside;
    frame.right *= part.x / picture.x;
    frame.up *= part.y / picture.y;
    frame.size = size;
}

Camera volume_camera() { return look_at({0.0f, -2.6f, 0.0f}, glm::vec3(0.0f), 30.0f); }

} // namespace ockham
