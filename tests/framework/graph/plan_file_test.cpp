// SPDX-License-Identifier: Apache-2.0
// Declarations survive a file unchanged, and no file, however made, brings the program down.
#include "framework/core/error.hpp"
#include "framework/graph/explain/plan_file.hpp"
#include "tests/framework/graph/plan_lines.hpp"
#include "tests/framework/graph/random_graph.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace ockham {
namespace {

using nlohmann::json;

/// One of everything that a declaration can hold.
Declaration everything() {
    Graph graph("everything \"<&>\" \xc3\xa4");
    const ImageDesc pyramid_desc{VK_FORMAT_R16G16B16A16_SFLOAT, 64, 32, 1, 6, 5};
    ImageHandle pyramid = graph.create_image("pyramid", pyramid_desc);
    ImageHandle color = graph.create_image("color", kColor), z = graph.create_image("z", kDepth);
    BufferHandle scratch = graph.create_buffer("scratch", {std::uint64_t{1} << 32});
    BufferHandle counts = graph.create_persistent_buffer("counts", {1024});
    History<ImageHandle> history = graph.create_history_image("history", kColor, 2);
    AccessState entry = state_of(Access::transfer_write, Stage::fixed), exit = entry;
    exit.queue_family = 3;
    const ImageHandle picture = graph.import_image("picture", kColor, entry, exit);
    const Condition fog = graph.add_condition("fog"), debug = graph.add_condition("debug");

    auto draw = graph.add_raster_pass("draw");
    color = draw.color(color, LoadOp::clear, {1.5f, -0.25f, 1e-30f, INFINITY});
    z = draw.depth(z, 0.1f);
    draw.because("there is something to see");
    {
        const GuardScope outer = graph.when(fog);
        const GuardScope inner = graph.unless(debug);
        auto march = graph.add_compute_pass("march");
        march.sample("source", picture, Stage::compute, Filter::linear_repeat);
        march.sample("past", history.previous[1]);
        history.now = march.write("now", history.now);
        march.prefer(QueueWish::async_compute);
    }
    auto down = graph.add_compute_pass("down");
    down.sample("color", color);
    pyramid = down.write("mip", pyramid.mips(1, 2).layer(5));
    counts = down.read_write("counts", counts.range(256, 512));
    auto copy = graph.add_transfer_pass("copy");
    scratch = copy.copy_to(scratch.range(512, kRest));
    copy.side_effect("told to").prefer(QueueWish::transfer);
    graph.export_resource(counts, "shown");
    graph.omit_pass("shadows", "no light casts any");
    graph.omit_resource("shadow_map", "no light casts any");
    Declaration declaration = graph.declaration();
    declaration.resources[0].memory = {123456, 65536, 0x7};
    return declaration;
}

/// Through text, as a file is.
json reparsed(const json& value) { return json::parse(value.dump()); }

TEST(PlanFile, KeepsEverything) {
    const Declaration before = everything();
    const json saved = declaration_json(before);
    const Declaration after = load_declaration(reparsed(saved));
    json again = declaration_json(after);
    json expected = saved;
    for (json* one : {&expected, &again}) // lines of source are not read again
        for (const char* list : {"conditions", "resources", "passes"})
            for (json& entry : (*one)[list]) entry.erase("where");
    EXPECT_EQ(again.dump(1), expected.dump(1));

    // What the JSON itself might have forgotten, by the fields.
    ASSERT_EQ(after.uses.size(), before.uses.size());
    for (std::size_t i = 0; i < before.uses.size(); ++i) {
        const Use &a = before.uses[i], &b = after.uses[i];
        EXPECT_EQ(std::tie(a.resource, a.access, a.stage, a.load, a.filter, a.version,
                      a.version_written, a.part),
            std::tie(b.resource, b.access, b.stage, b.load, b.filter, b.version, b.version_written,
                b.part))
            << i;
        EXPECT_EQ(before.binding_of(a), after.binding_of(b));
        EXPECT_EQ(before.clears[i], after.clears[i]);
    }
    EXPECT_EQ(before.parts, after.parts);
    EXPECT_EQ(before.guards, after.guards);
    ASSERT_EQ(after.passes.size(), before.passes.size());
    for (std::size_t i = 0; i < before.passes.size(); ++i) {
        const PassDecl &a = before.passes[i], &b = after.passes[i];
        EXPECT_EQ(std::tie(a.name, a.kind, a.queue, a.guard, a.first_use, a.use_count, a.reason,
                      a.side_effect),
            std::tie(b.name, b.kind, b.queue, b.guard, b.first_use, b.use_count, b.reason,
                b.side_effect));
    }
    ASSERT_EQ(after.resources.size(), before.resources.size());
    for (std::size_t i = 0; i < before.resources.size(); ++i) {
        const ResourceDecl &a = before.resources[i], &b = after.resources[i];
        EXPECT_EQ(std::tie(a.name, a.kind, a.lifetime, a.buffer, a.image, a.memory.bytes,
                      a.memory.alignment, a.memory.type_bits, a.exported, a.export_reason, a.entry,
                      a.exit, a.history_depth, a.history_age),
            std::tie(b.name, b.kind, b.lifetime, b.buffer, b.image, b.memory.bytes,
                b.memory.alignment, b.memory.type_bits, b.exported, b.export_reason, b.entry,
                b.exit, b.history_depth, b.history_age));
    }
}

TEST(PlanFile, PlansTheSameAgain) {
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
        RandomGraph random(seed);
        const Declaration& declaration = random.graph().declaration();
        const Capabilities capabilities{
            .families = {{}, {false, true, true, 2}}, .buffer_image_granularity = 1024};
        const Policy policy{.order = Order::batched,
            .batch_memory = std::numeric_limits<double>::infinity(),
            .alias_memory = seed % 2 == 0};
        const Plan plan = compile(declaration, capabilities, policy);
        const PlanFile file =
            load_plan_file(reparsed(plan_json(declaration, plan, capabilities, policy)));
        EXPECT_EQ(file.policy.batch_memory, policy.batch_memory);
        EXPECT_TRUE(compile(file.declaration, file.capabilities, file.policy) == plan) << seed;
    }
}

