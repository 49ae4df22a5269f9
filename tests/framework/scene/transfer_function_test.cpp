// SPDX-License-Identifier: Apache-2.0
#include "framework/core/error.hpp"
#include "framework/core/file.hpp"
#include "framework/core/rng.hpp"
#include "framework/scene/builtin_volume.hpp"
#include "framework/scene/histogram.hpp"
#include "framework/scene/transfer_function.hpp"
#include "tests/support/file_test.hpp"
#include "tests/support/volume_row.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace ockham {
namespace {

using test::row_of;

Volume hounsfield() { return row_of<std::int16_t>(VoxelType::int16, {-1000, 40, 3000}); }

/// Most of it 0, as scans are, then `matter`.
Volume scan_of(std::vector<std::uint8_t> matter) {
    matter.resize(matter.size() * 4, 0);
    return row_of(VoxelType::uint8, matter);
}

TEST(TransferFunctionTest, IsLinearBetweenPoints) {
    const TransferFunction function{
        {{10, 0.0, {1, 0, 0}, {0, 0, 0}}, {20, 0.5, {0, 1, 0}, {2, 4, 8}}, {40, 0.25}}};
    const TransferPoint point = function.at(12.5);
    EXPECT_EQ(point.value, 12.5);
    EXPECT_EQ(point.opacity, 0.125);
    EXPECT_EQ(point.color, glm::dvec3(0.75, 0.25, 0));
    EXPECT_EQ(point.emission, glm::dvec3(0.5, 1, 2));
    EXPECT_EQ(function.at(20).opacity, 0.5);
    EXPECT_EQ(function.at(30).opacity, 0.375);
}

TEST(TransferFunctionTest, HoldsItsEndsBeyondThem) {
    const TransferFunction function{{{10, 0.25}, {20, 0.5}}};
    EXPECT_EQ(function.at(-1e30).opacity, 0.25);
    EXPECT_EQ(function.at(9.99).opacity, 0.25);
    EXPECT_EQ(function.at(1e30).opacity, 0.5);
}

TEST(TransferFunctionTest, StepsWhereTwoPointsShareAValue) {
    const TransferFunction function{{{10, 0.25}, {20, 0.5}, {20, 1.0}, {30, 0.0}}};
    EXPECT_LT(function.at(std::nextafter(20, 0)).opacity, 0.5);
    EXPECT_EQ(function.at(20).opacity, 1.0);
    EXPECT_EQ(function.at(25).opacity, 0.5);
}

TEST(TransferFunctionTest, KnowsWhetherItEmits) {
    EXPECT_FALSE((TransferFunction{{{0, 1.0}}}).emits());
    EXPECT_TRUE((TransferFunction{{{0, 1.0}, {1, 1.0, {1, 1, 1}, {0, 0, 0.5}}}}).emits());
}

TEST(TransferFunctionTest, IsEmptyUpToTheThresholdByDefault) {
    // 0, dark matter around 11, bright matter 21 and two spots of 200 in 999 voxels.
    std::vector<std::uint8_t> values(600, 0);
    for (int i = 0; i < 397; ++i) values.push_back(static_cast<std::uint8_t>(i % 2 ? 11 : 21));
    values.push_back(200), values.push_back(200);
    const Volume volume = row_of(VoxelType::uint8, values);
    const TransferFunction function = default_transfer(volume);
    ASSERT_EQ(function.points.size(), 2u);
    EXPECT_EQ(function.points[0].value, otsu_threshold(histogram(volume)));
    EXPECT_EQ(function.at(0).opacity, 0);
    EXPECT_EQ(function.at(function.points[0].value).opacity, 0);
    EXPECT_EQ(function.points[1].opacity, 1);
    EXPECT_EQ(function.points[1].color, glm::dvec3(1));
    EXPECT_FALSE(function.emits());
}

TEST(TransferFunctionTest, IsFullFromThePercentileOnByDefault) {
    std::vector<std::uint8_t> values;
    for (int i = 0; i < 250; ++i) values.insert(values.end(), 4, static_cast<std::uint8_t>(i));
    const TransferFunction function = default_transfer(row_of(VoxelType::uint8, values));
    EXPECT_EQ(function.points[1].value, 248); // of 1000, 995 do not exceed it
    EXPECT_EQ(function.at(248).opacity, 1);
    const double middle = 0.5 * (function.points[0].value + 248);
    EXPECT_EQ(function.at(middle).opacity, 0.5);
}

TEST(TransferFunctionTest, IsFullAtTheHighestWhereMatterIsSparse) {
    std::vector<float> values(10000, 0.0f);
    values[7] = 1.0f, values[8] = 2.0f;
    const TransferFunction function = default_transfer(row_of(VoxelType::float32, values));
    EXPECT_GT(function.points[0].value, 1.0);
    EXPECT_LT(function.points[0].value, 2.0);
    EXPECT_EQ(function.points[1].value, 2.0);
}

TEST(TransferFunctionTest, OfAConstantIsAllOrNothingByDefault) {
    EXPECT_EQ(default_transfer(builtin_volume("builtin:constant", 4)).at(1).opacity, 1);
    EXPECT_EQ(default_transfer(row_of<float>(VoxelType::float32, {0, 0})).at(0).opacity, 0);
    EXPECT_EQ(default_transfer(row_of<float>(VoxelType::float32, {-5, -5})).at(-5).opacity, 0);
}

TEST(TransferFunctionTest, OfTheCloudLeavesTheEmptySpaceEmpty) {
    const Volume cloud = builtin_volume("builtin:cloud", 64);
    EXPECT_EQ(default_transfer(cloud).at(0).opacity, 0);
    EXPECT_EQ(preset_transfer("smoke", cloud).at(0).opacity, 0);
    EXPECT_EQ(preset_transfer("mri", cloud).at(0).opacity, 0);
}

TEST(TransferFunctionTest, PresetsAreSound) {
    const Volume volume = scan_of({20, 21, 22, 80, 81, 82, 150, 200});
    for (const char* name : {"ct-bone", "ct-soft", "mri", "smoke"}) {
        const TransferFunction function = preset_transfer(name, volume);
        double value = -1e30;
        for (const TransferPoint& point : function.points) {
            EXPECT_GT(point.value, value) << name;
            value = point.value;
            EXPECT_GE(point.opacity, 0) << name;
            EXPECT_LE(point.opacity, 1) << name;
            for (int c = 0; c < 3; ++c) {
                EXPECT_GE(point.color[c], 0) << name;
                EXPECT_LE(point.color[c], 1) << name;
            }
        }
        EXPECT_EQ(function.points.front().opacity, 0) << name;
        EXPECT_EQ(function.points.back().opacity, 1) << name;
    }
}

TEST(TransferFunctionTest, PresetsForCtKnowTheirTissues) {
    const TransferFunction bone = preset_transfer("ct-bone", hounsfield());
    EXPECT_EQ(bone.at(-1000).opacity, 0); // air
    EXPECT_EQ(bone.at(60).opacity, 0);    // muscle
    EXPECT_GT(bone.at(700).opacity, 0.5);
    const TransferFunction soft = preset_transfer("ct-soft", hounsfield());
    EXPECT_EQ(soft.at(-1000).opacity, 0);
    EXPECT_EQ(soft.at(-700).opacity, 0); // lung
    EXPECT_GT(soft.at(-90).opacity, 0);  // fat
    EXPECT_GT(soft.at(50).opacity, 2 * soft.at(-90).opacity);
    EXPECT_GT(soft.at(500).opacity, 2 * soft.at(50).opacity);
    EXPECT_GT(soft.at(50).color.r, 1.5 * soft.at(50).color.g); // muscle is red
}

TEST(TransferFunctionTest, RefusesOtherPresets) {
    try {
        preset_transfer("bone", hounsfield());
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::input);
        EXPECT_STREQ(
            error.what(), "no transfer function 'bone': presets are ct-bone, ct-soft, mri, smoke");
    }
}

