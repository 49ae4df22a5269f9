// SPDX-License-Identifier: Apache-2.0
// docs/cli.md and --help tell of the same flags: each flag of a program has a row in the section of
// that program, or in those of adaptive_aa and volume_gi, which others refer to; ranges, choices and defaults
// agree; and no row is of a flag that is gone.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <optional>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace ockham {
namespace {

/// One flag, as --help or a row of docs/cli.md says. What is not said is empty.
struct Flag {
    std::string range, fallback;
    std::set<std::string> choices;
};

using Flags = std::map<std::string, Flag>;

std::vector<std::string> matches(const std::string& text, const std::regex& pattern) {
    std::vector<std::string> found;
    for (std::sregex_iterator it(text.begin(), text.end(), pattern), end; it != end; ++it)
        found.push_back((*it)[1]);
    return found;
}

void replace(std::string& text, const std::string& what, const std::string& by) {
    for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += by.size())
        text.replace(at, what.size(), by);
}

/// "−1", "16,384", "10⁹", "2³¹ − 1", "∞"; nothing if it is no number.
std::optional<double> number(std::string text) {
    const char* superscripts[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
    for (int digit = 0; digit < 10; ++digit)
        replace(text, superscripts[digit], fmt::format("^{}", digit));
    replace(text, "−", "-");
    replace(text, "∞", "inf");
    replace(text, ",", "");
    replace(text, "`", "");
    std::smatch power;
    if (std::regex_match(text, power, std::regex(R"((\d+)\^(\d)(?:\^(\d))?( - 1)?)"))) {
        const double exponent = std::stod(power[2].str() + power[3].str());
        return std::pow(std::stod(power[1]), exponent) - (power[4].matched ? 1 : 0);
    }
    char* end = nullptr;
    const double value = std::strtod(text.c_str(), &end);
    return text.empty() || *end != 0 ? std::nullopt : std::optional(value);
}

/// "1 … 8" or "1 ... 8", perhaps with a unit; nothing if it is something else.
std::optional<std::pair<double, double>> range(std::string text) {
    replace(text, "…", "...");
    const std::size_t dots = text.find(" ... ");
    if (dots == std::string::npos) return std::nullopt;
    const auto low = number(text.substr(0, dots));
    std::string rest = text.substr(dots + 5);
    auto high = number(rest);
    if (!high) high = number(rest.substr(0, rest.find(' '))); // "1073741824 MiB"
    if (!low || !high) return std::nullopt;
    return std::pair(*low, *high);
}

Flags flags_of_program(const std::string& program) {
    FILE* const pipe = ::popen((std::string(OCKHAM_BIN "/") + program + " --help").c_str(), "r");
    std::string help;
    for (char buffer[4096]; const std::size_t size = std::fread(buffer, 1, sizeof buffer, pipe);)
        help.append(buffer, size);
    EXPECT_EQ(::pclose(pipe), 0) << program;
    replace(help, "\n                              ", " "); // a long flag has a line of its own

    Flags flags;
    const std::regex line(R"((?:^|\n)  (?:-\w,)?--([\w-]+)(?: TEXT \.\.\.)? +([^\n]*))");
    for (std::sregex_iterator it(help.begin(), help.end(), line), end; it != end; ++it) {
        const std::string text = (*it)[2];
        Flag& flag = flags[(*it)[1]];
        std::smatch part;
        if (std::regex_search(text, part, std::regex(R"(\[([\w|-]+)\])"))) {
            for (const std::string& choice : matches(part[1], std::regex(R"(([^|]+))")))
                flag.choices.insert(choice);
        }
        if (std::regex_search(text, part, std::regex(R"(; (\S+ \.\.\. [^;]+))")))
            flag.range = part[1];
        if (std::regex_search(text, part, std::regex(R"(; default (\S+)$)")))
            flag.fallback = part[1];
    }
    flags.erase("help");
    EXPECT_FALSE(flags.empty()) << program;
    return flags;
}

/// The rows of docs/cli.md by section.
std::map<std::string, Flags> documented() {
    std::map<std::string, Flags> sections;
    std::ifstream file(OCKHAM_SOURCE_DIR "/docs/cli.md");
    EXPECT_TRUE(file);
    std::string section;
    std::vector<std::string> columns;
    for (std::string line; std::getline(file, line);) {
        if (line.rfind("## ", 0) == 0) section = line.substr(3);
        if (line.rfind("| ", 0) != 0) {
            if (line.rfind("|", 0) != 0) columns.clear();
            continue;
        }
        const std::vector<std::string> cells =
            matches(line, std::regex(R"(\| ((?:`[^`]*`|[^|])*?) (?=\|))"));
        if (columns.empty()) {
            columns = cells;
            continue;
        }
        if (columns.front() != "flag") continue;
        std::size_t place = 0;
        for (const std::string& name : matches(cells.front(), std::regex(R"(`--([\w-]+))"))) {
            Flag& flag = sections[section][name];
            for (std::size_t c = 1; c < std::min(cells.size(), columns.size()); ++c) {
                if (columns[c] == "range") {
                    flag.range = cells[c];
                    for (const std::string& choice : matches(cells[c], std::regex(R"(`([^`]+)`)")))
                        flag.choices.insert(choice);
                }
                if (columns[c] == "default") {
                    const auto each = matches(cells[c], std::regex(R"(([^,]+(?:,\d{3})*)(?:, )?)"));
                    flag.fallback = place < each.size() && each.size() > 1 ? each[place] : cells[c];
                }
            }
            ++place;
        }
    }
    return sections;
}

void expect_same(const std::string& what, const Flag& help, const Flag& row) {
    // A word made of several numbers states its own range.
    const bool is_number = !help.range.empty() || number(help.fallback);
    if (const auto said = range(row.range); said && is_number) {
        EXPECT_EQ(range(help.range), said) << what << ": " << help.range << ", " << row.range;
    }
    if (!row.choices.empty() && !help.choices.empty()) {
        EXPECT_EQ(help.choices, row.choices) << what;
    }
    std::string fallback = row.fallback;
    replace(fallback, "`", "");
    if (help.fallback.empty() || fallback.empty()) return;
    const auto value = number(help.fallback), said = number(fallback);
    if (value && said) {
        EXPECT_EQ(*value, *said) << what;
    } else if (!help.choices.empty()) {
        EXPECT_EQ(help.fallback, fallback) << what;
    }
}

TEST(Flags, of_all_programs_are_documented_as_declared) {
    std::map<std::string, Flags> sections = documented();
    Flags shared = sections["adaptive_aa"];
    shared.insert(sections["volume_gi"].begin(), sections["volume_gi"].end());
    std::set<std::string> seen;
    for (const std::string& program : matches(OCKHAM_PROGRAMS, std::regex(R"((\w+))"))) {
        ASSERT_TRUE(sections.contains(program)) << "docs/cli.md has no section '" << program << "'";
        const Flags flags = flags_of_program(program);
        for (const auto& [name, flag] : flags) {
            const std::string what = fmt::format("{} --{}", program, name);
            const bool own = sections[program].contains(name);
            ASSERT_TRUE(own || shared.contains(name) || name == "version") << what << " has no row";
            expect_same(what, flag, own ? sections[program][name] : shared.at(name));
        }
        for (const auto& [name, row] : sections[program])
            EXPECT_TRUE(flags.contains(name) || name == "help") << program << " has no --" << name;
    }
}

} // namespace
} // namespace ockham
