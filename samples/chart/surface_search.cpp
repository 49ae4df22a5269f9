// SPDX-License-Identifier: Apache-2.0
#include "samples/chart/surface_search.hpp"

#include "framework/runtime/executor.hpp"
#include "passes/volume/frame.hpp"
#include "passes/volume/majorants.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace ockham::chart {
namespace {

constexpr double kStepVoxels = 1.0 / 16;

/// The part of a ray inside the box, in unit coordinates; `length` in voxels, 0 where it misses.
struct Way {
    glm::dvec3 begin{0.0}, all{0.0};
    double length = 0;
};

Way way_of(const Volume& volume, const Camera& camera, double x, double y) {
    const VolumePlace place = place_of(volume);
    const glm::dmat3 unit_of_world = glm::inverse(place.edges);
    const double high = std::tan(0.5 * glm::radians(double{camera.fov_y_degrees}));
    const glm::dvec3 forward(camera.forward), up(camera.up);
    const glm::dvec3 right = glm::normalize(glm::cross(forward, up));
    const glm::dvec3 direction =
        unit_of_world * (forward + high * (x * right + y * glm::cross(right, forward)));
    const glm::dvec3 origin = unit_of_world * (glm::dvec3(camera.position) - place.corner);
    double near = 0, far = 1e9;
    for (int axis = 0; axis < 3; ++axis) {
        const double a = -origin[axis] / direction[axis], b = (1 - origin[axis]) / direction[axis];
        near = std::max(near, std::min(a, b));
        far = std::min(far, std::max(a, b));
    }
    if (!(near < far)) return {};
    const glm::dvec3 all = (far - near) * direction;
    return {origin + near * direction, all, glm::length(all * glm::dvec3(volume.dims))};
}

Way way_of_pixel(const Volume& volume, const Camera& camera, std::uint32_t side, std::size_t i) {
    const auto column = static_cast<double>(i % side), row = static_cast<double>(i / side);
    return way_of(volume, camera, 2 * (column + 0.5) / side - 1, 1 - 2 * (row + 0.5) / side);
}

double first_crossing(const Volume& volume, double isovalue, const Way& way) {
    const auto above = [&](double t) { return volume.sample(way.begin + t * way.all) >= isovalue; };
    const int steps = static_cast<int>(std::ceil(way.length / kStepVoxels));
    for (int i = 0; i <= steps; ++i) {
        double high = double(i) / std::max(steps, 1);
        if (!above(high)) continue;
        if (i == 0) return 0;
        double low = double(i - 1) / steps;
        for (int halving = 0; halving < 40; ++halving)
            (above(0.5 * (low + high)) ? high : low) = 0.5 * (low + high);
        return high;
    }
    return -1;
}

} // namespace

std::vector<double> surface_truth(
    const Volume& volume, double isovalue, const Camera& camera, std::uint32_t side) {
    std::vector<double> truth(std::size_t{side} * side, -1.0);
    for (std::size_t i = 0; i < truth.size(); ++i) {
        const Way way = way_of_pixel(volume, camera, side, i);
        if (way.length > 0) truth[i] = first_crossing(volume, isovalue, way);
    }
    return truth;
}

/// The pass alone, ready to be executed.
struct SurfaceSearchRun::Searcher {
    Searcher(SurfaceSearchRun& run, const SurfaceDepthParams& params)
        : frame(run.device_, gpu::BufferInfo{.bytes = sizeof(shader::VolumeFrame),
                                 .usage = VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT,
                                 .name = "frame",
                                 .memory = gpu::MemoryUse::upload}) {
        const shader::VolumeFrame numbers = make_volume_frame(place_of(run.source_.volume),
            run.gpu_, run.camera_, params.width, params.height, run.source_.view);
        std::memcpy(frame.mapped().data(), &numbers, sizeof(numbers));
        Graph graph("surface_search");
        MediumInputs medium{.facts = run.gpu_.facts(),
            .handles = run.gpu_.import(graph),
            .frame = graph.import_buffer("frame", {sizeof(shader::VolumeFrame)}, {}),
            .ranges = {},
            .majorants = {},
            .surfaces = true};
        changed = graph.add_condition("new volume");
        restart = graph.add_condition("begin anew");
        medium.ranges = add_majorants(
            graph, medium.facts, medium.handles, medium.frame, true, {changed, changed})
                            .ranges;
        out = add_surface_depth(graph, medium, params, restart);
        graph.export_resource(out.depth, "the picture");
        executor = std::make_unique<Executor>(run.device_, std::move(graph));
        run.gpu_.bind(*executor, medium.handles);
        executor->bind(medium.frame, frame);
        executor->set(changed, true);
        execute(true);
    }
    double execute(bool anew) {
        executor->set(restart, anew);
        executor->execute();
        executor->set(changed, false);
        return 1e3 * gpu_seconds(*executor);
    }