TEST(TransferFunctionTest, WindowRisesAroundItsLevel) {
    const TransferFunction window = window_transfer(40, 80);
    EXPECT_EQ(window.at(0).opacity, 0);
    EXPECT_EQ(window.at(20).opacity, 0.25);
    EXPECT_EQ(window.at(80).opacity, 1);
    const TransferFunction step = window_transfer(40, 0);
    EXPECT_EQ(step.at(39.999).opacity, 0);
    EXPECT_EQ(step.at(40).opacity, 1);
}

class TransferFileTest : public test::FileTest {
protected:
    TransferFunction load(const std::string& text) {
        write_text(file("a.json"), text);
        return load_transfer(file("a.json"));
    }
    /// What the error says after the file's name, or "loaded".
    std::string refusal(const std::string& text) {
        const std::string opening =
            fmt::format("cannot load transfer function '{}': ", file("a.json").string());
        try {
            load(text);
        } catch (const Error& error) {
            const std::string what = error.what();
            EXPECT_EQ(what.substr(0, opening.size()), opening);
            return what.substr(std::min(what.size(), opening.size()));
        }
        return "loaded";
    }
};

TEST_F(TransferFileTest, ReadsEveryKey) {
    const TransferFunction function = load(R"({"points": [
        {"value": -100, "opacity": 0},
        {"value": 50, "opacity": 0.25, "color": [1, 0.5, 0.25], "emission": [0, 2, 16]}]})");
    ASSERT_EQ(function.points.size(), 2u);
    EXPECT_EQ(function.points[0].value, -100);
    EXPECT_EQ(function.points[0].opacity, 0);
    EXPECT_EQ(function.points[0].color, glm::dvec3(1));
    EXPECT_EQ(function.points[0].emission, glm::dvec3(0));
    EXPECT_EQ(function.points[1].opacity, 0.25);
    EXPECT_EQ(function.points[1].color, glm::dvec3(1, 0.5, 0.25));
    EXPECT_EQ(function.points[1].emission, glm::dvec3(0, 2, 16));
    EXPECT_TRUE(warnings_.empty());
}

