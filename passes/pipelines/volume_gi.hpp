// SPDX-License-Identifier: Apache-2.0
// The whole picture of a volume with global illumination, as one graph per mode:
//   path, noncaching   ranges -> majorants -> path_trace -> mean
//   caching            ranges -> majorants -> cache -> path_trace (final gather) -> mean
//                                                   or compose
// A step adds samples, and an execution is one or several. What changes in between makes those
// things begin anew that depend on it, and no others. Called by samples.
#pragma once

#include "framework/scene/camera.hpp"
#include "framework/scene/volume_view.hpp"
#include "framework/scene_gpu/volume_gpu.hpp"
#include "passes/pipelines/mesh_background.hpp"
#include "passes/volume/cache.hpp"
#include "passes/volume/compose.hpp"
#include "passes/volume/path_trace.hpp"
#include "passes/volume/surface_depth.hpp"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace ockham {

enum class VolumeMode : std::uint8_t {
    path,       ///< full transport, surfaces scatter: the reference
    noncaching, ///< path traced medium, surfaces shaded locally
    caching,    ///< as noncaching, with in-scattered light out of a cache that is kept
};
const char* name_of(VolumeMode mode);

struct VolumeGiParams {
    std::uint32_t width = 1024, height = 768; ///< pixels
    /// The picture is a part of one of that size; 0: of none. It has other random numbers, and
    /// meshes have texture gradients of other 2 x 2 samples where it begins at odd ones.
    glm::uvec2 part_of{0};
    VolumeMode mode = VolumeMode::path;
    std::uint32_t samples_per_step = 1;         ///< per pixel
    bool sobol = true;                          ///< else independent samples
    bool majorant_grid = true;                  ///< else one majorant for all
    bool nee = true;                            ///< light is sampled at collisions
    std::uint32_t iterations = kPathIterations; ///< loop budget of path tracing, >= 1

    // Mode caching.
    bool gather = true; ///< one exact collision, then the cache; false: composition
    std::uint32_t cache_scale = 2;
    CacheFormat cache_format = CacheFormat::fp16;
    bool iso_occlusion = true; ///< surfaces keep light out of the cache
    bool keep_on_iso = false;  ///< isovalues will change: cells keep their memory, and old values
                               ///< until new ones are there (CacheParams::hold_solid)
    float cache_error = 0.02f; ///< relative standard error at which the cache is done
    SurfaceSearch search = SurfaceSearch::exact; ///< other than exact: composition only

    std::vector<std::string> captures; ///< names of further images to export
    std::optional<VolumePlace> place;  ///< empty: place_of() the volume
    std::string no_meshes; ///< where there could be meshes, why there are none: for explain
};

/// Which mode suits `pictures` views of a volume, and why: path for one, caching where several can
/// share a cache that certainly fits `budget_bytes` (0: no limit).
struct ModeChoice {
    VolumeMode mode;
    std::string why;
};
ModeChoice choose_mode(const Volume& volume, std::uint64_t pictures, std::uint32_t cache_scale,
    std::uint64_t budget_bytes);

/// Of what has been done since the picture began anew, and for the cache since that did.
struct VolumeStatistics {
    std::uint64_t paths = 0;          ///< that have ended, of pixels and of cells
    std::uint64_t steps = 0;          ///< tentative collisions: lookups of the field
    std::uint64_t resumed = 0;        ///< paths stored to go on in a later execution
    std::uint64_t truncated = 0;      ///< paths dropped or wrongly bounded: must be 0
    std::uint64_t cells = 0;          ///< of the cache, that hold memory
    std::uint64_t cell_bytes = 0;     ///< of all that the cache takes
    std::uint64_t majorant_cells = 0; ///< 1: one majorant for all
    /// Of a pixel's mean luminance, mean over the picture; and its root over the picture's mean.
    /// Nothing where the picture is composed: its error is the cache's.
    std::optional<double> mean_variance, relative_error;
    bool cache_converged = false; ///< the cache has reached its error, and is suspended
};

/// A volume on the device, its graph and its executor. `device` must outlive it.
class VolumeGi {
public:
    /// `environment`: see VolumeGpu. Throws Error(input) for parameters and views out of range,
    /// Error(device) for want of memory. `meshes`: stand in the medium, and are seen through it;
    /// the light of both must be the same (surface_volume.hpp), the environment one colour.
    VolumeGi(gpu::Device& device, const Volume& volume, const TransferFunction& transfer,
        const Image& environment, const VolumeView& view, const Camera& camera,
        const VolumeGiParams& params, std::unique_ptr<MeshBackground> meshes = nullptr);

