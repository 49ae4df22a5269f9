// SPDX-License-Identifier: Apache-2.0
// Runs the project's programs as a user does, in a folder of their own: exit codes, what they
// print, files they leave. OCKHAM_BIN is where the programs are.
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace ockham::test {

struct Result {
    int exit_code = -1;
    std::string text; ///< stdout and stderr
};

class ProgramTest : public testing::Test {
protected:
    explicit ProgramTest(std::string program)
        : folder(std::filesystem::temp_directory_path() /
                 ("ockham_" + program + "." + std::to_string(::getpid()))),
          program_(std::move(program)) {
        std::filesystem::create_directories(folder);
    }
    ~ProgramTest() override { std::filesystem::remove_all(folder); }

    /// A shell's command line that runs the program in the folder.
    std::string command(const std::string& arguments, const std::string& environment = "",
        const std::string& program = "") const {
        return "cd '" + folder.string() + "' && " + environment + " '" OCKHAM_BIN "/" +
               (program.empty() ? program_ : program) + "' " + arguments + " 2>&1";
    }

    Result run(const std::string& arguments, const std::string& environment = "",
        const std::string& program = "") {
        Result result;
        FILE* pipe = ::popen(command(arguments, environment, program).c_str(), "r");
        EXPECT_NE(pipe, nullptr);
        char buffer[4096];
        while (std::fgets(buffer, sizeof(buffer), pipe) != nullptr) result.text += buffer;
        const int status = ::pclose(pipe);
        result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128;
        return result;
    }

    std::set<std::string> files() const {
        std::set<std::string> names;
        for (const auto& entry : std::filesystem::directory_iterator(folder))
            names.insert(entry.path().filename());
        return names;
    }

    /// Runs; expects the code, exactly one line that begins with "error: ", all of `parts` in it,
    /// and no new file.
    void expect_error(const std::string& arguments, int code, const std::vector<std::string>& parts,
        const std::string& environment = "") {
        const std::set<std::string> before = files();
        const Result result = run(arguments, environment);
        EXPECT_EQ(result.exit_code, code) << arguments << "\n" << result.text;
        std::size_t errors = 0;
        for (std::size_t at = result.text.find("error: "); at != std::string::npos;
             at = result.text.find("error: ", at + 1)) {
            ++errors;
        }
        EXPECT_EQ(errors, 1u) << arguments << "\n" << result.text;
        for (const std::string& part : parts) {
            EXPECT_NE(result.text.find(part), std::string::npos) << arguments << "\n"
                                                                 << result.text;
        }
        EXPECT_EQ(files(), before) << arguments;
    }

    std::filesystem::path folder;

private:
    std::string program_;
};

} // namespace ockham::test
