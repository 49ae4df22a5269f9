// SPDX-License-Identifier: Apache-2.0
// Names of numbered outputs, and the small parsers of the command line.
#include "framework/app/headless.hpp"
#include "framework/core/error.hpp"

#include <gtest/gtest.h>

namespace ockham {
namespace {

TEST(Numbered, FillsTheField) {
    EXPECT_EQ(numbered("a/out%04d.png", 7), "a/out0007.png");
    EXPECT_EQ(numbered("out%d.exr", 12), "out12.exr");
    EXPECT_EQ(numbered("out%02d.exr", 123), "out123.exr");
    for (const char* plain : {"out.png", "100%.png", "50%4d.png", "%0d.png", "%s%"}) {
        EXPECT_EQ(numbered(plain, 3), plain);
        EXPECT_FALSE(is_numbered(plain)) << plain;
    }
    EXPECT_EQ(numbered("5%_%03d.png", 1), "5%_001.png");
    EXPECT_TRUE(is_numbered("x%d"));
}

TEST(ParseNumbers, TakesAllOrNothing) {
    EXPECT_EQ(parse_numbers("1,-2.5,3e2"), (std::vector<float>{1.0f, -2.5f, 300.0f}));
    for (const char* bad : {"", "1,,2", "1,x", "1 ", "nan", "1,inf"}) {
        EXPECT_TRUE(parse_numbers(bad).empty()) << bad;
    }
}

TEST(ParseColor, NamesTheFlag) {
    EXPECT_EQ(parse_color("environment", "0,0.5,2"), glm::vec3(0, 0.5f, 2));
    for (const char* bad : {"1,2", "1,2,3,4", "1,-1,1", "red"}) {
        try {
            parse_color("environment", bad);
            ADD_FAILURE() << bad;
        } catch (const Error& error) {
            EXPECT_NE(std::string(error.what()).find("--environment: found '" + std::string(bad)),
                std::string::npos)
                << error.what();
        }
    }
}

TEST(ParseCamera, HasPositionTargetAndAngle) {
    const std::optional<Camera> camera = parse_camera("0,-2,0 0,0,0 40", UpAxis::z);
    ASSERT_TRUE(camera.has_value());
    EXPECT_EQ(camera->forward, glm::vec3(0, 1, 0));
    EXPECT_EQ(camera->up, glm::vec3(0, 0, 1));
    EXPECT_EQ(camera->fov_y_degrees, 40.0f);
    EXPECT_FALSE(parse_camera("front", UpAxis::z).has_value());
    EXPECT_FALSE(parse_camera("0,-2,0 0,0,0", UpAxis::z).has_value());
    EXPECT_THROW(parse_camera("1,1,1 1,1,1 40", UpAxis::z), Error);
    EXPECT_THROW(parse_camera("1,1,1 1,1,0 180", UpAxis::z), Error);
}

} // namespace
} // namespace ockham
