// SPDX-License-Identifier: Apache-2.0
#include "samples/chart/page.hpp"

#include "framework/core/file.hpp"
#include "framework/core/log.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cctype>

namespace ockham::chart {

const char* page_template(); ///< page.html

namespace {

std::string base64(std::span<const std::byte> bytes) {
    constexpr const char* kDigits =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    text.reserve((bytes.size() + 2) / 3 * 4);
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t group = 0;
        for (std::size_t k = 0; k < 3; ++k)
            group = group << 8 |
                    (i + k < bytes.size() ? std::to_integer<std::uint32_t>(bytes[i + k]) : 0);
        for (std::size_t k = 0; k < 4; ++k)
            text += i + k > bytes.size() ? '=' : kDigits[group >> (18 - 6 * k) & 63];
    }
    return text;
}

std::string data_uri(const std::filesystem::path& file) {
    const char* type = file.extension() == ".svg" ? "image/svg+xml" : "image/png";
    return fmt::format("data:{};base64,{}", type, base64(read_file(file)));
}

/// As it may stand in a file's name and in an anchor.
std::string anchor(const std::string& text) {
    std::string result;
    for (const char c : text)
        result += std::isalnum(static_cast<unsigned char>(c)) != 0
                      ? static_cast<char>(std::tolower(static_cast<unsigned char>(c)))
                      : '-';
    return result;
}

bool is_number(const std::string& cell) {
    if (cell == "∞") return true;
    return cell.find_first_of("0123456789") != std::string::npos &&
           cell.find_first_not_of("0123456789.,+-−–e%×± ∞") == std::string::npos;
}

/// Numbers are told from text by most of the cells.
bool holds_numbers(const Table& table, std::size_t column) {
    std::size_t numbers = 0, filled = 0;
    for (const auto& row : table.rows) {
        if (column >= row.size() || row[column].empty()) continue;
        ++filled;
        if (is_number(row[column])) ++numbers;
    }
    return filled > 0 && 2 * numbers > filled;
}

std::string html(const Table& table) {
    constexpr std::size_t kMany = 13; // columns that stand closer, to fit 1280 pixels
    std::string text = fmt::format("<h3>{}</h3>\n<div class=\"scroll\"><table{}>\n<thead><tr>",
        escape(table.title), table.columns.size() > kMany ? " class=\"many\"" : "");
    const auto cells = [&](const std::vector<std::string>& row, const char* tag) {
        for (std::size_t c = 0; c < row.size(); ++c) {
            text += fmt::format("<{0}{1}>{2}</{0}>", tag,
                holds_numbers(table, c) ? " class=\"number\"" : "", escape(row[c]));
        }
    };
    cells(table.columns, "th");
    text += "</tr></thead>\n<tbody>\n";
    for (const auto& row : table.rows) {
        text += "<tr>";
        cells(row, "td");
        text += "</tr>\n";
    }
    return text + fmt::format("</tbody></table></div>\n<p class=\"soft\">{} <a href=\"{}.csv\">"
                              "Numbers</a>.</p>\n",
                      table.caption, table.name);
}

std::string csv(const Table& table) {
    std::string text;
    const auto add = [&](const std::vector<std::string>& row) {
        for (std::size_t i = 0; i < row.size(); ++i)
            text += csv_cell(row[i]) + (i + 1 < row.size() ? ',' : '\n');
    };
    add(table.columns);
    for (const auto& row : table.rows) add(row);
    return text;
}

std::string html(const Plot& plot, const std::filesystem::path& folder) {
    return fmt::format("<figure id=\"{0}\">\n<img src=\"{1}\" alt=\"{2}\">\n<figcaption>{3} "
                       "<a href=\"{0}.csv\">Numbers</a>, <a href=\"{0}.svg\">SVG</a>."
                       "</figcaption>\n</figure>\n",
        plot.name, data_uri(folder / (plot.name + ".svg")), escape(plot.question), plot.caption);
}

std::string html(const Wipe& wipe, const std::filesystem::path& folder) {
    nlohmann::ordered_json sides = nlohmann::ordered_json::array();
    std::string left, right;
    for (std::size_t i = 0; i < wipe.sides.size(); ++i) {
        const Wipe::Side& side = wipe.sides[i];
        sides.push_back({{"label", side.label}});
        if (i > 1) sides.back()["picture"] = data_uri(folder / side.picture); // others: see below
        if (!side.error_map.empty()) sides.back()["error"] = data_uri(folder / side.error_map);
        const auto option = [&](std::size_t shown) {
            return fmt::format("<option value=\"{}\"{}>{}</option>", i,
                i == shown ? " selected" : "", escape(side.label));
        };
        left += option(0);
        right += option(1);
    }
    if (wipe.sides.size() < 2) return {};
    // In a script, no text may look like its end.
    std::string json = sides.dump();
    for (std::size_t at = 0; (at = json.find("</", at)) != std::string::npos; at += 3)
        json.replace(at, 2, "<\\/");
    return fmt::format(R"(<figure class="wipe">
<div class="stage"><img alt="{1}" src="{3}"><img class="over" alt="{0}" src="{2}"><div class="bar"></div><span class="left">{0}</span><span class="right">{1}</span></div>
<div class="controls"><label>left <select>{4}</select></label><label>right <select>{5}</select></label><label><input type="checkbox"> errors &times; 10 <span class="scale" title="0 to 0.1 of full scale"></span></label></div>
<figcaption><b>{6}</b> {7}</figcaption>
<script type="application/json">{8}</script>
</figure>
)",
        escape(wipe.sides[0].label), escape(wipe.sides[1].label),
        data_uri(folder / wipe.sides[0].picture), data_uri(folder / wipe.sides[1].picture), left,
        right, escape(wipe.title), wipe.caption, json);
}

