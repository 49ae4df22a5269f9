// SPDX-License-Identifier: Apache-2.0
// The commands that the pages show. commands_test.cpp lets the programs parse them, and
// commands_run_test.cpp runs them.
#pragma once

#include "tests/docs/documents.hpp"

#include <algorithm>
#include <string>
#include <vector>

namespace ockham::test {

struct Command {
    std::string where; ///< page:line
    std::string text;  ///< one line, without comment and without build/release/bin/
};

inline std::string trimmed(const std::string& line) {
    const auto first = line.find_first_not_of(' ');
    if (first == std::string::npos) return "";
    return line.substr(first, line.find_last_not_of(' ') + 1 - first);
}

/// Words as a shell takes them, without quotes.
inline std::vector<std::string> words_of(const std::string& text) {
    std::vector<std::string> words;
    bool inside = false, quoted = false;
    for (const char c : text) {
        if (c == '"') quoted = !quoted;
        const bool space = c == ' ' && !quoted;
        if (!space && !inside) words.emplace_back();
        inside = !space;
        if (inside && c != '"') words.back() += c;
    }
    return words;
}

/// The commands of a line that && joins.
inline std::vector<std::string> parts_of(const std::string& text) {
    std::vector<std::string> parts;
    std::size_t from = 0;
    for (std::size_t to; (to = text.find(" && ", from)) != std::string::npos; from = to + 4)
        parts.push_back(trimmed(text.substr(from, to - from)));
    parts.push_back(trimmed(text.substr(from)));
    return parts;
}

/// Lines of code blocks that begin with one of `programs`. Those with [brackets] say what could be
/// typed, and are none.
inline std::vector<Command> commands_of(
    const std::filesystem::path& page, const std::vector<std::string>& programs) {
    const std::vector<std::string> lines = read_lines(page);
    std::vector<Command> commands;
    std::string fence; // what opened the block
    for (std::size_t i = 0; i < lines.size(); ++i) {
        if (lines[i].starts_with("```")) {
            fence = fence.empty() ? lines[i] : "";
            continue;
        }
        const bool code = fence.empty() ? lines[i].starts_with("    ")
                                        : fence == "```" && !lines[i].starts_with(" ");
        if (!code) continue;
        const std::string where =
            page.lexically_relative(kRoot).string() + ":" + std::to_string(i + 1);
        std::string text = trimmed(lines[i]);
        if (const std::string folder = "build/release/bin/"; text.starts_with(folder))
            text.erase(0, folder.size());
        const std::string program = text.substr(0, text.find(' '));
        if (std::ranges::find(programs, program) == programs.end()) continue;
        while (text.ends_with('\\') && i + 1 < lines.size())
            text = text.substr(0, text.size() - 1) + trimmed(lines[++i]);
        text = trimmed(text.substr(0, text.find(" #")));
        if (text.find(" [") == std::string::npos) commands.push_back({where, text});
    }
    return commands;
}

} // namespace ockham::test
