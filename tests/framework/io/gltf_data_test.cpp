// SPDX-License-Identifier: Apache-2.0
// Real scenes, and the test suite of Khronos' glTF-Validator with its reports. Registered only
// where OCKHAM_DATA_DIR is set; gltf_test has generated equivalents.
#include "framework/core/error.hpp"
#include "framework/core/file.hpp"
#include "framework/core/log.hpp"
#include "framework/io/gltf.hpp"
#include "framework/io/rig.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace ockham {
namespace {

namespace fs = std::filesystem;

const fs::path kData = OCKHAM_DATA_DIR;

/// Error codes of the validator that make a read of the loader undefined, or leave it nothing to
/// read. A file that has one of them must be refused, if it is in a part that the loader reads.
const std::set<std::string> kFatalCodes{
    "ACCESSOR_INDEX_OOB",
    "ACCESSOR_SMALL_BYTESTRIDE",
    "ACCESSOR_SPARSE_COUNT_OUT_OF_RANGE",
    "ACCESSOR_TOO_LONG",
    "ARRAY_TYPE_MISMATCH",
    "BUFFER_BYTE_LENGTH_MISMATCH",
    "BUFFER_MISSING_GLB_DATA",
    "BUFFER_VIEW_TOO_LONG",
    "GLB_CHUNK_LENGTH_UNALIGNED",
    "GLB_CHUNK_TOO_BIG",
    "GLB_DUPLICATE_CHUNK",
    "GLB_EMPTY_CHUNK",
    "GLB_INVALID_MAGIC",
    "GLB_INVALID_VERSION",
    "GLB_LENGTH_MISMATCH",
    "GLB_LENGTH_TOO_SMALL",
    "GLB_UNEXPECTED_BIN_CHUNK",
    "GLB_UNEXPECTED_END_OF_CHUNK_DATA",
    "GLB_UNEXPECTED_END_OF_CHUNK_HEADER",
    "GLB_UNEXPECTED_END_OF_HEADER",
    "GLB_UNEXPECTED_FIRST_CHUNK",
    "MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_INVALID_FORMAT",
    "MESH_PRIMITIVE_INDICES_ACCESSOR_INVALID_FORMAT",
    "MESH_PRIMITIVE_UNEQUAL_ACCESSOR_COUNT",
    "NODE_LOOP",
    "NODE_PARENT_OVERRIDE",
    "TYPE_MISMATCH",
    "UNDEFINED_PROPERTY",
    "UNKNOWN_ASSET_MAJOR_VERSION",
    "UNRESOLVED_REFERENCE",
    "UNUSED_EXTENSION_REQUIRED",
    "VALUE_MULTIPLE_OF",
};

/// Files on which --strict and the validator disagree, with the reason. At most 10.
const std::map<std::string, std::string> kVerdictsThatDiffer{};

/// Parts of a file that the loader never reads, as in a report's "/animations/0/...".
bool is_unread(const std::string& pointer) {
    for (const char* part : {"/animations", "/skins", "/skin", "/targets/", "/extensions/EXT_",
             "/extensions/KHR_materials_variants", "/extensions/KHR_invalid"}) {
        if (pointer.find(part) != std::string::npos) return true;
    }
    return false;
}

/// A finding of the report for which the file must be refused, or nothing.
std::string fatal_finding(const nlohmann::json& report) {
    for (const nlohmann::json& message : report["issues"]["messages"]) {
        const auto code = message["code"].get<std::string>();
        const auto pointer = message.value("pointer", std::string());
        if (message["severity"] != 0 || !kFatalCodes.contains(code) || is_unread(pointer)) continue;
        return code + " at " + pointer;
    }
    return "";
}

struct Quiet {
    Quiet() {
        log::set_sink([](log::Level, std::string_view) {});
    }
    ~Quiet() { log::set_sink({}); }
};

/// What later stages rely on.
void expect_sound(const Scene& scene) {
    for (const Mesh& mesh : scene.meshes) {
        for (const Primitive& primitive : mesh.primitives) {
            const std::size_t vertices = primitive.positions.size();
            ASSERT_EQ(primitive.normals.size(), vertices);
            ASSERT_LT(
                *std::max_element(primitive.indices.begin(), primitive.indices.end()), vertices);
            for (const glm::vec3& normal : primitive.normals) {
                ASSERT_NEAR(glm::length(normal), 1.0f, 1e-5f);
            }
            const Material& material = scene.materials.at(primitive.material);
            if (material.normal_texture.used()) {
                ASSERT_EQ(primitive.tangents.size(), vertices);
            }
            for (std::size_t i = 0; i < primitive.tangents.size(); ++i) {
                const glm::vec3 tangent(primitive.tangents[i]);
                ASSERT_NEAR(glm::length(tangent), 1.0f, 1e-5f);
                ASSERT_EQ(std::abs(primitive.tangents[i].w), 1.0f);
            }
            for (const TextureUse* use : {&material.base_color_texture, &material.normal_texture}) {
                if (use->used()) {
                    ASSERT_EQ(primitive.uvs[use->uv_set].size(), vertices);
                }
            }
        }
    }
}

/// The error that loading gives, or nothing. Other exceptions end the test.
std::string refusal(const fs::path& path, const GltfOptions& options = {}) {
    try {
        expect_sound(load_gltf(path, options));
    } catch (const Error& error) {
        return error.what();
    }
    return "";
}

TEST(GltfValidatorSuite, VerdictsEqualTheReports) {
    const Quiet quiet;
    const fs::path corpus = kData / "corpora/gltf-validator";
    int files = 0, valid = 0, refused = 0, valid_refused = 0, false_rejects = 0, false_accepts = 0;
    std::set<std::string> different;
    const auto start = std::chrono::steady_clock::now();
    for (const auto& entry : fs::recursive_directory_iterator(corpus)) {
        const fs::path& path = entry.path();
        if (path.extension() != ".gltf" && path.extension() != ".glb") continue;
        ++files;
        const auto report = nlohmann::json::parse(read_text(path.string() + ".report.json"));
        const bool is_valid = report["issues"]["numErrors"] == 0;
        const std::string text = refusal(path);
        const std::string strict_text = refusal(path, {.strict = true});
        const std::string name = fs::relative(path, corpus).string();
        valid += is_valid;
        refused += !text.empty();
        valid_refused += is_valid && !text.empty();
        EXPECT_FALSE(is_valid && !text.empty()) << "refused, but valid: " << name << ": " << text;
        EXPECT_TRUE(text.empty() || !strict_text.empty()) << "strict is laxer: " << name;
        const std::string fatal = fatal_finding(report);
        EXPECT_TRUE(fatal.empty() || !text.empty()) << name << " loaded, but has " << fatal;
        if (is_valid == strict_text.empty()) continue;
        different.insert(name);
        (is_valid ? false_rejects : false_accepts) += 1;
        EXPECT_TRUE(kVerdictsThatDiffer.contains(name))
            << name << (is_valid ? ": valid, but " + strict_text : ": invalid, but accepted: ")
            << (is_valid ? "" : report["issues"]["messages"].dump());
    }
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    EXPECT_EQ(files, 372);
    EXPECT_LE(kVerdictsThatDiffer.size(), 10u);
    for (const auto& [name, reason] : kVerdictsThatDiffer) {
        EXPECT_TRUE(different.contains(name)) << name << " has the right verdict now: " << reason;
    }
    std::printf("reliability: strict {\"files\": %d, \"valid\": %d, \"refused_by_default\": %d, "
                "\"valid_refused_by_default\": %d, \"strict_false_rejects\": %d, "
                "\"strict_false_accepts\": %d, \"wall_s\": %.2f}\n",
        files, valid, refused, valid_refused, false_rejects, false_accepts, seconds.count());
}

TEST(GltfScenes, LoadWithTheirTriangles) {
    const Quiet quiet;
    struct Expected {
        const char* path;
        std::size_t triangles;
        std::size_t images;
    };
    const Expected scenes[] = {
        {"sponza-dabrovic/gltf/Sponza.gltf", 66450, 17},
        {"atrium-extras/extras.glb", 6124, 1},
        {"sw-oaktree/oaktree.gltf", 5302, 2},
        {"sw-venus/venus.gltf", 31398, 0},
        {"pc-NormalTangentTest/NormalTangentTest.glb", 7774, 3},
        {"pc-low-poly-tree/low-poly-tree.glb", 1126, 2},
    };
    for (const Expected& expected : scenes) {
        SCOPED_TRACE(expected.path);
        const auto start = std::chrono::steady_clock::now();
        const Scene scene = load_gltf(kData / "scenes" / expected.path);
        const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
        EXPECT_EQ(scene.triangles(), expected.triangles);
        EXPECT_EQ(scene.images.size(), expected.images);
        expect_sound(scene);
        std::printf("%s: %.2f s\n", expected.path, seconds.count());
    }
}

TEST(GltfScenes, DracoIsRefusedByName) {
    const std::string text = refusal(kData / "scenes/pc-chess-board/chess-board.glb");
    EXPECT_NE(text.find("KHR_draco_mesh_compression"), std::string::npos) << text;
}

/// The markers of the scene stand where the tip of the arrow, which runs along u = v, must appear.
TEST(GltfScenes, TextureTransformTurnsTheRightWay) {
    const Scene scene =
        load_gltf(kData / "scenes/apt-TextureTransformTest/TextureTransformTest.gltf");
    const auto transformed = [&](const char* material_name, glm::vec2 marker) {
        const glm::vec3 uv(0.5f + marker.x, 0.5f - marker.y, 1.0f);
        for (const Material& material : scene.materials) {
            if (material.name != material_name) continue;
            const TextureUse& use = material.base_color_texture;
            return glm::vec2(glm::dot(use.transform_u, uv), glm::dot(use.transform_v, uv));
        }
        return glm::vec2(-1.0f);
    };
    const glm::vec2 rotation = transformed("Rotation", {-0.07904822f, -0.51626749f});
    EXPECT_NEAR(rotation.x, 0.77781746f, 1e-6f);
    EXPECT_NEAR(rotation.y, 0.77781746f, 1e-6f);
    const glm::vec2 all = transformed("All", {-0.07f, -0.25f});
    EXPECT_NEAR(all.x, all.y, 0.04f);
    EXPECT_NEAR(all.x, 0.77f, 0.03f);
}

TEST(RigFile, StandardRigOfSponza) {
    const Rig rig = load_rig(kData / "scenes/sponza-dabrovic/rig.json");
    ASSERT_TRUE(rig.camera);
    EXPECT_EQ(rig.camera->position, glm::vec3(-11.5f, 2.6f, 0.35f));
    ASSERT_EQ(rig.lights.size(), 25u);
    EXPECT_EQ(rig.lights[24].range, 6.0f);
}

} // namespace
} // namespace ockham
