// SPDX-License-Identifier: Apache-2.0
// What charts are made of: the store that outlives a killed run, turns, spreads, Pareto fronts,
// and SVG, CSV and HTML that other programs can read.
#include "framework/core/error.hpp"
#include "framework/core/file.hpp"
#include "framework/core/log.hpp"
#include "samples/chart/page.hpp"
#include "samples/chart/suite.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <set>

namespace ockham::chart {
namespace {

class ChartTest : public testing::Test {
protected:
    ChartTest() { log::set_level(log::Level::error); }
    ~ChartTest() override {
        log::set_level(log::Level::info);
        std::filesystem::remove_all(folder);
    }

    std::filesystem::path lines() const { return folder / "measured.jsonl"; }

    std::filesystem::path folder =
        std::filesystem::temp_directory_path() / fmt::format("ockham_chart.{}", ::getpid());
};

Job job(const std::string& series, const std::string& setting = "1") {
    return {.suite = "test", .scene = "scene", .series = series, .setting = setting};
}

Repeat repeat(double value) { return {.rows = {{.knob = 2, .values = {{"ms", value}}}}}; }

TEST_F(ChartTest, StoreFindsWhatItKept) {
    {
        Store store(folder);
        store.add(job("a"), repeat(1.25));
        store.add(job("b"), {.rows = {{1, {{"ms", 3}, {"psnr", 40}}}, {2, {{"ms", 4}}}},
                                .pictures = {{"picture", "pictures/x.png"}}});
        store.add(job("a"), repeat(1.5));
    }
    const Store again(folder);
    ASSERT_EQ(again.repeats(job("a")).size(), 2u);
    EXPECT_EQ(again.repeats(job("a"))[1].rows[0].values.at("ms"), 1.5);
    EXPECT_EQ(again.repeats(job("b")).front().pictures.at("picture"), "pictures/x.png");
    EXPECT_TRUE(again.repeats(job("c")).empty());

    const std::vector<Job> jobs{job("b"), job("a")};
    const std::vector<Point> points = points_of(again, jobs);
    ASSERT_EQ(points.size(), 3u) << "two rows of b, one of a";
    EXPECT_EQ(points[1].knob, 2);
    EXPECT_FALSE(points[1].has("psnr"));
    EXPECT_EQ(points[2].values.at("ms"), (std::vector<double>{1.25, 1.5}));
    EXPECT_EQ(points[2]["ms"].median, 1.375);
}

TEST_F(ChartTest, KilledAtAnyByteOfALineTheStoreGoesOnBeforeIt) {
    {
        Store store(folder);
        store.add(job("a"), repeat(1));
        store.add(job("b"), repeat(2));
    }
    const std::string text = read_text(lines());
    const std::size_t first = text.find('\n') + 1;
    for (std::size_t bytes = first; bytes < text.size(); ++bytes) {
        write_text(lines(), text.substr(0, bytes));
        {
            Store store(folder);
            ASSERT_EQ(store.repeats(job("a")).size(), 1u) << bytes;
            ASSERT_TRUE(store.repeats(job("b")).empty()) << bytes;
            store.add(job("b"), repeat(2));
        }
        ASSERT_EQ(read_text(lines()), text) << bytes;
    }
}

TEST_F(ChartTest, TwoRunsDoNotShareAFolder) {
    {
        const Store first(folder);
        try {
            const Store second(folder);
            ADD_FAILURE();
        } catch (const Error& error) {
            EXPECT_NE(std::string(error.what()).find("in use"), std::string::npos) << error.what();
        }
    }
    const Store third(folder); // the first is gone
}

TEST_F(ChartTest, DamageElsewhereIsRefusedByLine) {
    {
        Store store(folder);
        store.add(job("a"), repeat(1));
    }
    const std::string line = read_text(lines());
    for (const std::string damage : {"not JSON\n", "{}\n", "{\"key\": 1, \"rows\": 2}\n"}) {
        write_text(lines(), line + damage + line);
        try {
            Store store(folder);
            ADD_FAILURE() << damage;
        } catch (const Error& error) {
            EXPECT_EQ(error.kind(), ErrorKind::input);
            EXPECT_NE(std::string(error.what()).find("measured.jsonl:2"), std::string::npos)
                << error.what();
        }
    }
}

TEST_F(ChartTest, KeysTellApartWhatNumbersDependOn) {
    const Job one{.suite = "s", .scene = "t", .series = "u", .setting = "v", .inputs = "w"};
    std::set<std::string> keys{one.key()};
    for (std::string Job::*part :
        {&Job::suite, &Job::scene, &Job::series, &Job::setting, &Job::inputs}) {
        Job other = one;
        other.*part += "x";
        keys.insert(other.key());
    }
    Job moved = one; // "s" + "t" and "st" + "" are different jobs
    moved.suite = "st", moved.scene = "";
    keys.insert(moved.key());
    EXPECT_EQ(keys.size(), 7u);
    Job same = one;
    same.command = "other", same.repeats = 9;
    EXPECT_EQ(same.key(), one.key());
}

TEST_F(ChartTest, SpreadsAreQuartilesOrReach) {
    const auto expect = [](const Spread& s, double low, double median, double high) {
        EXPECT_DOUBLE_EQ(s.low, low);
        EXPECT_DOUBLE_EQ(s.median, median);
        EXPECT_DOUBLE_EQ(s.high, high);
    };
    expect(spread({7}), 7, 7, 7);
    expect(spread({3, 1}), 1, 2, 3);
    expect(spread({9, 1, 2}), 1, 2, 9);
    expect(spread({5, 1, 4, 2, 3}), 2, 3, 4);
    expect(spread({1, 2, 3, 4}), 1.75, 2.5, 3.25);
}

/// Measures nothing, but in which order it is asked to.
class FakeSuite : public Suite {
public:
    FakeSuite(std::string& log, std::size_t fail_at = ~std::size_t{0})
        : log_(log), fail_at_(fail_at) {}
    std::string name() const override { return "fake"; }
    std::vector<Job> jobs() override {
        std::vector<Job> all{job("A"), job("B"), job("C"), job("D"), job("E")};
        all[1].repeats = 1;
        all[4].scene = "another";
        return all;
    }
    std::size_t together() const override { return 3; }
    std::unique_ptr<Subject> open(const Job& job) override {
        struct One : Subject {
            FakeSuite* suite;
            std::string series;
            One(FakeSuite* s, std::string text) : suite(s), series(std::move(text)) {}
            std::vector<Row> measure() override {
                if (suite->log_.size() == suite->fail_at_) fail_device("killed");
                suite->log_ += series;
                return repeat(1).rows;
            }
            std::map<std::string, Picture> pictures() override {
                return {{"dot", {.width = 1, .height = 1, .rgb = {1, 2, 3}}}};
            }
        };
        return std::make_unique<One>(this, job.series);
    }
    Section report(const Store&, const std::vector<Point>&) override { return {}; }

private:
    std::string& log_;
    std::size_t fail_at_;
};

ChartOptions three_repeats() {
    ChartOptions options;
    options.repeats = 3;
    options.common.quiet = true;
    return options;
}

bool run_fake(Store& store, std::string& log, std::size_t fail_at = ~std::size_t{0}) {
    Context context(three_repeats());
    std::vector<std::unique_ptr<Suite>> suites;
    suites.push_back(std::make_unique<FakeSuite>(log, fail_at));
    return run_suites(suites, context, store);
}

TEST_F(ChartTest, RepeatsAreTakenInTurnsWithinAScene) {
    std::string log;
    Store store(folder);
    EXPECT_TRUE(run_fake(store, log));
    EXPECT_EQ(log, "ABC"
                   "AC"
                   "AC"
                   "DDD"
                   "EEE");
    const auto& pictures = store.repeats(job("A")).front().pictures;
    ASSERT_TRUE(pictures.contains("dot"));
    EXPECT_TRUE(std::filesystem::exists(folder / pictures.at("dot")));
}

TEST_F(ChartTest, ARunThatStoppedAnywhereEndsWithEachRepeatMeasuredOnce) {
    std::string whole;
    for (std::size_t stop = 0; stop < 13; ++stop) {
        std::filesystem::remove_all(folder);
        std::string log;
        {
            Store store(folder);
            EXPECT_THROW(run_fake(store, log, stop), Error);
        }
        Store store(folder);
        EXPECT_TRUE(run_fake(store, log));
        std::sort(log.begin(), log.end());
        EXPECT_EQ(log, "AAABCCCDDDEEE") << stop;
        log.clear();
        EXPECT_TRUE(run_fake(store, log));
        EXPECT_EQ(log, "") << "all is kept";
    }
}

PlotPoint at(double x, double y, std::string setting = "s") {
    return {.x = {x, x, x},
        .y = {y, y, y},
        .setting = std::move(setting),
        .x_values = {x},
        .y_values = {y}};
}

Plot plot_of(std::vector<Curve> curves) {
    return {.name = "test_plot",
        .question = "What's \"it\" & <why>?",
        .x = {"ms", "time (µs)", true, Better::less},
        .y = {"psnr", "PSNR (dB)", false, Better::more},
        .curves = std::move(curves)};
}

TEST_F(ChartTest, FrontIsWhatNothingElseBeats) {
    Plot plot = plot_of({{.legend = "a", .points = {at(1, 10), at(2, 9), at(3, 20), at(3, 18)}},
        {.legend = "b", .kind = Curve::Kind::dots, .points = {at(2, 15), at(9, 20), at(10, 21)}},
        {.legend = "limit", .kind = Curve::Kind::limit, .points = {at(1, 99)}},
        {.legend = "rests", .points = {at(1, 98)}, .competes = false}});
    const auto front = [&] {
        std::vector<std::pair<double, double>> result;
        for (const PlotPoint& p : pareto_front(plot)) result.emplace_back(p.x.median, p.y.median);
        return result;
    };
    using Points = std::vector<std::pair<double, double>>;
    EXPECT_EQ(front(), (Points{{1, 10}, {2, 15}, {3, 20}, {10, 21}}));
    plot.y.better = Better::less;
    EXPECT_EQ(front(), (Points{{1, 10}, {2, 9}}));
    plot.x.better = Better::more;
    EXPECT_EQ(front(), (Points{{2, 9}, {3, 18}, {9, 20}, {10, 21}}));
    plot.x.better = Better::neither;
    EXPECT_TRUE(front().empty());
}

TEST_F(ChartTest, CsvHasARowForEachPointAndMark) {
    Plot plot = plot_of({{.legend = "a, \"b\"", .points = {at(1, 10), at(2, 9)}}});
    plot.curves[0].points[0].command = "run --x";
    plot.marks = {{.label = "target", .x = 3, .y = {}}};
    EXPECT_EQ(csv(plot),
        "series,setting,ms,ms_low,ms_high,psnr,psnr_low,psnr_high,ms_values,psnr_values,front,"
        "command\n"
        "\"a, \"\"b\"\"\",s,1,1,1,10,10,10,1,10,1,run --x\n"
        "\"a, \"\"b\"\"\",s,2,2,2,9,9,9,2,9,0,\n"
        "target,mark,3,,,,,,,,,\n");
}

/// Empty where each tag of XML is closed in its turn and quotes its attributes; else what is not.
/// HTML's elements without content need no end.
std::string why_malformed(const std::string& text) {
    const std::set<std::string> void_elements{"meta", "img", "input", "br"};
    std::vector<std::string> open;
    for (std::size_t i = 0; (i = text.find('<', i)) != std::string::npos;) {
        if (text.compare(i, 4, "<!--") == 0) {
            i = text.find("-->", i);
            continue;
        }
        std::size_t end = i + 1;
        char quote = 0;
        for (; end < text.size() && (quote != 0 || text[end] != '>'); ++end) {
            if (quote != 0 && text[end] == quote)
                quote = 0;
            else if (quote == 0 && (text[end] == '"' || text[end] == '\''))
                quote = text[end];
            else if (quote == 0 && text[end] == '<')
                return "'<' in the tag at " + text.substr(i, 60);
        }
        if (end == text.size()) return "no end of " + text.substr(i, 60);
        const std::string tag = text.substr(i + 1, end - i - 1);
        const std::string name =
            tag.substr(tag[0] == '/' ? 1 : 0)
                .substr(0, tag.find_first_of(" \n\t/", 1) - (tag[0] == '/' ? 1 : 0));
        i = end + 1;
        if (tag[0] == '?' || tag[0] == '!') continue;
        if (tag[0] == '/') {
            if (open.empty() || open.back() != name)
                return "'" + tag + "' closes '" + (open.empty() ? "" : open.back()) + "'";
            open.pop_back();
        } else if (tag.back() != '/' && !void_elements.contains(name)) {
            open.push_back(name);
            if (name == "script" || name == "style") i = text.find("</" + name, i);
        }
    }
    return open.empty() ? "" : "'" + open.back() + "' stays open";
}

TEST_F(ChartTest, TheCheckOfTagsFindsMistakes) {
    EXPECT_EQ(why_malformed("<a><b c='>'/><img><i>x</i></a>"), "");
    EXPECT_NE(why_malformed("<a><b></a></b>"), "");
    EXPECT_NE(why_malformed("<a>"), "");
    EXPECT_NE(why_malformed("<a <b></b>"), "");
}

TEST_F(ChartTest, DrawsWellFormedSvgWithLegendsAndUnits) {
    std::filesystem::create_directories(folder);
    Plot plot = plot_of({{.legend = "it's <a> & \"b\"", .points = {at(1, 10), at(200, 30)}},
        {.legend = "dots", .kind = Curve::Kind::dots, .points = {at(20, 25), at(0, 1)}},
        {.legend = "a limit", .kind = Curve::Kind::limit, .points = {at(1, 12), at(100, 40)}}});
    plot.marks = {{.label = "here", .x = 20, .y = 20}, {.label = "across", .x = {}, .y = 15}};
    draw(plot, folder / "p.svg");
    const std::string svg = read_text(folder / "p.svg");
    EXPECT_EQ(why_malformed(svg), "");
    for (const char* text : {"it's &lt;a> &amp; \"b\"", "dots", "a limit", "Pareto front", "here",
             "across", "time (µs)", "PSNR (dB)", "What's \"it\" &amp; &lt;why>?"}) {
        EXPECT_NE(svg.find(text), std::string::npos) << text;
    }
}

TEST_F(ChartTest, AxesMayEndBelowSomePoints) {
    Plot plot = plot_of({{.legend = "a", .points = {at(1, 10), at(2, 30), at(3, 999)}}});
    plot.y.most = 20;
    const std::string script = gnuplot_script(plot, "p.svg");
    EXPECT_NE(script.find("\n1 10 "), std::string::npos);
    EXPECT_EQ(script.find("\n2 30 "), std::string::npos) << "beyond the axis";
    plot.y.most.reset();
    EXPECT_NE(gnuplot_script(plot, "p.svg").find("\n2 30 "), std::string::npos);
    EXPECT_EQ(gnuplot_script(plot, "p.svg").find("999"), std::string::npos)
        << "stands for infinite";
}

TEST_F(ChartTest, PageIsOneWellFormedFileThatNeedsNoOther) {
    std::string log;
    Store store(folder);
    ASSERT_TRUE(run_fake(store, log));
    const std::string dot = store.repeats(job("A")).front().pictures.at("dot");
    Section section{.title = "Part <one>",
        .text = "text",
        .plots = {plot_of({{.legend = "a", .points = {at(1, 10)}}})},
        .tables = {{.name = "test_table",
            .title = "T",
            .columns = {"what", "ms"},
            .rows = {{"a & b", "1.5"}, {"</script>", "∞"}}}},
        .wipes = {{.title = "w", .sides = {{"</script>", dot, dot}, {"b", dot}, {"c", dot}}}}};
    write_page(folder, "A \"title\"", {section}, {{"command", "chart --x <y>"}});
    const std::string page = read_text(folder / "index.html");
    EXPECT_EQ(why_malformed(page), "");
    EXPECT_NE(page.find("data:image/svg+xml;base64,PD94bWwg"), std::string::npos) << "<?xml";
    EXPECT_NE(page.find("data:image/png;base64,iVBORw0KGgo"), std::string::npos) << "PNG's start";
    EXPECT_NE(page.find("chart --x &lt;y&gt;"), std::string::npos);
    EXPECT_NE(page.find("<td class=\"number\">1.5</td>"), std::string::npos);
    for (const char* outside : {"http:", "https:", "src=\"pictures", "@import", "url("})
        EXPECT_EQ(page.find(outside), std::string::npos) << outside;
    for (const char* placeholder : {"%TITLE%", "%SUMMARY%", "%NAV%", "%SECTIONS%", "%MANIFEST%"})
        EXPECT_EQ(page.find(placeholder), std::string::npos) << placeholder;
    EXPECT_EQ(read_text(folder / "test_table.csv"), "what,ms\na & b,1.5\n</script>,∞\n");
}

TEST_F(ChartTest, FingerprintsFollowContentNotNames) {
    std::filesystem::create_directories(folder / "scene");
    write_text(folder / "a.glb", "one");
    write_text(folder / "b.glb", "one");
    write_text(folder / "c.glb", "two");
    const auto of = [&](const char* name) { return fingerprint_of((folder / name).string()); };
    EXPECT_EQ(of("a.glb"), of("b.glb"));
    EXPECT_NE(of("a.glb"), of("c.glb"));
    EXPECT_EQ(fingerprint_of("builtin:fence"), "builtin:fence");
    write_text(folder / "scene/s.gltf", "{}");
    const std::string before = of("scene/s.gltf");
    write_text(folder / "scene/s.bin", "buffer");
    EXPECT_NE(of("scene/s.gltf"), before) << "what lies beside a .gltf counts";
    EXPECT_THROW(of("none.glb"), Error);
    EXPECT_EQ(fingerprint(""), "cbf29ce484222325") << "FNV-1a's basis";
    EXPECT_EQ(fingerprint("a"), "af63dc4c8601ec8c");
}

} // namespace
} // namespace ockham::chart
