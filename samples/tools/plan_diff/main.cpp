// SPDX-License-Identifier: Apache-2.0
// plan_diff A B: what changed from plan file A to plan file B, as --plan F.json writes them, and
// whether B keeps a budget. Needs no device; --replan plans both anew with this build's compiler.
#include "framework/core/error.hpp"
#include "framework/core/file.hpp"
#include "framework/core/json_object.hpp"
#include "framework/core/log.hpp"
#include "framework/graph/explain/budget.hpp"
#include "framework/graph/explain/dump.hpp"
#include "framework/graph/explain/plan_diff.hpp"
#include "framework/graph/explain/plan_file.hpp"

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <cstdio>
#include <exception>
#include <string>

namespace {

using namespace ockham;

struct Arguments {
    std::string before, after;
    bool replan = false;
    std::string json;
    Budget budget;
};

nlohmann::json load(const std::string& path, bool replan) {
    nlohmann::json plan = parse_json(path, "plan file");
    try {
        if (!replan) {
            plan_diff(plan, plan); // says what is wrong with it, if anything
            return plan;
        }
        const PlanFile file = load_plan_file(plan);
        const Plan anew = compile(file.declaration, file.capabilities, file.policy);
        return plan_json(file.declaration, anew, file.capabilities, file.policy);
    } catch (const Error& error) {
        throw Error(error.kind(), fmt::format("'{}': {}", path, error.what()));
    }
}

/// Exit code: 0, or 1 where the budget is exceeded.
int run(const Arguments& arguments) {
    if (!arguments.json.empty()) check_writable(arguments.json);
    const nlohmann::json before = load(arguments.before, arguments.replan);
    const nlohmann::json after =
        arguments.after.empty() ? before : load(arguments.after, arguments.replan);
    nlohmann::json diff = plan_diff(before, after);
    const std::string over = over_budget(after, arguments.budget);
    if (!arguments.after.empty()) fmt::print("{}", plan_diff_text(diff));
    if (!over.empty()) fmt::print("over budget:\n{}", over);
    if (!arguments.json.empty()) {
        diff["over_budget"] = over;
        write_text(arguments.json,
            diff.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
    }
    if (std::fflush(stdout) != 0) fail_input("cannot write the results to standard output");
    return over.empty() ? 0 : 1;
}

} // namespace

int main(int argc, char** argv) {
    Arguments arguments;
    CLI::App app{"What changed between two plan files (--plan F.json), and whether the second, or "
                 "the only one, keeps a budget. Exit code: 0 done, 1 over budget, 2 bad input."};
    app.add_option("before", arguments.before, "plan file")->required();
    app.add_option("after", arguments.after, "plan file to compare with it");
    app.add_flag("--replan", arguments.replan, "plan both anew, from their declarations");
    app.add_option("--json", arguments.json, "write the difference as JSON");
    app.add_option("--max-passes", arguments.budget.passes, "most passes that may be executed");
    app.add_option("--max-barriers", arguments.budget.barriers, "most barriers");
    app.add_option("--max-batches", arguments.budget.batches, "most batches of barriers");
    app.add_option("--max-bytes", arguments.budget.bytes, "most bytes of all heaps");
    try {
        app.parse(argc, argv);
        return run(arguments);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : 2;
    } catch (const Error& error) {
        log::error("{}", error.what());
        return 2; // a memory budget in the file that the new plan breaks is bad input too
    } catch (const std::exception& error) {
        log::error("{}", error.what());
        return 2;
    }
}
