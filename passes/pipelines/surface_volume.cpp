// SPDX-License-Identifier: Apache-2.0
#include "passes/pipelines/surface_volume.hpp"

#include "framework/core/error.hpp"

#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>

namespace ockham {

VolumePlace placed(const VolumePlace& place, const VolumePlacement& placement) {
    const auto turn = [](double degrees, const glm::dvec3& axis) {
        return glm::dmat3(glm::rotate(glm::dmat4(1.0), glm::radians(degrees), axis));
    };
    const glm::dvec3 angles(placement.rotation_degrees);
    const glm::dmat3 upright(1, 0, 0, 0, 0, -1, 0, 1, 0); // columns: x stays, y to -z, z to y
    const glm::dmat3 turned =
        turn(angles.z, {0, 0, 1}) * turn(angles.y, {0, 1, 0}) * turn(angles.x, {1, 0, 0}) * upright;
    const double scale = placement.scale;
    return {.corner = glm::dvec3(placement.translation) + scale * (turned * place.corner),
        .edges = scale * (turned * place.edges),
        .world_per_mm = scale * place.world_per_mm};
}

VolumeView lit_by(const Scene& scene, VolumeView view, const glm::vec3& environment) {
    const auto sun = std::ranges::find(scene.lights, LightType::directional, &Light::type);
    view.light_irradiance = glm::vec3(0.0f);
    if (sun != scene.lights.end()) {
        view.light_direction = sun->direction;
        view.light_irradiance = sun->intensity;
    }
    view.environment = environment;
    return view;
}

bool is_transparent(
    const Volume& volume, const TransferFunction& transfer, const VolumeView& view) {
    if (!view.surfaces.empty()) return false;
    if (view.density_scale == 0) return true;
    const ValueRange range = value_range(volume);
    return tabulate(transfer, volume).max_opacity(range.lowest, range.highest) == 0;
}

SurfaceVolume::SurfaceVolume(gpu::Device& device, const LitScene* lit,
    const std::optional<MediumSource>& medium, const Camera& camera,
    const SurfaceVolumeParams& params) {
    check(lit || medium, "a picture of something");
    const bool meshes = lit && (lit->gpu().facts().triangles > 0 || !medium);
    const bool empty =
        meshes && medium && is_transparent(medium->volume, medium->transfer, medium->view);
    if (!medium || empty) {
        AdaptiveAaParams p = params.surfaces;
        p.width = params.medium.width;
        p.height = params.medium.height;
        p.part_of = params.medium.part_of;
        p.captures = params.medium.captures;
        p.no_medium = empty ? "the volume is transparent everywhere" : "no volume";
        surfaces_ = std::make_unique<AdaptiveAa>(device, *lit, camera, p);
        return;
    }
    VolumeGiParams p = params.medium;
    std::unique_ptr<MeshBackground> background;
    if (meshes) {
        p.place = placed(place_of(medium->volume), medium->placement);
        AdaptiveAaParams surfaces = params.surfaces;
        surfaces.part_of = p.part_of;
        background = std::make_unique<MeshBackground>(device, *lit, surfaces);
    } else {
        p.no_meshes = lit ? "the scene has no triangles" : "no scene";
    }
    medium_ = std::make_unique<VolumeGi>(device, medium->volume, medium->transfer,
        medium->environment, medium->view, camera, p, std::move(background));
}

void SurfaceVolume::execute() {
    if (medium_)
        medium_->execute();
    else
        surfaces_->execute();
}

void SurfaceVolume::finish() {
    if (medium_) medium_->finish();
}

void SurfaceVolume::set_camera(const Camera& camera) {
    if (medium_)
        medium_->set_camera(camera);
    else
        surfaces_->set_camera(camera);
}

void SurfaceVolume::set_origin(glm::uvec2 origin) {
    if (medium_)
        medium_->set_origin(origin);
    else
        surfaces_->set_origin(origin);
}

const std::vector<PassTime>& SurfaceVolume::times() const {
    return medium_ ? medium_->executor().times() : surfaces_->times();
}

const std::vector<ImageHandle>& SurfaceVolume::captures() const {
    return medium_ ? medium_->captures() : surfaces_->outputs().captures;
}

std::optional<Image> SurfaceVolume::sample_counts() {
    if (surfaces_) {
        const ImageHandle counts = surfaces_->outputs().sample_count;
        if (!counts) return {};
        return surfaces_->read(counts);
    }
    const MeshBackground* meshes = medium_->meshes();
    if (!meshes || !meshes->sample_count()) return {};
    return medium_->executor().read(meshes->sample_count());
}

std::optional<double> SurfaceVolume::sample_percent() {
    if (surfaces_) return surfaces_->sample_counts().percent;
    const MeshBackground* meshes = medium_->meshes();
    if (!meshes) return {};
    const AdaptiveAaParams& params = meshes->params();
    const double n = params.m * params.m;
    const std::optional<Image> counts = sample_counts();
    if (!counts) {
        const bool counted = params.method == AaMethod::uniform || params.method == AaMethod::ssaa;
        return 100.0 * (counted ? params.k : 1) / n;
    }
    double sum = 0;
    for (const float k : counts->plane(0)) sum += k;
    return 100.0 * sum / (n * static_cast<double>(counts->pixels()));
}

} // namespace ockham