std::string html(const Section& section, const std::filesystem::path& folder, bool charts) {
    std::string text = fmt::format("<section id=\"{}\">\n<h2>{}</h2>\n<p>{}</p>\n",
        anchor(section.title), escape(section.title), section.text);
    if (charts && !section.plots.empty()) {
        text += "<div class=\"charts\">\n";
        for (const Plot& plot : section.plots) text += html(plot, folder);
        text += "</div>\n";
    }
    for (const Table& table : section.tables) text += html(table);
    if (!section.wipes.empty()) {
        text += "<div class=\"wipes\">\n";
        for (const Wipe& wipe : section.wipes) text += html(wipe, folder);
        text += "</div>\n";
    }
    return text + "</section>\n";
}

/// Each %NAME% of the template is found once more after the text before it.
std::string filled(
    std::string text, const std::vector<std::pair<std::string, std::string>>& values) {
    for (const auto& [name, value] : values) {
        for (std::size_t at = 0; (at = text.find(name, at)) != std::string::npos;
             at += value.size()) {
            text.replace(at, name.size(), value);
        }
    }
    return text;
}

} // namespace

std::string escape(const std::string& text) {
    std::string result;
    for (const char c : text) {
        switch (c) {
        case '&':
            result += "&amp;";
            break;
        case '<':
            result += "&lt;";
            break;
        case '>':
            result += "&gt;";
            break;
        case '"':
            result += "&quot;";
            break;
        default:
            result += c;
        }
    }
    return result;
}

void write_page(const std::filesystem::path& folder, const std::string& title,
    const std::vector<Section>& sections, const Manifest& manifest) {
    const bool charts = gnuplot_is_installed();
    if (!charts) {
        log::warning("gnuplot is not installed: numbers are written, charts are not; apt-get "
                     "install gnuplot-nox, and run the same command again");
    }
    std::string body, nav, facts;
    for (const Section& section : sections) {
        for (const Plot& plot : section.plots) {
            write_text(folder / (plot.name + ".csv"), csv(plot));
            if (charts) draw(plot, folder / (plot.name + ".svg"));
        }
        for (const Table& table : section.tables)
            write_text(folder / (table.name + ".csv"), csv(table));
        body += html(section, folder, charts);
        nav += fmt::format("<a href=\"#{}\">{}</a>", anchor(section.title), escape(section.title));
    }
    for (const auto& [name, value] : manifest)
        facts += fmt::format("<dt>{}</dt><dd>{}</dd>\n", escape(name), escape(value));
    const std::string summary =
        "Medians; bars reach over the quartiles of the repeats (over all of them where there are "
        "fewer than four). Repeats were taken in turns, so that a busy machine hurts all alike. "
        "The "
        "grey band joins what nothing else beats in both quantities.";
    // Sections last: what they hold is not searched for names.
    write_text(folder / "index.html",
        filled(page_template(), {{"%TITLE%", escape(title)}, {"%SUMMARY%", summary}, {"%NAV%", nav},
                                    {"%MANIFEST%", facts}, {"%SECTIONS%", body}}));
}

} // namespace ockham::chart