TEST_F(TransferFileTest, ClampsToTheDomain) {
    const TransferFunction function = load(R"({"domain": [5, 25], "points": [
        {"value": 0, "opacity": 0}, {"value": 10, "opacity": 1},
        {"value": 20, "opacity": 1}, {"value": 30, "opacity": 0}]})");
    EXPECT_EQ(function.at(0).opacity, 0.5);
    EXPECT_EQ(function.at(5).opacity, 0.5);
    EXPECT_EQ(function.at(7.5).opacity, 0.75);
    EXPECT_EQ(function.at(15).opacity, 1);
    EXPECT_EQ(function.at(25).opacity, 0.5);
    EXPECT_EQ(function.at(40).opacity, 0.5);
}

TEST_F(TransferFileTest, TakesDomainsWithoutPointsInside) {
    const TransferFunction between = load(R"({"domain": [4, 6], "points": [
        {"value": 0, "opacity": 0}, {"value": 10, "opacity": 1}]})");
    EXPECT_EQ(between.at(0).opacity, 0.4);
    EXPECT_EQ(between.at(5).opacity, 0.5);
    EXPECT_EQ(between.at(9).opacity, 0.6);
    const TransferFunction beyond =
        load(R"({"domain": [20, 30], "points": [{"value": 10, "opacity": 0.75}]})");
    EXPECT_EQ(beyond.at(25).opacity, 0.75);
}

TEST_F(TransferFileTest, WarnsOfUnknownKeys) {
    load(R"({"name": "x", "points": [{"value": 0, "opacity": 1, "colour": [1, 0, 0]}]})");
    ASSERT_EQ(warnings_.size(), 2u);
    EXPECT_NE(warnings_[0].find("unknown key 'name' is ignored"), std::string::npos);
    EXPECT_NE(warnings_[1].find("unknown key 'points[0].colour' is ignored"), std::string::npos);
}

