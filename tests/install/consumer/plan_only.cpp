// SPDX-License-Identifier: Apache-2.0
// Plans a graph without a device and prints the plan.
#include "framework/graph/compile.hpp"
#include "framework/graph/explain/dump.hpp"
#include "framework/graph/graph.hpp"

#include <cstdio>

using namespace ockham;

int main() {
    Graph graph("plan_only");
    BufferHandle data = graph.create_buffer("data", {.bytes = 1024});
    PassBuilder fill = graph.add_compute_pass("fill");
    data = fill.write("data", data);
    graph.export_resource(data, "the result");
    const Plan plan = compile(graph.declaration());
    std::printf("%s", plan_text(graph.declaration(), plan).c_str());
    return plan.steps.size() == 1 ? 0 : 1;
}