    gpu::Buffer frame;
    Condition changed, restart;
    SurfaceDepth out;
    std::unique_ptr<Executor> executor;
};

SurfaceSearchRun::SurfaceSearchRun(gpu::Device& device, const VolumeScene& scene,
    SurfaceSearch search, std::uint32_t side, std::uint32_t most)
    : device_(device), source_(scene.load()), camera_(scene.view()), search_(search), side_(side),
      most_(most), gpu_(device, source_.volume, source_.transfer, {}) {
    truth_ = surface_truth(source_.volume, source_.view.surfaces.front().value, camera_, side_);
    for (std::size_t i = 0; i < truth_.size(); ++i)
        voxels_.push_back(way_of_pixel(source_.volume, camera_, side_, i).length);
    const bool march = search == SurfaceSearch::march;
    for (std::uint32_t lookups = march ? 16 : 1; lookups <= (march ? most_ : 1); lookups *= 2)
        searchers_.push_back(searcher(lookups));
}

SurfaceSearchRun::~SurfaceSearchRun() = default;

std::unique_ptr<SurfaceSearchRun::Searcher> SurfaceSearchRun::searcher(std::uint32_t lookups) {
    SurfaceDepthParams params{.width = side_, .height = side_, .search = search_};
    if (search_ == SurfaceSearch::march) params.steps = lookups;
    return std::make_unique<Searcher>(*this, params);
}

Row SurfaceSearchRun::judge(Searcher& searcher, std::uint32_t lookups, double milliseconds) const {
    const Image found = searcher.executor->read(searcher.out.depth);
    double wrong = 0, right = 0, square = 0;
    for (std::size_t i = 0; i < truth_.size(); ++i) {
        const bool hit = found.plane(1)[i] > 0;
        const double off = (double{found.plane(0)[i]} - truth_[i]) * voxels_[i];
        if (hit != (truth_[i] >= 0) || (hit && std::abs(off) > 1)) {
            ++wrong;
        } else if (hit) {
            ++right;
            square += off * off;
        }
    }
    return {.knob = static_cast<double>(lookups),
        .values = {{"lookups", static_cast<double>(lookups)}, {"gpu_ms", milliseconds},
            {"wrong_percent", 100 * wrong / static_cast<double>(truth_.size())},
            {"error_voxels", right > 0 ? std::sqrt(square / right) : 0.0}}};
}

std::vector<Row> SurfaceSearchRun::measure() {
    std::vector<Row> rows;
    if (search_ == SurfaceSearch::stochastic) {
        Searcher& all = *searchers_.front();
        double milliseconds = all.execute(true);
        for (std::uint32_t tried = 1, next = 1; next <= most_; next *= 2) {
            for (; tried < next && !interrupted(); ++tried) milliseconds += all.execute(false);
            rows.push_back(judge(all, next, milliseconds));
        }
        return rows;
    }
    std::uint32_t lookups = search_ == SurfaceSearch::march ? 16 : 1;
    for (const auto& one : searchers_) {
        const double milliseconds = one->execute(true);
        rows.push_back(judge(*one, lookups, milliseconds));
        lookups *= 2;
    }
    return rows;
}

} // namespace ockham::chart