TEST_F(TransferFileTest, RefusesWhatItCannotUse) {
    EXPECT_EQ(refusal("[]"), "the transfer function is [], expected an object");
    EXPECT_EQ(refusal("{").substr(0, 16), "not valid JSON: ");
    EXPECT_EQ(refusal("{}"), "points is missing");
    EXPECT_EQ(refusal(R"({"points": 7})"), "points is 7, expected an array of objects");
    EXPECT_EQ(refusal(R"({"points": []})"), "points is [], expected at least one point");
    EXPECT_EQ(refusal(R"({"points": [3]})"), "points[0] is 3, expected an object");
    const std::string good = R"({"value": 5, "opacity": 1})";
    for (const auto& [point, text] : std::vector<std::pair<std::string, std::string>>{
             {R"({"opacity": 1})", "points[1].value is missing"},
             {R"({"value": 5})", "points[1].opacity is missing"},
             {R"({"value": "5", "opacity": 1})", "points[1].value is \"5\", expected a number"},
             {R"({"value": 1e300, "opacity": 1})", "points[1].value is 1e+300, expected a number"},
             {R"({"value": 4, "opacity": 1})",
                 "points[1].value is 4, expected at least that of the point before"},
             {R"({"value": 5, "opacity": 1.5})",
                 "points[1].opacity is 1.5, expected a number from 0 to 1"},
             {R"({"value": 5, "opacity": -0.1})",
                 "points[1].opacity is -0.1, expected a number from 0 to 1"},
             {R"({"value": 5, "opacity": 1, "color": [1, 2, 0]})",
                 "points[1].color is 2, expected three numbers from 0 to 1"},
             {R"({"value": 5, "opacity": 1, "color": "red"})",
                 "points[1].color is \"red\", expected three numbers from 0 to 1"},
             {R"({"value": 5, "opacity": 1, "emission": [1, 2]})",
                 "points[1].emission is [1,2], expected three numbers of at least 0"},
             {R"({"value": 5, "opacity": 1, "emission": [1, 2, -1]})",
                 "points[1].emission is -1, expected three numbers of at least 0"}})
        EXPECT_EQ(refusal("{\"points\": [" + good + ", " + point + "]}"), text);
    const std::string points = "\"points\": [" + good + "]}";
    EXPECT_EQ(refusal("{\"domain\": [1], " + points), "domain is [1], expected two numbers");
    EXPECT_EQ(refusal("{\"domain\": [1, null], " + points), "domain is null, expected two numbers");
    EXPECT_EQ(refusal("{\"domain\": [9, 9], " + points),
        "domain is [9,9], expected a lower and a higher number");
}

TEST_F(TransferFileTest, NamesAMissingFile) {
    try {
        load_transfer(file("none.json"));
        FAIL();
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("none.json"), std::string::npos);
    }
}

/// The table's opacity at a data value, as kernels look it up.
double look_up(const TransferTable& table, double value) {
    const double last = double(table.entries.size() - 1);
    const double x =
        std::clamp((value - table.first) / (table.last - table.first) * last, 0.0, last);
    const std::size_t entry = std::min(static_cast<std::size_t>(x), table.entries.size() - 2);
    const double t = x - double(entry);
    return table.entries[entry].w * (1 - t) + table.entries[entry + 1].w * t;
}

TEST(TransferTableTest, HasAnEntryForEachCode) {
    Volume volume = row_of<std::int16_t>(VoxelType::int16, {-1000, 3095});
    volume.value_scale = 0.1, volume.value_offset = 3;
    const TransferFunction spike{{{56.9, 0.0}, {57.0, 0.75}, {57.1, 0.0}}}; // code 540
    const TransferTable table = tabulate(spike, volume);
    ASSERT_EQ(table.entries.size(), 4096u);
    EXPECT_EQ(table.first, volume.at({0, 0, 0}));
    EXPECT_EQ(table.last, volume.at({1, 0, 0}));
    for (std::size_t i = 0; i < table.entries.size(); ++i)
        EXPECT_NEAR(table.entries[i].w, i == 1540 ? 0.75 : 0.0, 1e-6) << i;
    EXPECT_TRUE(table.emission.empty());
}

TEST(TransferTableTest, KeepsAStepOneCodeWide) {
    std::vector<std::uint8_t> values(256);
    for (std::size_t i = 0; i < 256; ++i) values[i] = static_cast<std::uint8_t>(i);
    const TransferFunction box{{{99.5, 0.0}, {99.5, 1.0}, {100.5, 1.0}, {100.5, 0.0}}};
    const TransferTable table = tabulate(box, row_of(VoxelType::uint8, values));
    ASSERT_EQ(table.entries.size(), 256u);
    for (std::size_t i = 0; i < 256; ++i) EXPECT_EQ(table.entries[i].w, i == 100 ? 1.0f : 0.0f);
}

