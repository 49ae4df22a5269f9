// SPDX-License-Identifier: Apache-2.0
// The page of a chart run: plots, tables and pictures in one HTML file that needs nothing else, no
// network either. Knows no technique. Filled by suites, written by main.cpp.
#pragma once

#include "samples/chart/plot.hpp"

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace ockham::chart {

/// Also written as `name`.csv. Cells are text as it is to be shown; columns of numbers are aligned.
struct Table {
    std::string name;
    std::string title;
    std::vector<std::string> columns;
    std::vector<std::vector<std::string>> rows{};
    std::string caption{}; ///< HTML
};

/// Pictures of one view to be compared: two of them under a wipe, and their error maps.
struct Wipe {
    struct Side {
        std::string label;
        std::filesystem::path picture;     ///< PNG, relative to the store's folder
        std::filesystem::path error_map{}; ///< likewise; empty: none
        std::filesystem::path reference{}; ///< likewise: what the picture should be; empty: unknown
    };
    std::string title;
    std::vector<Side> sides{}; ///< the first two are shown first
    std::string caption{};     ///< HTML
};

/// What a suite has to show.
struct Section {
    std::string title;
    std::string text{}; ///< HTML, under the title
    std::vector<Plot> plots{};
    std::vector<Table> tables{};
    std::vector<Wipe> wipes{};
};

/// What the page says about where and how its numbers were made: names and values.
using Manifest = std::vector<std::pair<std::string, std::string>>;

/// Writes `folder`/NAME.csv of every plot and table, NAME.svg by gnuplot, and index.html. Without
/// gnuplot: CSV and a page with tables only, and a warning that says so. Throws Error(input).
void write_page(const std::filesystem::path& folder, const std::string& title,
    const std::vector<Section>& sections, const Manifest& manifest);

/// & < > " of a text, as HTML.
std::string escape(const std::string& text);

} // namespace ockham::chart
