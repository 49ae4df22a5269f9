// SPDX-License-Identifier: Apache-2.0
#include "framework/core/error.hpp"
#include "framework/core/file.hpp"
#include "framework/core/log.hpp"
#include "framework/io/rig.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <string>
#include <vector>

namespace ockham {
namespace {

namespace fs = std::filesystem;

constexpr const char* kRig = R"({
    "camera": {"position": [0, 1, 5], "target": [0, 1, 0], "fov_y_degrees": 65},
    "background": [0.25, 0.5, 1],
    "ambient": [0.125, 0, 0],
    "sun": {"toward": [0, 2, 0], "irradiance": [6.5, 6, 5], "shadow": true},
    "points": [{"position": [1, 2, 3], "intensity": [1, 2, 4], "range": 6},
               {"position": [4, 5, 6], "intensity": [0, 0, 1], "range": 0.5}]
})";

class RigTest : public testing::Test {
protected:
    RigTest() {
        path_ = fs::temp_directory_path() / fmt::format("ockham_rig_{}.json", ::getpid());
        log::set_sink([this](log::Level level, std::string_view text) {
            if (level == log::Level::warning) warnings_.emplace_back(text);
        });
    }
    ~RigTest() override {
        log::set_sink({});
        fs::remove(path_);
    }

    Rig load(const std::string& text) {
        write_text(path_, text);
        return load_rig(path_);
    }

    /// The text of the error that `text` gives, or "loaded".
    std::string refusal(const std::string& text) {
        try {
            load(text);
        } catch (const Error& error) {
            EXPECT_EQ(error.kind(), ErrorKind::input);
            EXPECT_NE(std::string(error.what()).find(path_.string()), std::string::npos)
                << error.what();
            return error.what();
        }
        return "loaded";
    }

    /// kRig with `from` replaced by `to`.
    static std::string changed(const std::string& from, const std::string& to) {
        std::string text = kRig;
        const std::size_t at = text.find(from);
        EXPECT_NE(at, std::string::npos) << from;
        return text.replace(at, from.size(), to);
    }

    fs::path path_;
    std::vector<std::string> warnings_;
};

TEST_F(RigTest, ReadsEveryKey) {
    const Rig rig = load(kRig);
    ASSERT_TRUE(rig.camera && rig.background && rig.ambient);
    EXPECT_EQ(rig.camera->position, glm::vec3(0, 1, 5));
    EXPECT_EQ(rig.camera->forward, glm::vec3(0, 0, -1));
    EXPECT_EQ(rig.camera->up, glm::vec3(0, 1, 0));
    EXPECT_EQ(rig.camera->fov_y_degrees, 65.0f);
    EXPECT_EQ(*rig.background, glm::vec3(0.25f, 0.5f, 1.0f));
    EXPECT_EQ(*rig.ambient, glm::vec3(0.125f, 0.0f, 0.0f));
    ASSERT_EQ(rig.lights.size(), 3u);
    EXPECT_EQ(rig.lights[0].type, LightType::directional);
    EXPECT_EQ(rig.lights[0].direction, glm::vec3(0, -1, 0)) << "light travels away from the sun";
    EXPECT_EQ(rig.lights[0].intensity, glm::vec3(6.5f, 6.0f, 5.0f));
    EXPECT_TRUE(rig.lights[0].casts_shadow);
    EXPECT_EQ(rig.lights[2].type, LightType::point);
    EXPECT_EQ(rig.lights[2].position, glm::vec3(4, 5, 6));
    EXPECT_EQ(rig.lights[2].range, 0.5f);
    EXPECT_EQ(rig.lights[2].window_power, 2.0f);
    EXPECT_EQ(rig.lights[2].softening, 0.1f);
    EXPECT_TRUE(warnings_.empty());
}

TEST_F(RigTest, EveryKeyIsOptional) {
    const Rig rig = load("{}");
    EXPECT_FALSE(rig.camera || rig.background || rig.ambient);
    EXPECT_TRUE(rig.lights.empty());
}

TEST_F(RigTest, UnknownKeysWarn) {
    load(changed("\"shadow\"", "\"shadows\""));
    ASSERT_EQ(warnings_.size(), 1u);
    EXPECT_NE(warnings_[0].find("sun.shadows"), std::string::npos) << warnings_[0];
}

TEST_F(RigTest, RefusalsNameKeyAndValue) {
    struct Case {
        const char* from;
        const char* to;
        const char* expected;
    };
    const Case cases[] = {
        {"\"range\": 6", "\"range\": 0", "points[0].range is 0"},
        {"\"range\": 6", "\"range\": -1", "points[0].range is -1"},
        {"\"range\": 6", "\"range\": \"6\"", "points[0].range is \"6\""},
        {"\"range\": 6", "\"r\": 6", "points[0].range is missing"},
        {"[1, 2, 3]", "[1, 2]", "points[0].position is [1,2]"},
        {"[1, 2, 3]", "[1, 2, 1e300]", "points[0].position is 1e+300"},
        {"[1, 2, 4]", "[1, 2, -4]", "points[0].intensity is -4"},
        {"[0, 2, 0]", "[0, 0, 0]", "sun.toward is [0,0,0]"},
        {"\"shadow\": true", "\"shadow\": 1", "sun.shadow is 1"},
        {"65", "180", "camera.fov_y_degrees is 180"},
        {"65", "0", "camera.fov_y_degrees is 0"},
        {"[0, 1, 0]", "[0, 1, 5]", "camera.target is [0,1,5]"},
        {"[0.25, 0.5, 1]", "3", "background is 3"},
        {"[0.125, 0, 0]", "[null, 0, 0]", "ambient is null"},
        {"{\"position\": [1", "3, {\"position\": [1", "points[0] is 3"},
    };
    for (const Case& one : cases) {
        const std::string text = refusal(changed(one.from, one.to));
        EXPECT_NE(text.find(one.expected), std::string::npos) << one.to << " gave: " << text;
    }
    EXPECT_NE(refusal("[]").find("the rig is []"), std::string::npos);
    EXPECT_NE(refusal("").find("not valid JSON"), std::string::npos);
    EXPECT_NE(refusal("{\"sun\": 1e999}").find("not valid JSON"), std::string::npos);
}

TEST_F(RigTest, MissingFileIsNamed) { EXPECT_THROW(load_rig(path_), Error); }

TEST_F(RigTest, ApplyReplacesWhatItHas) {
    Scene scene;
    scene.cameras.resize(1);
    scene.lights.resize(5);
    scene.ambient = glm::vec3(1.0f);
    apply(load("{\"background\": [0, 0, 1]}"), scene);
    EXPECT_EQ(scene.lights.size(), 5u);
    EXPECT_EQ(scene.cameras.size(), 1u);
    EXPECT_EQ(scene.ambient, glm::vec3(1.0f));
    EXPECT_EQ(scene.background, glm::vec3(0, 0, 1));
    apply(load(kRig), scene);
    EXPECT_EQ(scene.lights.size(), 3u);
    ASSERT_EQ(scene.cameras.size(), 2u);
    EXPECT_EQ(scene.cameras[0].name, "rig");
    EXPECT_EQ(scene.ambient, glm::vec3(0.125f, 0.0f, 0.0f));
}

} // namespace
} // namespace ockham
