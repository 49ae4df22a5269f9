// SPDX-License-Identifier: Apache-2.0
// Every command of every page is one that its program takes today: flags exist, values are in
// range, presets and scripts are there. Nothing is rendered: commands_run_test.cpp does that.
#include "framework/core/file.hpp"
#include "tests/docs/commands.hpp"
#include "tests/support/program_test.hpp"

#include <fmt/format.h>

#include <map>
#include <regex>

namespace ockham {
namespace {

using test::Command, test::commands_of, test::documents, test::kRoot, test::parts_of,
    test::words_of;

class Commands : public test::ProgramTest {
protected:
    Commands() : ProgramTest("docs_commands") {}

    const std::string& help_of(const std::string& program) {
        std::string& help = helps_[program];
        if (help.empty()) help = run("--help", "", program).text;
        return help;
    }
    /// The folder is the user's home.
    static std::string home_here(std::string text) {
        const std::size_t at = text.find(" ~/");
        return at == std::string::npos ? text : text.erase(at + 1, 2);
    }
    /// `part`: a program and its arguments.
    void expect_parsed(const std::string& where, const std::string& part) {
        const std::string program = part.substr(0, part.find(' '));
        const std::string arguments = part.substr(program.size());
        if (help_of(program).find("--dump-config") != std::string::npos) {
            const test::Result result =
                run(home_here(arguments) + " --dump-config parsed.json", "", program);
            EXPECT_EQ(result.exit_code, 0) << where << ": " << part << "\n" << result.text;
            return;
        }
        for (const std::string& word : words_of(arguments)) { // no run file: by name at least
            if (!word.starts_with("--")) continue;
            const std::regex row(fmt::format(R"((^|\s){}\b)", word.substr(0, word.find('='))));
            EXPECT_TRUE(std::regex_search(help_of(program), row)) << where << ": " << part;
        }
    }

private:
    std::map<std::string, std::string> helps_;
};

TEST_F(Commands, OfAllPagesAreParsedByTheirPrograms) {
    const std::vector<std::string> programs = words_of(OCKHAM_PROGRAMS);
    std::filesystem::create_directories(folder / ".config/ockham");
    write_text(folder / ".config/ockham/viewer.json", "{}"); // as a session leaves one
    std::size_t count = 0;
    for (const auto& page : documents()) {
        for (const Command& command : commands_of(page, programs)) {
            for (const std::string& part : parts_of(command.text)) {
                expect_parsed(command.where, part);
                ++count;
            }
        }
    }
    EXPECT_GT(count, 80u);
}

TEST_F(Commands, NamePresetsAndScriptsThatExist) {
    const std::string presets = read_text(kRoot / "CMakePresets.json");
    const std::regex preset(R"(--preset (\w+))"), script(R"(-P (\S+\.cmake))");
    std::size_t count = 0;
    for (const auto& page : documents()) {
        for (const Command& command : commands_of(page, {"cmake", "ctest"})) {
            const std::string& text = command.text;
            for (std::sregex_iterator it(text.begin(), text.end(), preset), end; it != end; ++it) {
                EXPECT_NE(presets.find(fmt::format("\"{}\"", (*it)[1].str())), std::string::npos)
                    << command.where << ": " << text;
                ++count;
            }
            std::smatch found;
            if (std::regex_search(text, found, script)) {
                EXPECT_TRUE(std::filesystem::exists(kRoot / found[1].str()))
                    << command.where << ": " << text;
                ++count;
            }
        }
    }
    EXPECT_GT(count, 10u);
}

} // namespace
} // namespace ockham
