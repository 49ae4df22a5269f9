// SPDX-License-Identifier: Apache-2.0
// Other programs: arguments arrive as they are, what they say comes back, ends are told apart.
#include "framework/core/error.hpp"
#include "framework/core/file.hpp"
#include "framework/core/process.hpp"

#include <gtest/gtest.h>

namespace ockham {
namespace {

TEST(Process, ArgumentsAreReadByNoShell) {
    const ProcessResult result = run_process({"printf", "%s|%s|%s", "a b", "$HOME;'\"*", ""});
    EXPECT_EQ(result.exit_code, 0);
    EXPECT_EQ(result.text, "a b|$HOME;'\"*|");
}

TEST(Process, TellsHowAProgramEnded) {
    EXPECT_EQ(run_process({"sh", "-c", "echo out; echo err >&2; exit 7"}).exit_code, 7);
    EXPECT_EQ(run_process({"sh", "-c", "echo out; echo err >&2; exit 7"}).text, "out\nerr\n");
    EXPECT_EQ(run_process({"sh", "-c", "kill -9 $$"}).exit_code, 128 + 9);
    EXPECT_EQ(run_process({"cat"}).text, "") << "there is nothing to read";
    EXPECT_EQ(run_process({"sh", "-c", "head -c 1000000 /dev/zero"}).text.size(), 1000000u);
}

TEST(Process, RunsInAFolderThatIsGoneAfterwards) {
    std::filesystem::path path;
    {
        const TemporaryFolder folder;
        path = folder.path();
        EXPECT_EQ(run_process({"pwd"}, path).text, path.string() + "\n");
        write_text(path / "file", "text");
    }
    EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(Process, ProgramsAreFoundOrRefusedByName) {
    EXPECT_TRUE(find_program("sh")->is_absolute());
    EXPECT_TRUE(find_program("/bin/sh"));
    for (const char* name : {"", "no-such-program", "/no/such", "/etc/passwd", "/"}) {
        EXPECT_FALSE(find_program(name)) << name;
        try {
            run_process({name});
            ADD_FAILURE() << name;
        } catch (const Error& error) {
            EXPECT_NE(std::string(error.what()).find("cannot start"), std::string::npos);
        }
    }
}

} // namespace
} // namespace ockham
