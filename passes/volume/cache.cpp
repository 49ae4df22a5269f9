// SPDX-License-Identifier: Apache-2.0
#include "passes/volume/cache.hpp"

#include "framework/core/error.hpp"
#include "framework/runtime/commands.hpp"
#include "passes/schedule/buckets.hpp"
#include "passes/shader_variant.hpp"
#include "shaders/schedule/buckets.h"

#include <algorithm>
#include <bit>
#include <cstring>

namespace ockham {
namespace {

constexpr std::uint32_t kGroup = 64; ///< invocations of every kernel but the scan
constexpr std::uint32_t kMostGroups = 65535;

/// Workgroups for `items` invocations, over two axes where one is too short.
glm::uvec3 groups_of(std::uint64_t items) {
    const std::uint64_t groups = (items + kGroup - 1) / kGroup;
    const std::uint64_t rows = std::max<std::uint64_t>(1, (groups + kMostGroups - 1) / kMostGroups);
    return {static_cast<std::uint32_t>((groups + rows - 1) / rows),
        static_cast<std::uint32_t>(rows), 1};
}

void validate(const CacheParams& params) {
    if (params.scale != 1 && params.scale != 2 && params.scale != 4)
        fail_input("cache: scale {}: a cell is 1, 2 or 4 voxels wide", params.scale);
    if (params.paths < 8 || !std::has_single_bit(params.paths))
        fail_input(
            "cache: {} paths per execution: expected a power of two, at least 8", params.paths);
    if (!(params.target_error >= 0))
        fail_input("cache: target error {}: expected 0 or more", params.target_error);
    if (params.working_set < kGroup)
        fail_input(
            "cache: working set of {} cells: expected at least {}", params.working_set, kGroup);
    check(params.iterations >= 1 && params.places >= 1,
        "a loop budget, and a place to store what it interrupts");
}

std::uint64_t cell_count(glm::uvec3 dims, std::uint32_t scale) {
    const glm::uvec3 grid = (dims + glm::uvec3(scale - 1)) / glm::uvec3(scale);
    return std::uint64_t{grid.x} * grid.y * grid.z;
}
std::uint64_t run_bytes(std::uint64_t cells) {
    return (cells + CACHE_RUN - 1) / CACHE_RUN * sizeof(glm::uvec2);
}
std::uint64_t index_bytes(std::uint64_t cells) { return sizeof(shader::CacheHeader) + 4 * cells; }

std::uint64_t bytes_of_cell(const CacheParams& params) {
    const std::uint64_t words = params.format == CacheFormat::fp32   ? 3
                                : params.format == CacheFormat::fp16 ? 2
                                                                     : 1;
    return 4 * (words + (params.directional ? 2 : 0));
}

/// Slots of the working set: no more than there are.
std::uint32_t set_of(const CacheParams& params) {
    return std::min(params.working_set, std::max(params.capacity, kGroup));
}

std::uint32_t places_of(const CacheParams& params) {
    return std::min(params.places, set_of(params));
}

shader::CachePush push_of(const MediumInputs& medium, const CacheParams& params) {
    return {.scale = params.scale,
        .format = static_cast<std::uint32_t>(params.format),
        .directional = params.directional,
        .set = set_of(params),
        .places = places_of(params),
        .capacity = params.capacity,
        .occlusion = params.occlusion && medium.surfaces,
        .hold_solid = params.hold_solid,
        .paths = params.paths,
        .bucket = 0,
        .cells = static_cast<std::uint32_t>(cell_count(medium.facts.dims, params.scale)),
        .iterations = params.iterations,
        .target = params.target_error};
}

void dispatch(
    PassBuilder& pass, std::string shader, const shader::CachePush& push, std::uint64_t items) {
    pass.record([shader = std::move(shader), push, groups = groups_of(items)](Commands& commands) {
        commands.dispatch({.shader = shader, .push = as_push(push)}, groups);
    });
}

/// For kernels that look at the field and its opacity alone.
void read_field(PassBuilder& pass, MediumInputs medium) {
    medium.facts.emission = false;
    read_medium(pass, medium, {.tracking = false, .light = false, .surfaces = false});
}

/// Of the pieces between voxel centres, a bit each.
std::uint64_t piece_words(glm::uvec3 dims) {
    const glm::uvec3 pieces = dims + glm::uvec3(1);
    return std::uint64_t{(pieces.x + 31) / 32} * pieces.y * pieces.z;
}

/// Marks and counts the cells that need slots. The header of the index has the numbers.
struct Marked {
    BufferHandle index, runs;
};
Marked add_marks(
    Graph& graph, const MediumInputs& medium, const shader::CachePush& push, BufferHandle index) {
    const std::uint64_t words = piece_words(medium.facts.dims);
    const std::uint64_t runs = (push.cells + CACHE_RUN - 1) / CACHE_RUN;
    Marked out{index, graph.create_buffer("cache_runs", {run_bytes(push.cells)})};
    BufferHandle bits = graph.create_buffer("cache_pieces", {words * sizeof(shader::CachePieces)});

    PassBuilder classify = graph.add_compute_pass("cache_classify");
    classify.because("where the field can be seen, and where surfaces are");
    read_field(classify, medium);
    const bool grid = bool(medium.handles.opacity_max);
    if (grid) classify.read("opacity_max", medium.handles.opacity_max);
    bits = classify.write("cache_pieces", bits);
    dispatch(classify, shader_variant("volume/cache_classify.comp", {{"grid", grid}}), push, words);

    PassBuilder mark = graph.add_compute_pass("cache_mark");
    mark.because("only cells that composition may read hold memory");
    read_field(mark, medium);
    mark.read("cache_pieces", bits);
    out.index = mark.write("cache_index", out.index);
    out.runs = mark.write("cache_runs", out.runs);
    dispatch(mark, "volume/cache_mark.comp", push, runs);

    PassBuilder scan = graph.add_compute_pass("cache_scan");
    scan.because("numbers follow from the volume alone: no atomics");
    read_field(scan, medium);
    out.index = scan.read_write("cache_index", out.index);
    out.runs = scan.read_write("cache_runs", out.runs);
    dispatch(scan, "volume/cache_scan.comp", push, 1);
    return out;
}

/// Which cells hold memory, and where.
BufferHandle add_layout(
    Graph& graph, const MediumInputs& medium, const shader::CachePush& push, BufferHandle index) {
    Marked marked = add_marks(graph, medium, push, index);
    PassBuilder scatter = graph.add_compute_pass("cache_scatter");
    scatter.because("gives each marked cell its slot");
    read_field(scatter, medium);
    scatter.read("cache_runs", marked.runs);
    marked.index = scatter.read_write("cache_index", marked.index);
    dispatch(scatter, "volume/cache_scatter.comp", push, (push.cells + CACHE_RUN - 1) / CACHE_RUN);
    return marked.index;
}

/// What is refined: fp32 sums of a bounded number of slots, and interrupted paths.
struct WorkingSet {
    BufferHandle control, sums, paths;
};

void add_enter(Graph& graph, const MediumInputs& medium, const shader::CachePush& push,
    BufferHandle index, BufferHandle cells, WorkingSet& set) {
    PassBuilder pass = graph.add_compute_pass("cache_enter");
    pass.because(
        "a block of cells begins: no more are refined at a time than the working set holds");
    read_field(pass, medium);
    pass.read("cache_index", index)
        .read("cache_cells", cells)
        .read("cache_control", set.control)
        .indirect(set.control);
    set.sums = pass.read_write("cache_sums", set.sums); // kept where no block begins
    set.paths = pass.read_write("cache_paths", set.paths);
    pass.record([push, control = set.control](Commands& commands) {
        commands.dispatch_indirect(
            {.shader = "volume/cache_enter.comp", .push = as_push(push)}, control, 0);
    });
}

ImageHandle add_allocate(
    Graph& graph, const MediumInputs& medium, const shader::CachePush& push, WorkingSet& set) {
    const std::uint32_t rows = (push.set + CACHE_SET_WIDTH - 1) / CACHE_SET_WIDTH;
    ImageHandle counts = graph.create_image(
        "cache_counts", {.format = VK_FORMAT_R8_UINT, .width = CACHE_SET_WIDTH, .height = rows});
    PassBuilder pass = graph.add_compute_pass("cache_allocate");
    pass.because("paths go where variance and contribution are");
    read_field(pass, medium);
    pass.read("cache_control", set.control);
    set.sums = pass.read_write("cache_sums", set.sums);
    counts = pass.write("cache_counts", counts);
    dispatch(pass, "volume/cache_allocate.comp", push, std::uint64_t{rows} * CACHE_SET_WIDTH);
    return counts;
}

void add_trace(Graph& graph, const MediumInputs& medium, const shader::CachePush& push,
    const Buckets& buckets, WorkingSet& set) {
    PassBuilder pass = graph.add_compute_pass("cache_trace");
    pass.because("light that arrives in the cells, a dispatch per number of paths");
    read_medium(pass, medium);
    read_meshes(pass, medium, false);
    read_mesh_tree(pass, medium);
    pass.read("bucket_table", buckets.table)
        .read("pixel_list", buckets.list)
        .indirect(buckets.arguments);
    set.control = pass.read_write("cache_control", set.control);
    set.sums = pass.read_write("cache_sums", set.sums);
    set.paths = pass.read_write("cache_paths", set.paths);
    const std::string kernel =
        mesh_variant(medium_variant("volume/cache_trace.comp", "", medium), medium);
    pass.record([push, kernel, specialization = path_specialization(medium),
                    arguments = buckets.arguments](Commands& commands) {
        // The dearest cells first: what is left over at the end of a dispatch is then cheap.
        shader::CachePush one = push;
        for (one.bucket = CACHE_BUCKETS; one.bucket >= 2; --one.bucket) {
            commands.dispatch_indirect(
                {.shader = kernel, .specialization = specialization, .push = as_push(one)},
                arguments, (one.bucket - 1) * sizeof(shader::DispatchArguments));
        }
    });
}

BufferHandle add_publish(Graph& graph, const MediumInputs& medium, const shader::CachePush& push,
    const WorkingSet& set, BufferHandle cells) {
    PassBuilder pass = graph.add_compute_pass("cache_publish");
    pass.because("readers see means in a compact format");
    read_field(pass, medium);
    pass.read("cache_control", set.control).read("cache_sums", set.sums);
    cells = pass.read_write("cache_cells", cells);
    dispatch(pass, "volume/cache_publish.comp", push, push.set);
    return cells;
}

} // namespace

CacheSize count_cache_cells(gpu::Device& device, const VolumeGpu& volume, const gpu::Buffer& frame,
    const CacheParams& params) {
    validate(params);
    const std::uint64_t limit = device.limits().storage_bytes;
    const std::uint64_t cells = cell_count(volume.facts().dims, params.scale);
    const auto mib = [](std::uint64_t bytes) {
        return static_cast<double>(bytes) / (1024.0 * 1024.0);
    };
    if (index_bytes(cells) > limit) {
        fail_device("cache: the index of {} cells of {}^3 voxels takes {:.1f} MiB, but the device "
                    "binds {:.1f} MiB at a time; use a larger cache scale",
            cells, params.scale, mib(index_bytes(cells)), mib(limit));
    }
    const glm::uvec3 dims = volume.facts().dims;
    const std::uint64_t pieces = piece_words(dims) * sizeof(shader::CachePieces);
    if (pieces > limit) {
        fail_device("cache: marking what can be seen of {} x {} x {} voxels takes {:.1f} MiB, but "
                    "the device binds {:.1f} MiB at a time; scale the volume down, or render it "
                    "without a cache",
            dims.x, dims.y, dims.z, mib(pieces), mib(limit));
    }
    Graph graph("cache_size");
    MediumInputs medium;
    medium.facts = volume.facts();
    medium.handles = volume.import(graph);
    medium.frame = graph.import_buffer("frame", {sizeof(shader::VolumeFrame)}, {});
    medium.surfaces = true; // the frame may have none
    const Marked marked = add_marks(graph, medium, push_of(medium, params),
        graph.create_buffer("cache_index", {index_bytes(cells)}));
    BufferHandle header = graph.create_buffer("cache_header", {sizeof(shader::CacheHeader)});
    PassBuilder copy = graph.add_transfer_pass("cache_header");
    const BufferPart from = marked.index.range(0, sizeof(shader::CacheHeader));
    copy.copy_from(from);
    header = copy.copy_to(header);
    copy.record([from, header](Commands& commands) { commands.copy(from, header); });
    graph.export_resource(header, "how many cells hold memory");

    Executor executor(device, std::move(graph));
    volume.bind(executor, medium.handles);
    executor.bind(medium.frame, frame);
    executor.execute();
    shader::CacheHeader found;
    const std::vector<std::byte> bytes = executor.read(header);
    std::memcpy(&found, bytes.data(), sizeof(found));

    CacheParams sized = params;
    sized.capacity = std::max(found.slots, 1u);
    const std::uint64_t set = set_of(sized);
    const std::uint64_t stored = sized.capacity * bytes_of_cell(params);
    if (stored > limit || found.slots >= CACHE_SLOT_MASK) {
        fail_device("cache: {} of {} cells can be seen and take {:.1f} MiB at {} bytes each, but "
                    "the device binds {:.1f} MiB at a time; use a larger cache scale or a smaller "
                    "cache format",
            found.slots, cells, mib(stored), bytes_of_cell(params), mib(limit));
    }
    if (set * sizeof(shader::CacheSum) > limit) {
        fail_device("cache: a working set of {} cells takes {:.1f} MiB, but the device binds "
                    "{:.1f} MiB at a time; use a smaller one",
            set, mib(set * sizeof(shader::CacheSum)), mib(limit));
    }
    return {.cells = static_cast<std::uint32_t>(cells),
        .slots = found.slots,
        .solid = found.solid,
        .bytes = index_bytes(cells) + stored + set * sizeof(shader::CacheSum) +
                 places_of(sized) * sizeof(shader::CachePath) + pieces + run_bytes(cells)};
}

Cache add_cache(Graph& graph, const MediumInputs& inputs, const CacheParams& params) {
    validate(params);
    MediumInputs medium = inputs;
    medium.surfaces = inputs.surfaces && params.occlusion;
    if (!medium.meshes.sun_map && !medium.meshes.tree) medium.meshes = {}; // paths see no others
    const shader::CachePush push = push_of(medium, params);
    Cache out;
    out.layout = graph.add_condition("cache_layout");
    out.clear = graph.add_condition("cache_clear");
    out.restart = graph.add_condition("cache_restart");
    out.hold_solid = params.hold_solid;
    out.index = graph.create_persistent_buffer("cache_index", {index_bytes(push.cells)});
    out.cells = graph.create_persistent_buffer(
        "cache_cells", {std::max(params.capacity, 1u) * bytes_of_cell(params)});
    WorkingSet set{
        .control = graph.create_persistent_buffer("cache_control", {sizeof(shader::CacheControl)}),
        .sums = graph.create_persistent_buffer("cache_sums", {push.set * sizeof(shader::CacheSum)}),
        .paths = graph.create_persistent_buffer(
            "cache_paths", {push.places * sizeof(shader::CachePath)})};
    {
        const GuardScope guard = graph.when(out.layout);
        out.index = add_layout(graph, medium, push, out.index);
    }
    {
        const GuardScope guard = graph.when(out.clear);
        PassBuilder pass = graph.add_transfer_pass("cache_clear");
        pass.because("what the cells hold is of another light or medium");
        out.cells = pass.copy_to(out.cells);
        pass.record(
            [cells = out.cells](Commands& commands) { commands.fill(cells, CACHE_UNREFINED); });
    }
    {
        const GuardScope guard = graph.when(out.restart);
        PassBuilder pass = graph.add_compute_pass("cache_restart");
        pass.because("every cell is to be refined anew");
        pass.read("cache_index", out.index);
        set.control = pass.write("cache_control", set.control);
        dispatch(pass, "volume/cache_control.comp:restart", push, 1);
    }
    add_enter(graph, medium, push, out.index, out.cells, set);
    out.counts = add_allocate(graph, medium, push, set);
    const ImageDesc map = graph.desc(out.counts);
    const Buckets buckets =
        add_buckets(graph, out.counts, {map.width, map.height, CACHE_BUCKETS, "cache_"});
    add_trace(graph, medium, push, buckets, set);
    out.cells = add_publish(graph, medium, push, set, out.cells);

    PassBuilder control = graph.add_compute_pass("cache_control");
    control.because("goes to the next block once no cell of this one needs paths");
    control.read("bucket_table", buckets.table);
    set.control = control.read_write("cache_control", set.control);
    dispatch(control, "volume/cache_control.comp", push, 1);
    out.control = set.control;
    out.sums = set.sums;
    return out;
}

void set_cache_change(Executor& executor, const Cache& cache, CacheChange change) {
    const bool surface = change == CacheChange::surface, medium = change == CacheChange::medium;
    executor.set(cache.layout, surface || medium);
    executor.set(
        cache.clear, change == CacheChange::light || medium || (surface && !cache.hold_solid));
    executor.set(cache.restart, change != CacheChange::none);
}

} // namespace ockham
