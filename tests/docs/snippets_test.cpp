// SPDX-License-Identifier: Apache-2.0
// The documentation shows code that is compiled: every C++, GLSL and CMake block names the region
// of a source file that it repeats, in the line before it: <!-- snippet: tests/docs/x.cpp#name -->.
// A region lies between the comments [name] and [/name]; without #name it is the whole file. What a
// diff block leaves of its lines stands in the file as it is.
#include "tests/docs/documents.hpp"

#include <fmt/format.h>

#include <cctype>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace ockham {
namespace {

namespace fs = std::filesystem;

using test::documents, test::kRoot, test::read_lines;

std::string trimmed(const std::string& line) {
    const auto first = line.find_first_not_of(' ');
    return first == std::string::npos ? "" : line.substr(first);
}

/// Lines without the blanks that all of them begin with.
std::string unindented(const std::vector<std::string>& lines) {
    std::size_t indent = std::string::npos;
    for (const std::string& line : lines) indent = std::min(indent, line.find_first_not_of(' '));
    std::string text;
    for (const std::string& line : lines)
        text += (line.size() > indent ? line.substr(indent) : "") + "\n";
    return text;
}

std::string text_of(const fs::path& path) {
    std::string text;
    for (const std::string& line : read_lines(path)) text += line + "\n";
    return text;
}

/// The region `name` of a source file, all of it for no name; nothing if there is none.
std::optional<std::string> region_of(const fs::path& path, const std::string& name) {
    if (name.empty()) return text_of(path);
    std::vector<std::string> lines;
    bool inside = false;
    for (const std::string& line : read_lines(path)) {
        const std::string text = trimmed(line);
        const auto is = [&](const std::string& mark) {
            return text == "// " + mark || text == "# " + mark;
        };
        if (is("[/" + name + "]")) return unindented(lines);
        if (inside) lines.push_back(line);
        if (is("[" + name + "]")) inside = true;
    }
    return std::nullopt;
}

/// What GitHub makes of a heading: lower case, dashes for spaces, no punctuation.
std::string slug_of(const std::string& heading) {
    std::string slug;
    for (const char c : heading) {
        const auto byte = static_cast<unsigned char>(c);
        if (c == ' ')
            slug += '-';
        else if (c == '-' || c == '_' || std::isalnum(byte) || byte >= 0x80)
            slug += static_cast<char>(std::tolower(byte));
    }
    return slug;
}

/// The anchors of a document's headings; equal ones are numbered.
std::set<std::string> anchors_of(const fs::path& document) {
    std::set<std::string> anchors;
    bool code = false;
    for (const std::string& line : read_lines(document)) {
        if (line.starts_with("```")) code = !code;
        const std::size_t level = line.find_first_not_of('#');
        if (code || level == 0 || level == std::string::npos || line[level] != ' ') continue;
        const std::string slug = slug_of(line.substr(level + 1));
        std::string anchor = slug;
        for (int n = 1; !anchors.insert(anchor).second; ++n) anchor = fmt::format("{}-{}", slug, n);
    }
    return anchors;
}

TEST(Snippets, AnchorsAreThoseOfGitHub) {
    EXPECT_EQ(slug_of("Plan files (`.json`), versions 1-2"), "plan-files-json-versions-1-2");
    EXPECT_TRUE(anchors_of(kRoot / "docs/runtime.md").contains("one-execution"));
}

TEST(Snippets, AreRegionsOfCompiledFiles) {
    const std::set<std::string> languages{"cpp", "glsl", "cmake", "diff"};
    const std::string before = "<!-- snippet: ", after = " -->";
    std::size_t count = 0;
    for (const fs::path& document : documents()) {
        const std::vector<std::string> lines = read_lines(document);
        for (std::size_t i = 0; i < lines.size(); ++i) {
            if (!lines[i].starts_with("```") || lines[i].size() == 3) continue;
            if (!languages.contains(lines[i].substr(3))) continue;
            const bool diff = lines[i] == "```diff";
            const std::string where = fmt::format("{}:{}", document.string(), i + 1);
            const std::string mark = i == 0 ? "" : lines[i - 1];
            if (!mark.starts_with(before) || !mark.ends_with(after)) {
                ADD_FAILURE() << where << ": no <!-- snippet: file#name --> before this block";
                continue;
            }
            const std::string target =
                mark.substr(before.size(), mark.size() - before.size() - after.size());
            const std::size_t hash = std::min(target.find('#'), target.size());
            const fs::path source = kRoot / target.substr(0, hash);
            const std::string name = hash < target.size() ? target.substr(hash + 1) : "";
            const auto region = region_of(source, name);
            ASSERT_TRUE(region) << where << ": " << source << " has no region [" << name << "]";
            std::string shown;
            for (++i; i < lines.size() && lines[i] != "```"; ++i) {
                if (diff && lines[i].starts_with('-')) continue;
                shown += lines[i].substr(diff && !lines[i].empty() ? 1 : 0) + "\n";
            }
            if (diff) {
                EXPECT_NE(region->find(shown), std::string::npos)
                    << where << ": " << source << " has no such lines:\n"
                    << shown;
            } else {
                EXPECT_EQ(shown, *region) << where << " is not what " << source << " has";
            }
            ++count;
        }
    }
    EXPECT_GT(count, 10u);
}

/// Links between documents, to their headings, and to files of the tree lead somewhere.
TEST(Snippets, LinksOfDocumentsExist) {
    for (const fs::path& document : documents()) {
        bool code = false;
        for (const std::string& line : read_lines(document)) {
            if (line.starts_with("```")) code = !code;
            for (std::size_t at = code ? std::string::npos : line.find("](");
                 at != std::string::npos; at = line.find("](", at + 1)) {
                const std::string link = line.substr(at + 2, line.find(')', at) - at - 2);
                if (link.starts_with("http")) continue;
                const std::size_t hash = link.find('#');
                const fs::path target =
                    hash == 0 ? document : document.parent_path() / link.substr(0, hash);
                EXPECT_TRUE(fs::exists(target)) << document << " links to " << link;
                if (hash == std::string::npos || target.extension() != ".md") continue;
                EXPECT_TRUE(anchors_of(target).contains(link.substr(hash + 1)))
                    << document << " links to " << link << ", and no heading is called that";
            }
        }
    }
}

} // namespace
} // namespace ockham
