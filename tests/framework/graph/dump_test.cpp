// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/explain/dump.hpp"
#include "framework/graph/explain/explain.hpp"
#include "tests/framework/graph/plan_lines.hpp"
#include "tests/framework/graph/two_queues.hpp"

#include <gtest/gtest.h>

namespace ockham {
namespace {

Graph example() {
    Graph graph("example");
    ImageHandle color = graph.create_image("color", kColor), z = graph.create_image("z", kDepth);
    BufferHandle result = graph.create_buffer("result", {64}),
                 unread = graph.create_buffer("unread", {64});
    auto draw = graph.add_raster_pass("draw");
    color = draw.color(color, LoadOp::clear);
    z = draw.depth(z, 0);
    draw.because("the scene has 2 meshes");
    auto reduce = graph.add_compute_pass("reduce");
    reduce.sample("color", color);
    result = reduce.write("result", result);
    auto debug = graph.add_compute_pass("debug \"z\"");
    debug.sample("z", z);
    unread = debug.write("unread", unread);
    graph.export_resource(result, "the answer");
    graph.omit_pass("shadows", "no light casts any");
    graph.omit_resource("shadow_map", "no light casts any");
    return graph;
}

TEST(Dump, Text) {
    const Graph graph = example();
    EXPECT_EQ(plan_text(graph.declaration(), compile(graph.declaration())),
        R"(graph 'example': 2 of 3 passes, 4 barriers in 2 batches, 32.2 KiB (lower bound 32.2 KiB, ratio 1.000)

step  pass    kind     barrier           resource  from      src stages    src access         dst stages    dst access              layout
0     draw    raster   first_use         color     (before)  compute       none           ->  color_output  color_read+color_write  undefined -> color
                       first_use         z         (before)  depth_tests   depth_write    ->  depth_tests   depth_read+depth_write  undefined -> depth
1     reduce  compute  read_after_write  color     draw      color_output  color_write    ->  compute       sampled_read            color -> read_only
                       first_use         result    (before)  compute       storage_write  ->  compute       storage_write

resource  kind    lifetime   content           memory    heap     offset  steps
color     image   transient  64x64 R32_SFLOAT  16.0 KiB  0        0       0-1
z         image   transient  64x64 D32_SFLOAT  16.0 KiB  0        16384   0-0
result    buffer  transient  64 B              256 B     1 (own)  0       1-1

pass 'debug "z"': culled: nothing reads 'unread'
buffer 'unread': culled: no live pass uses it
pass 'shadows': omitted: no light casts any
resource 'shadow_map': omitted: no light casts any
)");
}

TEST(Dump, Explain) {
    const Graph graph = example();
    EXPECT_EQ(explain(graph.declaration(), compile(graph.declaration())),
        R"(graph 'example': 2 of 3 passes, 4 barriers in 2 batches, 32.2 KiB (lower bound 32.2 KiB, ratio 1.000)

step 0: 'draw' is kept: 'reduce' reads its 'color'; the scene has 2 meshes
    first_use: 'draw' begins 'color' anew
    first_use: 'draw' begins 'z' anew
step 1: 'reduce' is kept: exported 'result' needs it (the answer)
    after: 'draw' writes 'color' for 'reduce' to read
    read_after_write: 'reduce' reads 'color' as 'draw' left it
    first_use: 'reduce' begins 'result' anew

image 'color', 16.0 KiB: kept: used from 'draw' to 'reduce'
image 'z', 16.0 KiB: kept: used by 'draw'
buffer 'result', 256 B: kept: used by 'reduce'; exported (the answer); memory of its own

memory: most lives in step 0 ('draw'), 32.2 KiB: 'color', 'z' and 'result'
    'color' and 'z' both live in step 0 ('draw')
    'result' is exported: its content is wanted after the execution

pass 'debug "z"': culled: nothing reads 'unread'
buffer 'unread': culled: no live pass uses it
pass 'shadows': omitted: no light casts any
resource 'shadow_map': omitted: no light casts any
)");
}

TEST(Dump, Dot) {
    const Graph graph = example();
    EXPECT_EQ(plan_dot(graph.declaration(), compile(graph.declaration())),
        R"(digraph "example" {
  rankdir=LR;
  p0 [shape=box, label="draw"];
  p1 [shape=box, label="reduce"];
  p2 [shape=box, label="debug \"z\"", style=dashed];
  r0 [shape=ellipse, label="color"];
  r1 [shape=ellipse, label="z"];
  r2 [shape=ellipse, label="result"];
  r3 [shape=ellipse, label="unread", style=dashed];
  p0 -> r0;
  p0 -> r1;
  r0 -> p1;
  p1 -> r2;
  r1 -> p2 [style=dashed];
  p2 -> r3 [style=dashed];
}
)");
}

std::vector<std::string> keys(const nlohmann::json& object) {
    std::vector<std::string> keys;
    for (const auto& [key, value] : object.items()) keys.push_back(key);
    return keys; // sorted, as nlohmann::json stores them
}
using Keys = std::vector<std::string>;

TEST(Dump, JsonKeys) {
    const Graph graph = example();
    const nlohmann::json json = plan_json(graph.declaration(), compile(graph.declaration()));
    EXPECT_EQ(keys(json), (Keys{"barriers", "capabilities", "declaration", "heaps", "memory",
                              "passes", "policy", "queues", "resources", "submissions", "waits"}));
    for (const auto& pass : json["passes"])
        EXPECT_EQ(keys(pass),
            pass["culled"] ? (Keys{"culled", "kind", "name", "reason"})
                           : (Keys{"after", "culled", "kind", "name", "queue", "reason", "step"}));
    EXPECT_EQ(keys(json["resources"][0]),
        (Keys{"bytes", "content", "culled", "first_step", "heap", "kind", "last_step", "lifetime",
            "name", "offset", "reason"}));
    EXPECT_EQ(keys(json["resources"][3]), // culled
        (Keys{"bytes", "content", "culled", "kind", "lifetime", "name", "reason"}));
    EXPECT_EQ(keys(json["resources"][4]), // omitted
        (Keys{"bytes", "culled", "kind", "lifetime", "name", "reason"}));
    for (const auto& barrier : json["barriers"]) {
        Keys expected{"dst_access", "dst_stages", "from", "hazard", "new_layout", "old_layout",
            "reason", "resource", "src_access", "src_stages", "step", "to"};
        if (barrier["resource"] == "result")
            std::erase_if(expected, [](const std::string& key) {
                return key.ends_with("layout"); // a buffer has none
            });
        EXPECT_EQ(keys(barrier), expected);
    }
    EXPECT_EQ(keys(json["memory"]), (Keys{"batches", "bytes_lower_bound", "bytes_peak",
                                        "compile_us", "heaps", "peak_live_bytes", "peak_step"}));
}

TEST(Dump, JsonValues) {
    const Graph graph = example();
    const nlohmann::json json = plan_json(graph.declaration(), compile(graph.declaration()));
    ASSERT_EQ(json["passes"].size(), 4u);
    EXPECT_EQ(json["passes"][1],
        nlohmann::json::parse(R"js({"name": "reduce", "kind": "compute", "culled": false,
            "reason": "kept: exported 'result' needs it (the answer)", "step": 1, "queue": 0,
            "after": [{"pass": 0, "reason": "'draw' writes 'color' for 'reduce' to read"}]})js"));
    EXPECT_EQ(json["passes"][3],
        nlohmann::json::parse(R"js({"name": "shadows", "kind": "omitted", "culled": true,
            "reason": "omitted: no light casts any"})js"));
    ASSERT_EQ(json["resources"].size(), 5u);
    EXPECT_EQ(json["resources"][0],
        nlohmann::json::parse(R"js({"name": "color", "kind": "image", "lifetime": "transient",
            "bytes": 16384, "content": "64x64 R32_SFLOAT", "heap": 0, "offset": 0, "first_step": 0,
            "last_step": 1, "culled": false, "reason": "kept: used from 'draw' to 'reduce'"})js"));
    EXPECT_EQ(json["resources"][4]["name"], "shadow_map");
    ASSERT_EQ(json["barriers"].size(), 4u);
    EXPECT_EQ(json["barriers"][2],
        nlohmann::json::parse(R"js({"resource": "color", "hazard": "read_after_write",
            "from": "draw", "to": "reduce", "src_stages": "color_output",
            "src_access": "color_write", "dst_stages": "compute", "dst_access": "sampled_read",
            "old_layout": "color", "new_layout": "read_only", "step": 1,
            "reason": "'reduce' reads 'color' as 'draw' left it"})js"));
    EXPECT_EQ(json["memory"]["bytes_peak"], 33024);
    EXPECT_EQ(json["memory"]["batches"], 2);
}

TEST(Dump, SeveralQueues) {
    const auto [graph, plan] = two_queues();
    EXPECT_EQ(plan_text(graph.declaration(), plan),
        R"(graph 'two queues': 4 of 4 passes, 7 barriers in 4 batches, 4 submissions to 2 queues, 48.0 KiB (lower bound 48.0 KiB, ratio 1.000)

step  pass     kind     queue  barrier           resource  from      src stages    src access                  dst stages    dst access                  layout
0     draw     raster   0      first_use         color     (before)  none          none                    ->  color_output  color_read+color_write      undefined -> color
                               release           color     draw      color_output  color_read+color_write  ->  none          none                        color -> read_only (family 0 -> 1)
1     light    compute  1      acquire           color     draw      compute       none                    ->  compute       sampled_read                color -> read_only (family 0 -> 1)
                               first_use         lit       (before)  none          none                    ->  compute       storage_write               undefined -> general
2     shade    raster   0      first_use         z         (before)  none          none                    ->  depth_tests   depth_read+depth_write      undefined -> depth
3     compose  compute  0      read_after_write  z         shade     depth_tests   depth_read+depth_write  ->  compute       sampled_read                depth -> read_only
                               read_after_write  lit       light     compute       storage_write           ->  compute       storage_read+storage_write  general

submission  queue  family  steps  waits for submissions
0           0      0       0-0
1           1      1       1-1    0
2           0      0       2-2
3           0      0       3-3    1

resource  kind   lifetime   content           memory    heap     offset  steps
color     image  transient  64x64 R32_SFLOAT  16.0 KiB  0        0       0-1
lit       image  transient  64x64 R32_SFLOAT  16.0 KiB  1 (own)  0       1-3
z         image  transient  64x64 D32_SFLOAT  16.0 KiB  0        16384   2-3
)");
    EXPECT_NE(
        plan_dot(graph.declaration(), plan).find(R"(label="light\nqueue 1")"), std::string::npos);
}

TEST(Dump, EmptyGraph) {
    const Declaration nothing;
    const Plan plan = compile(nothing);
    EXPECT_EQ(plan_dot(nothing, plan), "digraph \"\" {\n  rankdir=LR;\n}\n");
    EXPECT_TRUE(plan_json(nothing, plan)["passes"].empty());
    EXPECT_NE(plan_text(nothing, plan).find("0 of 0 passes, 0 barriers"), std::string::npos);
    EXPECT_NE(explain(nothing, plan).find("0 of 0 passes"), std::string::npos);
}

} // namespace
} // namespace ockham
