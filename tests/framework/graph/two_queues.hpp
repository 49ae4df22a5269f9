// SPDX-License-Identifier: Apache-2.0
// A small plan for two queues of two families, made by hand: tests of what is shown do not depend
// on what compile() would decide.
#pragma once

#include "framework/graph/compile.hpp"
#include "framework/graph/graph.hpp"
#include "tests/framework/graph/plan_lines.hpp"

#include <utility>

namespace ockham {

/// draw | light on queue 1, which waits for draw | shade | compose, which waits for light. 'color'
/// changes owner; 'lit' is kept, so both families may use it.
inline std::pair<Graph, Plan> two_queues() {
    Graph graph("two queues");
    ImageHandle color = graph.create_image("color", kColor), z = graph.create_image("z", kDepth),
                lit = graph.create_image("lit", kColor);
    auto draw = graph.add_raster_pass("draw");
    color = draw.color(color);
    auto light = graph.add_compute_pass("light");
    light.sample("color", color).prefer(QueueWish::async_compute);
    lit = light.write("lit", lit);
    auto shade = graph.add_raster_pass("shade");
    z = shade.depth(z, 0);
    auto compose = graph.add_compute_pass("compose");
    compose.sample("z", z);
    lit = compose.read_write("lit", lit);
    graph.export_resource(lit, "the picture");

    Plan plan = compile(graph.declaration()); // for the verdicts; the rest is said here
    plan.queues = {{0, 0}, {1, 0}};
    plan.submissions = {{0, 0, 1, 0, 0}, {1, 1, 1, 0, 1}, {0, 2, 1, 1, 0}, {0, 3, 1, 1, 1}};
    plan.waits = {{0, 1}, {1, 1}};
    plan.steps = {{0, 0, 1, 1, 1}, {1, 2, 2, 0, 0}, {2, 4, 1, 0, 0}, {3, 5, 2, 0, 0}};
    plan.heaps = {{~0u, 32768, true}, {~0u, 16384, false}};
    plan.placements = {{color.resource, 0, 0, 16384, 0, 1}, {lit.resource, 1, 0, 16384, 1, 3},
        {z.resource, 0, 16384, 16384, 2, 3}};
    plan.bytes_peak = plan.bytes_lower_bound = 49152;
    plan.concurrent[lit.resource] = 1;
    const auto barrier = [](ResourceId resource, Hazard hazard, PassId from, PassId to,
                             const AccessState& source, const AccessState& target) {
        return Barrier{resource, Part{.bytes = 0, .mips = 1, .layers = 1}, hazard, from, to,
            source.stages, target.stages, source.access, target.access, source.layout,
            target.layout};
    };
    const AccessState none, drawn = state_of(Access::color_attachment, Stage::fixed),
                            deep = state_of(Access::depth_attachment, Stage::fixed),
                            sampled = state_of(Access::sampled, Stage::compute),
                            stored = state_of(Access::storage_write, Stage::compute),
                            changed = state_of(Access::storage_read_write, Stage::compute);
    Barrier given = barrier(color.resource, Hazard::release, 0, 1, drawn, sampled);
    given.dst_stages = given.dst_access = 0;
    Barrier taken = barrier(color.resource, Hazard::acquire, 0, 1, drawn, sampled);
    taken.src_stages = taken.dst_stages;
    taken.src_access = 0;
    for (Barrier* one : {&given, &taken}) {
        one->src_family = 0;
        one->dst_family = 1;
    }
    plan.barriers = {barrier(color.resource, Hazard::first_use, kNone, 0, none, drawn), given,
        taken, barrier(lit.resource, Hazard::first_use, kNone, 1, none, stored),
        barrier(z.resource, Hazard::first_use, kNone, 2, none, deep),
        barrier(z.resource, Hazard::read_after_write, 2, 3, deep, sampled),
        barrier(lit.resource, Hazard::read_after_write, 1, 3, stored, changed)};
    plan.first_exit_barrier = 7;
    plan.exit_barrier_count = 0;
    return {std::move(graph), std::move(plan)};
}

} // namespace ockham