    /// So many steps. Several at once give the same picture, bit for bit, in less time: paths that
    /// run beside each other differ in length, and wait for the longest once instead of in each
    /// step. More than one only where steps_together().
    void execute(std::uint32_t steps = 1);
    /// False: steps refine a cache in between.
    bool steps_together() const { return !caching(); }
    /// Steps leave paths and rays unfinished where a budget of iterations ended; a picture without
    /// them is darker or brighter than it should be. finished() says whether there are none;
    /// drain() is an execution that only goes on with them; finish() does so until there are none.
    bool finished();
    void drain();
    void finish();

    /// What is shown from now on. The picture begins anew; the cache only where its light or its
    /// medium changes, so not for a camera, materials or gains.
    void set_camera(const Camera& camera);
    /// Where the part lies whose size is the picture's; zero at first. With part_of only.
    void set_origin(glm::uvec2 origin);
    void set_view(const VolumeView& view);
    void set_transfer(const TransferFunction& transfer);
    /// Another size in pixels, gather on or off: as if made so, but for the cache, which stays.
    void set_picture(std::uint32_t width, std::uint32_t height, bool gather);
    /// False: the cache rests until something else than the camera changes, so that steps are
    /// short.
    void set_refining(bool refining) { refining_ = refining; }

    /// R, G, B (linear radiance) and A: means over all samples.
    Image picture() { return executor_->read(radiance_); }
    /// The first step makes the whole picture, and later ones have nothing to add: no density, and
    /// all isosurfaces are samples of the meshes' G-buffer.
    bool at_rest() const;
    /// Since the picture began anew.
    std::uint64_t steps() const { return pending_.picture ? 0 : progress_.steps; }
    VolumeStatistics statistics();

    /// All that later steps depend on, after at least one. restore() into one that was made with
    /// equal arguments goes on bit for bit; Error(input) where it was saved by another.
    std::vector<SavedResource> save();
    void restore(std::vector<SavedResource> saved);

    const VolumeGpu& gpu() const { return gpu_; }
    Executor& executor() { return *executor_; }
    const std::vector<ImageHandle>& captures() const { return captures_; }
    const MeshBackground* meshes() const { return meshes_.get(); } ///< null: there are none

private:
    /// What has changed since the last execution.
    struct Pending {
        bool volume = true, transfer = true, picture = true;
        CacheChange cache = CacheChange::medium;
    };
    /// Of the picture; saved with it.
    struct Progress {
        std::uint64_t steps = 0;
        /// Of paths whose samples have left the mean since: see execute().
        std::uint64_t paths = 0, events = 0, resumed = 0, truncated = 0;
        std::uint64_t settled = 0; ///< 1: all samples are of the cache as it will stay
    };
    bool caching() const { return params_.mode == VolumeMode::caching && !at_rest(); }
    bool traces() const { return (!caching() || params_.gather) && !at_rest(); }
    CacheParams cache_params() const;
    void refuse_search(const VolumeView& view) const;
    Graph declare();
    void declare_majorants(Graph& graph);
    void declare_light(Graph& graph);
    void declare_cache(Graph& graph);
    void declare_picture(Graph& graph);
    void declare_captures(Graph& graph);
    void declare_anew();
    void bind();
    /// Writes the frame of these and keeps them, or throws and keeps the old.
    void show(const VolumeView& view, const Camera& camera);
    shader::CacheControl cache_control();
    void add_pixel_error(VolumeStatistics& out);

    gpu::Device& device_;
    VolumePlace place_;
    VolumeGpu gpu_;
    VolumeView view_;
    Camera camera_;
    VolumeGiParams params_;
    glm::uvec2 origin_{0}; ///< of the part
    std::unique_ptr<MeshBackground> meshes_;

    gpu::Buffer frame_;
    CacheSize cache_size_;
    MediumInputs medium_;
    std::optional<Cache> cache_;
    PathTrace paths_;
    std::optional<Composed> composed_;
    ImageHandle radiance_; ///< the picture
    std::vector<ImageHandle> captures_;
    Condition new_volume_, new_transfer_, new_view_, restart_, drain_, refine_;
    std::unique_ptr<Executor> executor_;
    Pending pending_;
    Progress progress_;
    bool suspended_ = false; ///< the cache was, after the last execution
    bool refining_ = true;
};

} // namespace ockham
