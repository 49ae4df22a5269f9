// SPDX-License-Identifier: Apache-2.0
// aa_curve as a user runs it: one table with every method and both limits.
#include "framework/core/file.hpp"
#include "tests/support/program_test.hpp"

#include <algorithm>
#include <map>
#include <sstream>

namespace ockham::test {
namespace {

class AaCurveTest : public ProgramTest {
protected:
    AaCurveTest() : ProgramTest("aa_curve") {}
};

TEST_F(AaCurveTest, OneTableHasEveryMethodAndBothLimits) {
    const Result result =
        run("builtin:fence --width 32 --height 24 --m 2 --repeats 1 --quiet --out t.csv");
    ASSERT_EQ(result.exit_code, 0) << result.text;
    std::istringstream lines(read_text(folder / "t.csv"));
    std::string line;
    ASSERT_TRUE(std::getline(lines, line));
    EXPECT_EQ(line.find("method,knob,m,samples_percent,shading_gpu_ms,total_gpu_ms,mse,psnr,ssim,"
                        "flip"),
        0u);
    const auto columns = std::count(line.begin(), line.end(), ',');
    std::map<std::string, int> rows;
    while (std::getline(lines, line)) {
        EXPECT_EQ(std::count(line.begin(), line.end(), ','), columns) << line;
        const std::string method = line.substr(0, line.find(','));
        ++rows[method];
        double knob = 0, m = 0, percent = 0;
        ASSERT_EQ(std::sscanf(line.c_str() + method.size(), ",%lf,%lf,%lf", &knob, &m, &percent), 3)
            << line;
        EXPECT_EQ(m, 2) << line;
        EXPECT_TRUE(percent >= 25 && percent <= 100) << line;
        if (method == "ssaa") {
            EXPECT_NE(line.find(",999.000,"), std::string::npos) << line;
        }
    }
    for (const char* method : {"none", "fxaa", "smaa", "sraa", "msaa", "cluster", "ssaa"})
        EXPECT_EQ(rows[method], 1) << method;
    EXPECT_EQ(rows["uniform"], 3) << "k = 1, 2, 3";
    for (const char* method : {"paper", "ockham", "limit_variance", "limit_clairvoyant"})
        EXPECT_GE(rows[method], 5) << method;
}

TEST_F(AaCurveTest, RefusesWhatItCannotWrite) {
    expect_error("builtin:plane --out no/such/folder/t.csv", 2, {"no/such/folder"});
    expect_error("builtin:plane --m 9", 2, {"--m", "9"});
}

} // namespace
} // namespace ockham::test
