// SPDX-License-Identifier: Apache-2.0
#include "framework/core/error.hpp"
#include "framework/core/params.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>

namespace ockham {
namespace {

/// One parameter of each kind.
struct Values {
    bool flag = false;
    bool toggle = true;
    int count = 4;
    std::uint64_t seed = 7;
    float weight = 0.5f;
    std::string name = "none";
    std::vector<std::string> files;
};

class ParamsTest : public testing::Test {
protected:
    ParamsTest() {
        params.add("flag", &values.flag, "a flag");
        params.add("toggle", &values.toggle, "on or off").on_off();
        params.add("count", &values.count, "a number").range(1, 8);
        params.add("seed", &values.seed, "a seed");
        params.add("weight", &values.weight, "a weight").range(0, INFINITY);
        params.add("name", &values.name, "a choice").choices({"none", "all"});
        params.add("files", &values.files, "a list");
        params.add("out", &out, "an output").transient();
    }

    std::string error_of(const std::string& param, const std::string& text) {
        try {
            params.find(param)->set(text);
        } catch (const Error& error) {
            EXPECT_EQ(error.exit_code(), 2);
            return error.what();
        }
        return "";
    }

    Values values;
    std::string out;
    Params params;
};

TEST_F(ParamsTest, stores_what_it_parses) {
    params.find("flag")->set("on");
    params.find("toggle")->set("off");
    params.find("count")->set("8");
    params.find("seed")->set("18446744073709551615");
    params.find("weight")->set("inf");
    params.find("name")->set("all");
    params.find("files")->set("a");
    params.find("files")->set("b");
    EXPECT_TRUE(values.flag);
    EXPECT_FALSE(values.toggle);
    EXPECT_EQ(values.count, 8);
    EXPECT_EQ(values.seed, ~std::uint64_t{0});
    EXPECT_TRUE(std::isinf(values.weight));
    EXPECT_EQ(values.name, "all");
    EXPECT_EQ(values.files, (std::vector<std::string>{"a", "b"}));
    EXPECT_TRUE(params.given("count"));
    EXPECT_FALSE(params.given("out"));
}

TEST_F(ParamsTest, errors_name_flag_value_and_what_is_allowed) {
    EXPECT_EQ(error_of("count", "0"), "--count: found '0', expected a whole number from 1 to 8");
    EXPECT_EQ(error_of("count", "9"), "--count: found '9', expected a whole number from 1 to 8");
    EXPECT_EQ(
        error_of("count", "4.5"), "--count: found '4.5', expected a whole number from 1 to 8");
    EXPECT_EQ(error_of("count", ""), "--count: found '', expected a whole number from 1 to 8");
    EXPECT_EQ(error_of("count", "99999999999"),
        "--count: found '99999999999', expected a whole number from 1 to 8");
    EXPECT_EQ(error_of("weight", "-1"), "--weight: found '-1', expected a number of at least 0");
    EXPECT_EQ(error_of("weight", "nan"), "--weight: found 'nan', expected a number of at least 0");
    EXPECT_EQ(error_of("name", "some"), "--name: found 'some', expected one of none, all");
    EXPECT_EQ(error_of("toggle", "maybe"), "--toggle: found 'maybe', expected on or off");
    EXPECT_EQ(values.count, 4) << "a refused value changes nothing";
}

TEST_F(ParamsTest, run_files_round_trip_and_yield_to_the_command_line) {
    params.find("weight")->set("inf");
    params.find("files")->set("a");
    const nlohmann::json json = params.to_json();
    EXPECT_FALSE(json.contains("out")) << "what belongs to one run stays out";

    Values other;
    Params again;
    again.add("count", &other.count, "").range(1, 8);
    again.add("weight", &other.weight, "").range(0, INFINITY);
    again.add("files", &other.files, "");
    again.add("toggle", &other.toggle, "").on_off();
    again.add("flag", &other.flag, "");
    again.add("seed", &other.seed, "");
    again.add("name", &other.name, "");
    again.find("count")->set("2");
    again.from_json(json, "run.json");
    EXPECT_EQ(other.count, 2);
    EXPECT_TRUE(std::isinf(other.weight));
    EXPECT_EQ(other.files, std::vector<std::string>{"a"});
    EXPECT_EQ(other.seed, 7u);
}

TEST_F(ParamsTest, run_files_are_checked) {
    const auto error = [&](const char* text) -> std::string {
        try {
            params.from_json(nlohmann::json::parse(text), "run.json");
        } catch (const Error& e) {
            return e.what();
        }
        return "";
    };
    EXPECT_EQ(error(R"({"cuont": 1})"), "run.json: unknown parameter 'cuont'; --help lists them");
    EXPECT_EQ(error(R"({"out": "x"})"), "run.json: unknown parameter 'out'; --help lists them");
    EXPECT_EQ(error(R"({"count": 12})"),
        "run.json: --count: found '12', expected a whole number from 1 to 8");
    EXPECT_EQ(error(R"({"count": null})"), "run.json: parameter 'count' has a value of type null");
    EXPECT_EQ(error("[1]"), "run.json: expected a JSON object of parameters");
}

} // namespace
} // namespace ockham
