// SPDX-License-Identifier: Apache-2.0
// Meshes and a medium in one picture and one graph:
//   ranges -> majorants -> [gbuffer -> first_sample -> ... -> resolve, keep, mesh_distance] ->
//   [cache] -> path_trace or compose -> over_meshes             [once for each view]
// What is not there costs nothing: without a medium this is the graph of adaptive_aa.hpp, without
// meshes that of volume_gi.hpp, and the pictures are theirs bit for bit. Called by samples.
#pragma once

#include "passes/pipelines/adaptive_aa.hpp"
#include "passes/pipelines/volume_gi.hpp"

#include <memory>
#include <optional>
#include <vector>

namespace ockham {

/// Where a volume lies in a world of meshes, whose up is +y: first it is put upright, its +z to +y,
/// then scaled about its centre, turned about x, then y, then z, and moved.
struct VolumePlacement {
    glm::vec3 translation{0.0f};
    glm::vec3 rotation_degrees{0.0f};
    float scale = 1; ///< > 0: world units of the longest side
};
VolumePlace placed(const VolumePlace& place, const VolumePlacement& placement);

/// The scene's first directional light, and `environment` from everywhere else.
VolumeView lit_by(const Scene& scene, VolumeView view, const glm::vec3& environment);

/// Nothing of it is seen anywhere, for lack of opacity or density; isosurfaces are something.
bool is_transparent(const Volume& volume, const TransferFunction& transfer, const VolumeView& view);

/// A volume, what it looks like and where it is. All must outlive the constructor's call alone.
struct MediumSource {
    const Volume& volume;
    const TransferFunction& transfer;
    const Image& environment; ///< with meshes: empty
    VolumeView view;
    VolumePlacement placement; ///< used with meshes; without them, the world is the volume's own
};

struct SurfaceVolumeParams {
    AdaptiveAaParams surfaces; ///< of meshes; width, height and part_of are those of `medium`
    VolumeGiParams medium;
};

class SurfaceVolume {
public:
    /// `lit` may be null, and `medium` absent, but not both. A scene without triangles counts as
    /// none where there is a medium, and a medium that is_transparent() as none where there are
    /// meshes. `device` and `lit` must outlive this object. Throws as AdaptiveAa, MeshBackground
    /// and VolumeGi do.
    SurfaceVolume(gpu::Device& device, const LitScene* lit,
        const std::optional<MediumSource>& medium, const Camera& camera,
        const SurfaceVolumeParams& params);

    /// One step: more samples of the medium, or, where all_at_once(), the whole picture.
    void execute();
    /// There is no medium, or its steps have nothing to add.
    bool all_at_once() const { return !medium_ || medium_->at_rest(); }
    /// False: the medium has paths under way, which drain() goes on with. finish() until it has
    /// none.
    bool finished() { return !medium_ || medium_->finished(); }
    void drain() { medium_->drain(); }
    void finish();
    void set_camera(const Camera& camera);
    /// Where the part lies whose size is the picture's; zero at first. With part_of only.
    void set_origin(glm::uvec2 origin);

    Image picture() { return medium_ ? medium_->picture() : surfaces_->picture(); }
    const std::vector<PassTime>& times() const;
    Executor& executor() { return medium_ ? medium_->executor() : surfaces_->executor(); }
    const std::vector<ImageHandle>& captures() const;

    /// Null without a medium; with one it holds the meshes as well.
    VolumeGi* medium() { return medium_.get(); }
    /// Null with a medium.
    AdaptiveAa* surfaces() { return surfaces_.get(); }
    /// k of every pixel, with AdaptiveAaParams::export_counts; nothing where all have as many.
    std::optional<Image> sample_counts();
    /// Percent of all samples of the G-buffer that were shaded; nothing without meshes.
    std::optional<double> sample_percent();

private:
    std::unique_ptr<AdaptiveAa> surfaces_; ///< either this
    std::unique_ptr<VolumeGi> medium_;     ///< or that
};

} // namespace ockham