TEST(TransferTableTest, HasAllEntriesOverTheValuesThatOccurOtherwise) {
    const TransferFunction ramp{{{-1, 0.0, {0, 0, 0}, {3, 0, 0}}, {3, 1.0, {1, 0.5, 0}}}};
    for (const Volume& volume : {row_of<float>(VoxelType::float32, {0, 2}),
             row_of<std::uint16_t>(VoxelType::uint16, {0, 60000})}) {
        const TransferTable table = tabulate(ramp, volume);
        ASSERT_EQ(table.entries.size(), 4096u);
        ASSERT_EQ(table.emission.size(), 4096u);
        for (std::size_t i = 0; i < 4096; i += 17) {
            const TransferPoint point =
                ramp.at(table.first + (table.last - table.first) * double(i) / 4095);
            EXPECT_EQ(table.entries[i], glm::vec4(point.color, point.opacity));
            EXPECT_EQ(table.emission[i], glm::vec3(point.emission));
        }
        EXPECT_EQ(table.entries.back().w, float(ramp.at(table.last).opacity));
    }
}

TEST(TransferTableTest, IsNotSpreadByAStrayVoxel) {
    const TransferFunction ramp{{{1, 0.0}, {1, 0.25}, {3, 1.0}}};
    const Volume volume = row_of<float>(VoxelType::float32, {-3e38f, 0, 2, 4});
    const TransferTable table = tabulate(ramp, volume);
    EXPECT_EQ(table.entries.size(), 4096u);
    EXPECT_NEAR(table.first, 1, 1e-3);
    EXPECT_NEAR(table.last, 3, 1e-3);
    EXPECT_EQ(look_up(table, -3e38), 0) << "below a step";
    EXPECT_NEAR(look_up(table, 2), 0.625, 1e-3);
    EXPECT_EQ(look_up(table, 4), 1);
}

TEST(TransferTableTest, OfAConstantHasTwoEqualEntries) {
    const TransferFunction ramp{{{0, 0.0}, {4, 1.0}}};
    for (const Volume& volume : {row_of<float>(VoxelType::float32, {1, 1}),
             row_of<std::uint8_t>(VoxelType::uint8, {1, 1, 1})}) {
        const TransferTable table = tabulate(ramp, volume);
        ASSERT_EQ(table.entries.size(), 2u);
        EXPECT_EQ(table.first, 1);
        EXPECT_GT(float(table.last), float(table.first));
        EXPECT_EQ(table.entries[0].w, 0.25f);
        EXPECT_EQ(table.entries[1].w, 0.25f);
    }
}

TEST(TransferTableTest, FindsTheGreatestOpacityOfAnInterval) {
    Pcg32 random(3);
    TransferTable table{-2, 5, {}, {}};
    for (int i = 0; i < 23; ++i) table.entries.push_back(glm::vec4(1, 1, 1, random.uniform()));
    for (int trial = 0; trial < 300; ++trial) {
        const double a = random.uniform(-3, 6), b = random.uniform(-3, 6);
        const double low = std::min(a, b), high = std::max(a, b);
        // Piecewise linear: the ends and the entries between them are enough.
        double expected = std::max(look_up(table, low), look_up(table, high));
        for (std::size_t i = 0; i < 23; ++i) {
            const double value = -2 + 7 * double(i) / 22;
            if (value >= low && value <= high)
                expected = std::max(expected, double(table.entries[i].w));
        }
        EXPECT_NEAR(table.max_opacity(a, b), expected, 1e-6) << low << ' ' << high;
        for (int i = 0; i <= 50; ++i)
            EXPECT_GE(table.max_opacity(a, b) + 1e-6, look_up(table, low + (high - low) * i / 50));
    }
    EXPECT_EQ(table.max_opacity(-2, -2), table.entries[0].w);
    EXPECT_EQ(table.max_opacity(9, 8), table.entries[22].w);
    EXPECT_EQ(table.max_opacity(-2, 5),
        std::max_element(table.entries.begin(), table.entries.end(),
            [](const glm::vec4& l, const glm::vec4& r) { return l.w < r.w; })
            ->w);
}

} // namespace
} // namespace ockham
