// SPDX-License-Identifier: Apache-2.0
#include "framework/core/error.hpp"
#include "framework/core/file.hpp"
#include "framework/scene/iso_material.hpp"
#include "tests/support/file_test.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace ockham {
namespace {

class IsoMaterialTest : public test::FileTest {
protected:
    std::vector<VolumeView::Surface> load(const std::string& text) {
        write_text(file("m.json"), text);
        return load_iso_materials(file("m.json"));
    }
    /// What the error says after the file's name, or "loaded".
    std::string refusal(const std::string& text) {
        const std::string opening =
            fmt::format("cannot load iso material '{}': ", file("m.json").string());
        try {
            load(text);
        } catch (const Error& error) {
            EXPECT_EQ(error.kind(), ErrorKind::input);
            const std::string what = error.what();
            EXPECT_EQ(what.substr(0, opening.size()), opening);
            return what.substr(std::min(what.size(), opening.size()));
        }
        return "loaded";
    }
};

TEST_F(IsoMaterialTest, HasADefaultForEveryKey) {
    const std::vector<VolumeView::Surface> surfaces = load("{}");
    ASSERT_EQ(surfaces.size(), 1u);
    EXPECT_EQ(surfaces[0].opacity, 1.0f);
    const shader::IsoMaterial& m = surfaces[0].material;
    EXPECT_EQ(m.base_color, glm::vec3(0.8f));
    EXPECT_EQ(m.metallic, 0.0f);
    EXPECT_EQ(m.subsurface, 0.0f);
    EXPECT_EQ(m.specular, 0.5f);
    EXPECT_EQ(m.roughness, 0.5f);
    EXPECT_EQ(m.specular_tint, 0.0f);
    EXPECT_EQ(m.anisotropic, 0.0f);
    EXPECT_EQ(m.sheen, 0.0f);
    EXPECT_EQ(m.sheen_tint, 0.5f);
    EXPECT_EQ(m.clearcoat, 0.0f);
    EXPECT_EQ(m.clearcoat_gloss, 1.0f);
}

TEST_F(IsoMaterialTest, ReadsEveryKey) {
    const std::vector<VolumeView::Surface> surfaces = load(R"({"base_color": [0.25, 0.5, 1],
        "opacity": 0.0625, "metallic": 0.125, "subsurface": 0.25, "specular": 0.375,
        "roughness": 0.625, "specular_tint": 0.75, "anisotropic": 0.875, "sheen": 1,
        "sheen_tint": 0.03125, "clearcoat": 0.09375, "clearcoat_gloss": 0.15625})");
    ASSERT_EQ(surfaces.size(), 1u);
    EXPECT_EQ(surfaces[0].opacity, 0.0625f);
    const shader::IsoMaterial& m = surfaces[0].material;
    EXPECT_EQ(m.base_color, glm::vec3(0.25f, 0.5f, 1.0f));
    EXPECT_EQ(m.metallic, 0.125f);
    EXPECT_EQ(m.subsurface, 0.25f);
    EXPECT_EQ(m.specular, 0.375f);
    EXPECT_EQ(m.roughness, 0.625f);
    EXPECT_EQ(m.specular_tint, 0.75f);
    EXPECT_EQ(m.anisotropic, 0.875f);
    EXPECT_EQ(m.sheen, 1.0f);
    EXPECT_EQ(m.sheen_tint, 0.03125f);
    EXPECT_EQ(m.clearcoat, 0.09375f);
    EXPECT_EQ(m.clearcoat_gloss, 0.15625f);
    EXPECT_TRUE(warnings_.empty());
}

TEST_F(IsoMaterialTest, ReadsOneForEachIsovalue) {
    const std::vector<VolumeView::Surface> surfaces =
        load(R"({"surfaces": [{"opacity": 0.25}, {"roughness": 0.125}]})");
    ASSERT_EQ(surfaces.size(), 2u);
    EXPECT_EQ(surfaces[0].opacity, 0.25f);
    EXPECT_EQ(surfaces[0].material.roughness, 0.5f);
    EXPECT_EQ(surfaces[1].opacity, 1.0f);
    EXPECT_EQ(surfaces[1].material.roughness, 0.125f);
}

TEST_F(IsoMaterialTest, WarnsOfUnknownKeys) {
    load(R"({"surfaces": [{"baseColor": [1, 0, 0]}]})");
    ASSERT_EQ(warnings_.size(), 1u);
    EXPECT_NE(
        warnings_[0].find("unknown key 'surfaces[0].baseColor' is ignored"), std::string::npos);
}

TEST_F(IsoMaterialTest, RefusesWhatItCannotUse) {
    for (const auto& [text, expected] : std::vector<std::pair<std::string, std::string>>{
             {"3", "the iso material is 3, expected an object"},
             {R"({"surfaces": {}})", "surfaces is {}, expected an array of objects"},
             {R"({"surfaces": []})", "surfaces is [], expected an array of at least one material"},
             {R"({"roughness": 1.5})", "roughness is 1.5, expected a number from 0 to 1"},
             {R"({"metallic": -1})", "metallic is -1, expected a number from 0 to 1"},
             {R"({"sheen": true})", "sheen is true, expected a number from 0 to 1"},
             {R"({"opacity": 0})", "opacity is 0, expected a number above 0, at most 1"},
             {R"({"base_color": [1, 1]})",
                 "base_color is [1,1], expected three numbers from 0 to 1"},
             {R"({"surfaces": [{}, {"base_color": [0, 2, 0]}]})",
                 "surfaces[1].base_color is 2, expected three numbers from 0 to 1"}})
        EXPECT_EQ(refusal(text), expected);
    EXPECT_EQ(refusal("{").substr(0, 16), "not valid JSON: ");
}

} // namespace
} // namespace ockham