std::string error_of(const json& file) {
    try {
        load_plan_file(file);
        return "";
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::input);
        return error.what();
    }
}

/// The error after one value of a good file was replaced, or removed where `value` is null.
std::string error_with(const char* pointer, const json& value) {
    const Declaration declaration = everything();
    json file{{"declaration", declaration_json(declaration)}, {"policy", to_json(Policy{})},
        {"capabilities", to_json(Capabilities{.families = {{}}})}};
    EXPECT_EQ(error_of(file), "");
    const json::json_pointer place(pointer);
    if (value.is_null())
        file[place.parent_pointer()].erase(place.back());
    else
        file[place] = value;
    return error_of(file);
}

TEST(PlanFile, ErrorsNameThePlace) {
    const auto expect = [](const char* place, const json& value, const char* text) {
        EXPECT_EQ(error_with(place, value), fmt::format("[bad-plan-file] {}", text)) << place;
    };
    expect("/declaration", nullptr, "the whole: has no 'declaration'");
    expect("/declaration/version", 2,
        "/declaration/version: found 2, expected an integer from 1 to 1");
    expect("/declaration/passes", "no", "/declaration/passes: found string, expected an array");
    expect("/declaration/passes/0/name", 3,
        "/declaration/passes/0/name: found number, expected a string");
    expect("/declaration/passes/0/kind", "magic",
        "/declaration/passes/0/kind: found 'magic', expected one of compute, raster, transfer");
    expect("/declaration/passes/0/uses/0/resource", 99,
        "/declaration/passes/0/uses/0/resource: found 99, expected an integer from 0 to 8");
    expect("/declaration/passes/0/uses/0/resource", -1,
        "/declaration/passes/0/uses/0/resource: found -1, expected an integer from 0 to 8");
    expect("/declaration/passes/0/uses/0/version", 1,
        "/declaration/passes/0/uses/0/version: found 1, expected an integer from 0 to 0");
    expect("/declaration/passes/0/uses/0/version_written", nullptr,
        "/declaration/passes/0/uses/0: has no 'version_written'");
    expect("/declaration/passes/1/uses/0/version_written", 1,
        "/declaration/passes/1/uses/0/version_written: sampled writes nothing");
    expect("/declaration/passes/1/guard", 2,
        "/declaration/passes/1/guard: found 2, expected an integer from 0 to 1");
    expect("/declaration/guards/0/parent", 0,
        "/declaration/guards/0/parent: found 0, but there is nothing to refer to");
    expect("/declaration/passes/2/uses/1/part/first_mip", 5,
        "/declaration/passes/2/uses/1/part/first_mip: found 5, expected an integer from 0 to 4");
    expect("/declaration/passes/2/uses/1/part/mips", 5,
        "/declaration/passes/2/uses/1/part/mips: found 5, expected an integer from 1 to 4");
    expect("/declaration/passes/0/uses/0/clear", json::array({1, 2}),
        "/declaration/passes/0/uses/0/clear: found 2 numbers, expected 4");
    expect("/declaration/resources/6/history/age", 2,
        "/declaration/resources/6: age 2 of a history follows on age 1 of the same size and "
        "depth, found 'history'");
    expect("/declaration/resources/5/lifetime", "transient",
        "/declaration/resources/5: only persistent resources have a history");
    expect("/capabilities/families/0/graphics", false,
        "/capabilities/families: none has both graphics and compute");
    expect("/policy/batch_memory", "nan", "/policy/batch_memory: expected 0 or more");
}

/// Every value of a file replaced by nonsense, one at a time: refused, or planned; never a crash.
TEST(PlanFile, NonsenseIsRefusedOrPlanned) {
    const json good{{"declaration", declaration_json(everything())}};
    const json nonsense[] = {nullptr, true, 0, 1, 7, 4294967295u, -1, 1.5, "", "load", "inf",
        json::array(), json::object(), std::numeric_limits<std::uint64_t>::max()};
    std::size_t refused = 0, planned = 0;
    const json values = good.flatten(); // by JSON pointer
    for (const auto& [place, value] : values.items())
        for (const json& other : nonsense) {
            json file = good;
            file[json::json_pointer(place)] = other;
            try {
                const PlanFile loaded = load_plan_file(file);
                compile(loaded.declaration, loaded.capabilities, loaded.policy);
                ++planned;
            } catch (const Error&) {
                ++refused;
            }
        }
    EXPECT_GT(refused, 1000u);
    EXPECT_GT(planned, 100u); // names, reasons, equal values
}

} // namespace
} // namespace ockham
