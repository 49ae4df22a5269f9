// SPDX-License-Identifier: Apache-2.0
// plan_diff as scripts meet it: exit codes, what it prints, what it writes.
#include "framework/core/file.hpp"
#include "framework/graph/explain/dump.hpp"
#include "framework/graph/graph.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>

namespace ockham {
namespace {

class PlanDiffProgram : public testing::Test {
protected:
    void SetUp() override {
        const char* const test = testing::UnitTest::GetInstance()->current_test_info()->name();
        folder_ = std::filesystem::path(testing::TempDir()) / fmt::format("ockham_{}", test);
        std::filesystem::create_directories(folder_);
        write("a.json", 1);
        write("b.json", 3);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    std::string path(const char* name) const { return (folder_ / name).string(); }

    /// A chain of so many passes, as --plan writes it.
    void write(const char* name, int passes) const {
        Graph graph("chain");
        BufferHandle last = graph.import_buffer("in", {64}, {});
        for (int i = 0; i < passes; ++i) {
            auto pass = graph.add_compute_pass(fmt::format("p{}", i));
            pass.read("from", last);
            last = pass.write("to", graph.create_buffer(fmt::format("b{}", i), {1 << 20}));
        }
        graph.export_resource(last, "wanted");
        write_text(path(name), plan_json(graph.declaration(), compile(graph.declaration())).dump());
    }

    /// Exit code; what it prints is in `out_`.
    int run(const std::string& arguments) {
        const std::string command =
            fmt::format("{}/plan_diff {} > {} 2>&1", OCKHAM_BIN, arguments, path("out.txt"));
        const int status = std::system(command.c_str());
        out_ = read_text(path("out.txt"));
        return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    }
    std::string files() const { return path("a.json") + " " + path("b.json"); }

    std::filesystem::path folder_;
    std::string out_;
};

TEST_F(PlanDiffProgram, SaysWhatChanged) {
    for (const char* flags : {"", " --replan"}) {
        ASSERT_EQ(run(files() + flags), 0) << out_;
        EXPECT_EQ(out_.find("+2 passes, "), 0u) << out_;
        EXPECT_NE(out_.find("+2.0 MiB\n"), std::string::npos) << out_;
        EXPECT_NE(out_.find("new pass 'p2': kept: exported 'b2'"), std::string::npos) << out_;
        ASSERT_EQ(run(path("a.json") + " " + path("a.json") + flags), 0);
        EXPECT_EQ(out_, "no difference\n");
    }
}

TEST_F(PlanDiffProgram, ExitCodesOfBudgets) {
    EXPECT_EQ(run(files() + " --max-passes 3 --max-bytes 3145728"), 0) << out_;
    EXPECT_EQ(run(files() + " --max-passes 2 --json " + path("d.json")), 1);
    EXPECT_NE(out_.find("3 passes, 1 above the budget of 2"), std::string::npos) << out_;
    const auto json = nlohmann::json::parse(read_text(path("d.json")));
    EXPECT_EQ(json["numbers"]["passes"]["after"], 3);
    EXPECT_EQ(json["over_budget"], "3 passes, 1 above the budget of 2\n");
    EXPECT_EQ(run(path("b.json") + " --max-batches 0"), 1) << "a budget needs only one plan";
}

TEST_F(PlanDiffProgram, RefusesBadInput) {
    EXPECT_EQ(run(path("a.json") + " " + path("none.json")), 2);
    EXPECT_EQ(run(files() + " --max-passes few"), 2);
    write_text(path("c.json"), R"({"passes": 3})");
    EXPECT_EQ(run(path("a.json") + " " + path("c.json")), 2);
    EXPECT_NE(out_.find("c.json': [bad-plan-file] /passes: found number, expected an array"),
        std::string::npos)
        << out_;
    EXPECT_EQ(run(path("c.json") + " --replan"), 2);
}

} // namespace
} // namespace ockham
