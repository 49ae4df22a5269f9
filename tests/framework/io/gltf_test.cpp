// SPDX-License-Identifier: Apache-2.0
// Small files made here: what must load is checked to the bit, what must not is named by the error.
#include "framework/core/error.hpp"
#include "framework/core/log.hpp"
#include "framework/io/gltf.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

namespace ockham {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// A PNG of 2 x 1 pixels: (255,0,0,255) and (10,20,30,128).
constexpr const char* kPng =
    "data:image/"
    "png;base64,iVBORw0KGgoAAAANSUhEUgAAAAIAAAABCAYAAAD0In+KAAAAEUlEQVR4nGP4z8Dwn0tErgEADh"
    "wCu4IAMPwAAAAASUVORK5CYII=";

std::string base64(const std::string& bytes) {
    constexpr const char* kDigits =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t bits = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const bool inside = i + k < bytes.size();
            bits = bits << 8 | (inside ? static_cast<std::uint8_t>(bytes[i + k]) : 0u);
        }
        for (int k = 3; k >= 0; --k) text += kDigits[bits >> 6 * k & 63];
    }
    for (std::size_t i = 0; i < (3 - bytes.size() % 3) % 3; ++i) text[text.size() - 1 - i] = '=';
    return text;
}

template <class T>
std::string pack(const std::vector<T>& values) {
    return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

const std::vector<glm::vec3> kCorners{{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}};
const std::vector<glm::vec2> kUvs{{0, 1}, {1, 1}, {1, 0}, {0, 0}};
const std::vector<std::uint16_t> kIndices{0, 1, 2, 0, 2, 3};

json data_uri(const std::string& bytes) {
    return {{"byteLength", bytes.size()},
        {"uri", "data:application/octet-stream;base64," + base64(bytes)}};
}

/// Bytes of the quad's buffer: positions at 0, texture coordinates at 48, indices at 80.
std::string quad_bytes() { return pack(kCorners) + pack(kUvs) + pack(kIndices); }

/// Two triangles with texture coordinates and a material; one node that moves them by (1, 2, 3).
json quad() {
    json root = json::parse(R"({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "translation": [1, 2, 3]}],
        "meshes": [{"primitives": [{
            "attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}]}],
        "materials": [{"name": "plain"}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
             "min": [0, 0, 0], "max": [2, 2, 0]},
            {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
            {"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"}],
        "bufferViews": [
            {"buffer": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 32},
            {"buffer": 0, "byteOffset": 80, "byteLength": 12}]
    })");
    root["buffers"] = json::array({data_uri(quad_bytes())});
    return root;
}

std::string little_endian(std::size_t value) {
    return pack(std::vector<std::uint32_t>{static_cast<std::uint32_t>(value)});
}

std::string chunk(const char* type, std::string bytes, char padding) {
    while (bytes.size() % 4 != 0) bytes += padding;
    return little_endian(bytes.size()) + std::string(type, 4) + bytes;
}

/// The GLB of `root`, whose first buffer must have no URI.
std::string glb(const json& root, const std::string& binary) {
    const std::string chunks = chunk("JSON", root.dump(), ' ') + chunk("BIN\0", binary, '\0');
    return "glTF" + little_endian(2) + little_endian(12 + chunks.size()) + chunks;
}

std::string quad_glb() {
    json root = quad();
    root["buffers"][0].erase("uri");
    return glb(root, quad_bytes());
}

class GltfTest : public testing::Test {
protected:
    GltfTest() {
        folder_ = fs::temp_directory_path() / fmt::format("ockham_gltf_{}", ::getpid());
        fs::create_directories(folder_ / "inside");
        log::set_sink([this](log::Level level, std::string_view text) {
            if (level == log::Level::warning) warnings_ += std::string(text) + "\n";
        });
    }
    ~GltfTest() override {
        log::set_sink({});
        fs::remove_all(folder_);
    }

    void write(const fs::path& name, const std::string& bytes) const {
        fs::remove(folder_ / name); // rewriting a file in place waits for the disk
        std::ofstream(folder_ / name, std::ios::binary) << bytes;
    }

    Scene load_bytes(const std::string& bytes, const GltfOptions& options = {}) {
        warnings_.clear();
        write("inside/scene.gltf", bytes);
        return load_gltf(folder_ / "inside/scene.gltf", options);
    }
    Scene load(const json& root, const GltfOptions& options = {}) {
        return load_bytes(root.dump(), options);
    }

    /// The text of the error that loading gives, or "loaded". Any other exception fails the test.
    std::string refusal_of_bytes(const std::string& bytes, const GltfOptions& options = {}) {
        try {
            load_bytes(bytes, options);
        } catch (const Error& error) {
            EXPECT_EQ(error.kind(), ErrorKind::input);
            EXPECT_NE(std::string(error.what()).find("scene.gltf"), std::string::npos)
                << error.what();
            EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
            return error.what();
        } catch (const std::exception& error) {
            ADD_FAILURE() << "not an Error: " << error.what();
        }
        return "loaded";
    }
    std::string refusal(const json& root, const GltfOptions& options = {}) {
        return refusal_of_bytes(root.dump(), options);
    }

    bool warned(const std::string& text) const { return warnings_.find(text) != std::string::npos; }

    const Primitive& first(const Scene& scene) const { return scene.meshes.at(0).primitives.at(0); }

    /// The positions of all corners of all triangles of the first primitive.
    std::vector<glm::vec3> corners(const Scene& scene) const {
        std::vector<glm::vec3> result;
        for (const std::uint32_t index : first(scene).indices) {
            result.push_back(first(scene).positions.at(index));
        }
        return result;
    }

    fs::path folder_;
    std::string warnings_;
};

const std::vector<glm::vec3> kQuadCorners{
    {0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 0, 0}, {2, 2, 0}, {0, 2, 0}};

// --- What must load
// --------------------------------------------------------------------------------

TEST_F(GltfTest, LoadsTheQuadExactly) {
    const Scene scene = load(quad());
    EXPECT_EQ(corners(scene), kQuadCorners);
    EXPECT_EQ(first(scene).uvs[0],
        (std::vector<glm::vec2>{{0, 1}, {1, 1}, {1, 0}, {0, 1}, {1, 0}, {0, 0}}));
    for (const glm::vec3& normal : first(scene).normals) EXPECT_EQ(normal, glm::vec3(0, 0, 1));
    EXPECT_TRUE(first(scene).tangents.empty()) << "no normal map, no tangents";
    ASSERT_EQ(scene.instances.size(), 1u);
    EXPECT_EQ(scene.instances[0].world[3], glm::vec4(1, 2, 3, 1));
    EXPECT_EQ(scene.materials.at(0).name, "plain");
    EXPECT_EQ(scene.name, "scene");
    EXPECT_EQ(warnings_, "");
}

TEST_F(GltfTest, LoadsTheSameFromGlb) {
    EXPECT_EQ(corners(load_bytes(quad_glb())), kQuadCorners);
    EXPECT_EQ(corners(load_bytes(quad_glb() + "junk")), kQuadCorners);
    EXPECT_TRUE(warned("4 bytes after the end"));
}

TEST_F(GltfTest, EmptySceneIsAScene) {
    const Scene scene = load({{"asset", {{"version", "2.0"}}}});
    EXPECT_EQ(scene.triangles(), 0u);
    EXPECT_TRUE(scene.bounds().empty());
    EXPECT_EQ(warnings_, "");
}

TEST_F(GltfTest, IndicesOfEveryTypeAndNone) {
    json root = quad();
    const std::vector<std::uint8_t> bytes{0, 1, 2, 0, 2, 3};
    const std::vector<std::uint32_t> words{0, 1, 2, 0, 2, 3};
    for (const auto& [type, data] : {std::pair{5121, pack(bytes)}, std::pair{5125, pack(words)}}) {
        root["buffers"].push_back(data_uri(data));
        root["bufferViews"].push_back(
            {{"buffer", root["buffers"].size() - 1}, {"byteLength", data.size()}});
        root["accessors"][2]["bufferView"] = root["bufferViews"].size() - 1;
        root["accessors"][2]["componentType"] = type;
        EXPECT_EQ(corners(load(root)), kQuadCorners) << type;
    }
    root["meshes"][0]["primitives"][0].erase("indices");
    EXPECT_EQ(corners(load(root)), (std::vector<glm::vec3>{{0, 0, 0}, {2, 0, 0}, {2, 2, 0}}));
    EXPECT_TRUE(warned("meshes[0].primitives[0]: 1 indices left over"));
}

TEST_F(GltfTest, StripsAndFansKeepTheirOrientation) {
    json root = quad();
    root["meshes"][0]["primitives"][0].erase("indices");
    root["meshes"][0]["primitives"][0]["mode"] = 6;
    EXPECT_EQ(corners(load(root)),
        (std::vector<glm::vec3>{{2, 0, 0}, {2, 2, 0}, {0, 0, 0}, {2, 2, 0}, {0, 2, 0}, {0, 0, 0}}));
    const std::vector<std::uint16_t> zigzag{0, 1, 3, 2};
    root["meshes"][0]["primitives"][0]["mode"] = 5;
    root["meshes"][0]["primitives"][0]["indices"] = 2;
    root["accessors"][2]["count"] = 4;
    root["buffers"] = json::array({data_uri(pack(kCorners) + pack(kUvs) + pack(zigzag) + "1234")});
    const Scene strip = load(root);
    EXPECT_EQ(corners(strip),
        (std::vector<glm::vec3>{{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}}));
    for (const glm::vec3& normal : first(strip).normals) EXPECT_EQ(normal, glm::vec3(0, 0, 1));
}

TEST_F(GltfTest, PointsAndLinesAreLeftOut) {
    for (const int mode : {0, 1, 2, 3}) {
        json root = quad();
        root["meshes"][0]["primitives"][0]["mode"] = mode;
        EXPECT_EQ(load(root).triangles(), 0u);
        EXPECT_TRUE(warned("meshes[0].primitives[0] is left out: it has points or lines"));
    }
}

TEST_F(GltfTest, InterleavedAttributes) {
    json root = quad();
    std::string bytes;
    for (int i = 0; i < 4; ++i) {
        bytes += pack(std::vector<glm::vec2>{kUvs[i]}) + pack(std::vector<glm::vec3>{kCorners[i]});
    }
    root["buffers"] = json::array({data_uri(bytes + pack(kIndices))});
    root["bufferViews"][0] = {{"buffer", 0}, {"byteLength", 80}, {"byteStride", 20}};
    root["accessors"][0]["byteOffset"] = 8;
    root["accessors"][1]["bufferView"] = 0;
    root["bufferViews"].erase(1);
    root["bufferViews"][1] = {{"buffer", 0}, {"byteOffset", 80}, {"byteLength", 12}};
    root["accessors"][2]["bufferView"] = 1;
    const Scene scene = load(root);
    EXPECT_EQ(corners(scene), kQuadCorners);
    EXPECT_EQ(first(scene).uvs[0][1], glm::vec2(1, 1));
}

TEST_F(GltfTest, QuantizedAttributes) {
    struct Case {
        int type;
        bool normalized;
        float one; ///< what the stored value `stored` stands for
        std::string bytes;
    };
    const auto corners_as = [](auto stored) {
        using T = decltype(stored);
        std::vector<T> values;
        for (const glm::vec3& corner : kCorners) {
            // One component of padding: elements begin at multiples of four bytes.
            for (const float x : {corner.x, corner.y, corner.z, 0.0f}) {
                values.push_back(x != 0.0f ? stored : T{0});
            }
        }
        return pack(values);
    };
    const Case cases[] = {
        {5120, false, -100.0f, corners_as(std::int8_t{-100})},
        {5120, true, -1.0f, corners_as(std::int8_t{-128})},
        {5121, true, 0.2f, corners_as(std::uint8_t{51})},
        {5121, false, 51.0f, corners_as(std::uint8_t{51})},
        {5122, false, -30000.0f, corners_as(std::int16_t{-30000})},
        {5122, true, 1.0f, corners_as(std::int16_t{32767})},
        {5123, true, 0.2f, corners_as(std::uint16_t{13107})},
        {5123, false, 65535.0f, corners_as(std::uint16_t{65535})},
    };
    for (const Case& one : cases) {
        json root = quad();
        root["extensionsUsed"] = root["extensionsRequired"] = {"KHR_mesh_quantization"};
        root["buffers"].push_back(data_uri(one.bytes));
        root["bufferViews"].push_back({{"buffer", 1}, {"byteLength", one.bytes.size()},
            {"byteStride", one.bytes.size() / 4}});
        root["accessors"][0] = {{"bufferView", 3}, {"componentType", one.type}, {"count", 4},
            {"type", "VEC3"}, {"normalized", one.normalized}};
        std::vector<glm::vec3> expected;
        for (const glm::vec3& corner : kQuadCorners) expected.push_back(corner * 0.5f * one.one);
        EXPECT_EQ(corners(load(root)), expected) << one.type << one.normalized;
        EXPECT_EQ(warnings_, "");
        root.erase("extensionsRequired");
        load(root);
        EXPECT_TRUE(warned("does not require KHR_mesh_quantization"));
    }
}

TEST_F(GltfTest, SparseAccessorReplacesElements) {
    json root = quad();
    const std::string bytes = pack(std::vector<std::uint16_t>{1, 3}) +
                              pack(std::vector<glm::vec3>{{5, 6, 7}, {8, 9, 10}});
    root["buffers"].push_back(data_uri(bytes));
    root["bufferViews"].push_back({{"buffer", 1}, {"byteLength", 4}});
    root["bufferViews"].push_back({{"buffer", 1}, {"byteOffset", 4}, {"byteLength", 24}});
    root["accessors"][0]["sparse"] = {{"count", 2},
        {"indices", {{"bufferView", 3}, {"componentType", 5123}}}, {"values", {{"bufferView", 4}}}};
    EXPECT_EQ(corners(load(root)), (std::vector<glm::vec3>{{0, 0, 0}, {5, 6, 7}, {2, 2, 0},
                                       {0, 0, 0}, {2, 2, 0}, {8, 9, 10}}));
    root["accessors"][0].erase("bufferView");
    EXPECT_EQ(corners(load(root)),
        (std::vector<glm::vec3>{{0, 0, 0}, {5, 6, 7}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {8, 9, 10}}))
        << "without a view the other elements are zero";
    root["accessors"][0]["sparse"]["count"] = 5;
    EXPECT_NE(refusal(root).find("accessors[0].sparse.count is 5"), std::string::npos);
    root["accessors"][0]["sparse"]["count"] = 2;
    root["accessors"][0]["count"] = 3;
    root["accessors"][1]["count"] = 3;
    EXPECT_NE(refusal(root).find("accessors[0].sparse: index 1 is 3"), std::string::npos);
}

TEST_F(GltfTest, IndicesWithoutDataAreZero) {
    json root = quad();
    root["accessors"][2].erase("bufferView");
    EXPECT_EQ(load(root).triangles(), 0u) << "all indices are 0: no triangle is left";
}

TEST_F(GltfTest, VertexColoursAndSecondSet) {
    json root = quad();
    const std::string colors = pack(
        std::vector<std::uint8_t>{255, 0, 51, 0, 0, 255, 0, 0, 0, 0, 255, 0, 255, 255, 255, 0});
    root["buffers"].push_back(data_uri(colors));
    root["bufferViews"].push_back({{"buffer", 1}, {"byteLength", 16}, {"byteStride", 4}});
    root["accessors"].push_back({{"bufferView", 3}, {"componentType", 5121}, {"normalized", true},
        {"count", 4}, {"type", "VEC3"}});
    json& attributes = root["meshes"][0]["primitives"][0]["attributes"];
    attributes["COLOR_0"] = 3;
    attributes["TEXCOORD_1"] = 1;
    attributes.erase("TEXCOORD_0");
    const Scene scene = load(root);
    EXPECT_EQ(first(scene).colors[0], glm::vec4(1.0f, 0.0f, 0.2f, 1.0f));
    EXPECT_TRUE(first(scene).uvs[0].empty());
    EXPECT_EQ(first(scene).uvs[1][2], glm::vec2(1, 0));
    root["accessors"][3]["type"] = "VEC4";
    EXPECT_EQ(first(load(root)).colors[0], glm::vec4(1.0f, 0.0f, 0.2f, 0.0f));
    root["accessors"][3]["normalized"] = false;
    EXPECT_NE(
        refusal(root).find("COLOR_0: accessors[3] has a format not allowed"), std::string::npos);
}

TEST_F(GltfTest, HierarchyAndInstances) {
    json root = quad();
    const double half = std::sqrt(0.5);
    root["nodes"] = json::array({{{"children", {1, 2}}, {"scale", {2, 2, 2}}},
        {{"mesh", 0}, {"rotation", {0, half, 0, half}}, {"translation", {1, 0, 0}}},
        {{"mesh", 0}, {"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 7, 8, 9, 1}}}});
    const Scene scene = load(root);
    ASSERT_EQ(scene.instances.size(), 2u);
    EXPECT_EQ(scene.meshes.size(), 1u);
    const glm::vec4 turned = scene.instances[0].world * glm::vec4(1, 0, 0, 1);
    EXPECT_LT(glm::length(turned - glm::vec4(2, 0, -2, 1)), 1e-6f);
    EXPECT_EQ(scene.instances[1].world[3], glm::vec4(14, 16, 18, 1));
    root.erase("scenes");
    root.erase("scene");
    EXPECT_EQ(load(root).instances.size(), 2u) << "all roots where there is no scene";
    root["nodes"][0]["scale"] = {0, 0, 0};
    EXPECT_TRUE(load(root).instances.empty()) << "a scale of zero hides";
}

TEST_F(GltfTest, DefaultSceneIsTheNamedOneOrTheFirst) {
    json root = quad();
    root["scenes"].push_back({{"name", "empty"}});
    root["scene"] = 1;
    EXPECT_TRUE(load(root).instances.empty());
    root.erase("scene");
    EXPECT_EQ(load(root).instances.size(), 1u);
}

TEST_F(GltfTest, DeepChainsOfNodesDoNotOverflowTheStack) {
    json root = quad();
    root["nodes"] = json::array();
    constexpr int kDepth = 100000;
    for (int i = 0; i + 1 < kDepth; ++i) root["nodes"].push_back({{"children", {i + 1}}});
    root["nodes"].push_back({{"mesh", 0}});
    EXPECT_EQ(load(root).instances.size(), 1u);
    root["nodes"][kDepth - 1]["children"] = {0};
    EXPECT_NE(refusal(root).find("is its own ancestor"), std::string::npos);
}

TEST_F(GltfTest, Cameras) {
    json root = quad();
    root["cameras"] = json::parse(R"([
        {"type": "perspective", "name": "lens", "perspective": {"yfov": 1, "znear": 0.1}},
        {"type": "orthographic", "orthographic": {"xmag": 3, "ymag": 2, "zfar": 9, "znear": 1}}])");
    const double half = std::sqrt(0.5);
    root["nodes"] = json::array({{{"camera", 0}, {"rotation", {0, half, 0, half}},
                                     {"translation", {4, 5, 6}}, {"scale", {3, 3, 3}}},
        {{"camera", 1}, {"name", "plan"}}});
    root["scenes"][0]["nodes"] = {0, 1};
    const Scene scene = load(root);
    ASSERT_EQ(scene.cameras.size(), 2u);
    const Camera& lens = scene.cameras[0];
    EXPECT_EQ(lens.name, "lens");
    EXPECT_EQ(lens.position, glm::vec3(4, 5, 6));
    EXPECT_LT(glm::length(lens.forward - glm::vec3(-1, 0, 0)), 1e-6f);
    EXPECT_LT(glm::length(lens.up - glm::vec3(0, 1, 0)), 1e-6f);
    EXPECT_NEAR(lens.fov_y_degrees, 180.0 / std::numbers::pi, 1e-5);
    EXPECT_EQ(lens.orthographic_height, 0.0f);
    EXPECT_EQ(scene.cameras[1].name, "plan");
    EXPECT_EQ(scene.cameras[1].orthographic_height, 4.0f);
}

TEST_F(GltfTest, PunctualLights) {
    json root = quad();
    root["extensionsUsed"] = {"KHR_lights_punctual"};
    root["extensions"]["KHR_lights_punctual"]["lights"] = json::parse(R"([
        {"type": "directional", "color": [1, 0.5, 0.25], "intensity": 4},
        {"type": "point", "name": "bulb", "intensity": 3, "range": 7},
        {"type": "spot", "spot": {"innerConeAngle": 0.25, "outerConeAngle": 0.5}}])");
    const double half = std::sqrt(0.5);
    root["nodes"] = json::array();
    for (int i = 0; i < 3; ++i) {
        root["nodes"].push_back({{"extensions", {{"KHR_lights_punctual", {{"light", i}}}}},
            {"rotation", {-half, 0, 0, half}}, {"translation", {i, 0, 0}}});
    }
    root["scenes"][0]["nodes"] = {0, 1, 2};
    const Scene scene = load(root);
    ASSERT_EQ(scene.lights.size(), 3u);
    EXPECT_EQ(scene.lights[0].type, LightType::directional);
    EXPECT_EQ(scene.lights[0].intensity, glm::vec3(4, 2, 1));
    EXPECT_LT(glm::length(scene.lights[0].direction - glm::vec3(0, -1, 0)), 1e-6f);
    EXPECT_TRUE(scene.lights[0].casts_shadow);
    EXPECT_EQ(scene.lights[1].name, "bulb");
    EXPECT_EQ(scene.lights[1].position, glm::vec3(1, 0, 0));
    EXPECT_EQ(scene.lights[1].intensity, glm::vec3(3));
    EXPECT_EQ(scene.lights[1].range, 7.0f);
    EXPECT_EQ(scene.lights[1].window_power, 4.0f);
    EXPECT_EQ(scene.lights[2].type, LightType::spot);
    EXPECT_EQ(scene.lights[2].inner_cone, 0.25f);
    EXPECT_EQ(scene.lights[2].outer_cone, 0.5f);
    EXPECT_EQ(scene.lights[2].range, std::numeric_limits<float>::infinity());
    EXPECT_EQ(warnings_, "");
}

TEST_F(GltfTest, MaterialsAndTheirExtensions) {
    json root = quad();
    root["images"] = json::array({{{"uri", kPng}}});
    root["samplers"] = json::array({{{"wrapS", 33071}, {"wrapT", 33648}}});
    root["textures"] = json::array({{{"source", 0}, {"sampler", 0}}, {{"source", 0}}});
    root["materials"][0] = json::parse(R"({
        "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.25, 0, 1], "metallicFactor": 0.125,
            "roughnessFactor": 0.75, "baseColorTexture": {"index": 0}},
        "normalTexture": {"index": 1, "scale": 0.5},
        "emissiveFactor": [1, 0.5, 0], "doubleSided": true, "alphaMode": "MASK", "alphaCutoff": 0.25,
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 8},
            "KHR_materials_ior": {"ior": 1.25}, "KHR_materials_unlit": {}}})");
    const Scene scene = load(root);
    const Material& material = scene.materials.at(0);
    EXPECT_EQ(material.base_color, glm::vec4(0.5f, 0.25f, 0.0f, 1.0f));
    EXPECT_EQ(material.metallic, 0.125f);
    EXPECT_EQ(material.roughness, 0.75f);
    EXPECT_EQ(material.normal_scale, 0.5f);
    EXPECT_EQ(material.emissive, glm::vec3(8, 4, 0));
    EXPECT_EQ(material.ior, 1.25f);
    EXPECT_TRUE(material.unlit && material.double_sided && material.masked);
    EXPECT_EQ(material.alpha_cutoff, 0.25f);
    EXPECT_EQ(material.base_color_texture.wrap_u, Wrap::clamp);
    EXPECT_EQ(material.base_color_texture.wrap_v, Wrap::mirror);
    EXPECT_EQ(material.normal_texture.wrap_u, Wrap::repeat);
    EXPECT_FALSE(material.emissive_texture.used());
    ASSERT_EQ(scene.images.size(), 1u) << "one image for two textures";
    EXPECT_EQ(scene.images[0].width, 2);
    EXPECT_EQ(scene.images[0].height, 1);
    EXPECT_EQ(scene.images[0].rgba, (std::vector<std::uint8_t>{255, 0, 0, 255, 10, 20, 30, 128}));
    ASSERT_EQ(first(scene).tangents.size(), 6u) << "the normal map needs tangents";
    EXPECT_EQ(first(scene).tangents[0], glm::vec4(1, 0, 0, 1));
}

TEST_F(GltfTest, BlendIsTreatedAsMask) {
    json root = quad();
    root["materials"][0]["alphaMode"] = "BLEND";
    root["materials"][0]["alphaCutoff"] = 0.9;
    const Scene scene = load(root);
    EXPECT_TRUE(scene.materials[0].masked);
    EXPECT_EQ(scene.materials[0].alpha_cutoff, 0.5f);
    EXPECT_TRUE(warned("materials[0] 'plain': alpha mode BLEND"));
}

TEST_F(GltfTest, PrimitivesWithoutMaterialGetTheDefaultOne) {
    json root = quad();
    root["meshes"][0]["primitives"][0].erase("material");
    const Scene scene = load(root);
    const Material& material = scene.materials.at(first(scene).material);
    EXPECT_EQ(material.name, "default");
    EXPECT_EQ(material.base_color, glm::vec4(1.0f));
    EXPECT_EQ(material.metallic, 1.0f);
}

TEST_F(GltfTest, TextureTransform) {
    json root = quad();
    root["images"] = json::array({{{"uri", kPng}}});
    root["textures"] = json::array({{{"source", 0}}});
    json& use = root["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"];
    use = {{"index", 0}};
    use["extensions"]["KHR_texture_transform"] = {{"offset", {0.5, 3000000000}}, {"scale", {2, 4}},
        {"rotation", std::numbers::pi / 2}, {"texCoord", 1}};
    root["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_1"] = 1;
    const TextureUse loaded = load(root).materials[0].base_color_texture;
    EXPECT_EQ(loaded.uv_set, 1) << "the extension overrides texCoord";
    EXPECT_LT(glm::length(loaded.transform_u - glm::vec3(0, 4, 0.5f)), 1e-6f);
    EXPECT_LT(glm::length(glm::vec2(loaded.transform_v) - glm::vec2(-2, 0)), 1e-6f);
    EXPECT_EQ(loaded.transform_v.z, 3e9f);
}

TEST_F(GltfTest, ImagesAreSharedByFile) {
    const std::string png(kPng);
    write("inside/a b.png", "not a picture");
    json root = quad();
    root["images"] = json::array({{{"uri", "a%20b.png"}}, {{"uri", "a%20b.png"}}, {{"uri", kPng}}});
    root["textures"] = json::array({{{"source", 0}}, {{"source", 1}}, {{"source", 2}}});
    root["materials"][0]["pbrMetallicRoughness"] = {
        {"baseColorTexture", {{"index", 0}}}, {"metallicRoughnessTexture", {{"index", 1}}}};
    root["materials"][0]["emissiveTexture"] = {{"index", 2}};
    const Scene scene = load(root);
    EXPECT_EQ(scene.images.size(), 1u);
    EXPECT_FALSE(scene.materials[0].base_color_texture.used()) << "the factor alone counts";
    EXPECT_TRUE(scene.materials[0].emissive_texture.used());
    EXPECT_TRUE(warned("images[0] is left out: not a picture of a known format"));
    EXPECT_FALSE(warned("images[1]")) << "each file is tried once";
    EXPECT_NE(refusal(root, {.strict = true}).find("images[0] is left out"), std::string::npos);
}

TEST_F(GltfTest, HugeImagesAreRefusedBeforeTheyAreDecoded) {
    // The header of a PNG of 16385 x 1 pixels; its data is not looked at.
    std::string png("\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\x40\x01\0\0\0\x01\x08\x06\0\0\0", 29);
    png += std::string(4, '\0');
    json root = quad();
    root["images"] = json::array({{{"uri", "data:image/png;base64," + base64(png)}}});
    root["textures"] = json::array({{{"source", 0}}});
    root["materials"][0]["emissiveTexture"] = {{"index", 0}};
    EXPECT_FALSE(load(root).materials[0].emissive_texture.used());
    EXPECT_TRUE(warned("16385 x 1 pixels")) << warnings_;
}

TEST_F(GltfTest, MissingTextureCoordinatesAreZero) {
    json root = quad();
    root["images"] = json::array({{{"uri", kPng}}});
    root["textures"] = json::array({{{"source", 0}}});
    root["materials"][0]["emissiveTexture"] = {{"index", 0}, {"texCoord", 1}};
    const Scene scene = load(root);
    EXPECT_EQ(first(scene).uvs[1], std::vector<glm::vec2>(6, glm::vec2(0.0f)));
    EXPECT_TRUE(warned("has no TEXCOORD_1"));
    root["materials"][0]["emissiveTexture"]["texCoord"] = 2;
    EXPECT_FALSE(load(root).materials[0].emissive_texture.used());
}

TEST_F(GltfTest, WhatIsNotSupportedWarnsOnce) {
    json root = quad();
    root["accessors"].push_back(
        {{"componentType", 5126}, {"count", 2}, {"type", "SCALAR"}, {"min", {0}}, {"max", {0}}});
    root["accessors"].push_back({{"componentType", 5126}, {"count", 2}, {"type", "VEC3"}});
    root["animations"] = json::parse(R"([{"samplers": [{"input": 3, "output": 4}],
        "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}]}])");
    root["skins"] = json::parse(R"([{"joints": [0]}])");
    root["meshes"][0]["primitives"][0]["targets"] = json::array({{{"POSITION", 0}}});
    root["meshes"].push_back(root["meshes"][0]);
    root["extensionsUsed"] = {"KHR_materials_clearcoat", "KHR_materials_unlit", "EXT_other"};
    EXPECT_EQ(load(root).triangles(), 2u);
    EXPECT_EQ(std::count(warnings_.begin(), warnings_.end(), '\n'), 4) << warnings_;
    EXPECT_TRUE(warned("animations are ignored"));
    EXPECT_TRUE(warned("skins are ignored"));
    EXPECT_TRUE(warned("morph targets are ignored"));
    EXPECT_TRUE(warned("ignored: KHR_materials_clearcoat, EXT_other"));
    EXPECT_EQ(load(root, {.strict = true}).triangles(), 2u) << "all of this is valid";
}

// --- Folders and URIs
// ------------------------------------------------------------------------------

TEST_F(GltfTest, BuffersAreReadFromTheFolderOfTheFile) {
    json root = quad();
    write("inside/a+b c.bin", quad_bytes() + "longer than declared");
    root["buffers"][0]["uri"] = "a+b%20c.bin";
    EXPECT_EQ(corners(load(root)), kQuadCorners);
    root["buffers"][0]["uri"] = "missing.bin";
    EXPECT_NE(refusal(root).find("missing.bin"), std::string::npos);
}

TEST_F(GltfTest, UrisMayNotLeaveTheFolder) {
    json root = quad();
    write("secret.bin", quad_bytes());
    const std::string absolute = (folder_ / "secret.bin").string();
    for (const std::string& uri : {std::string("../secret.bin"), std::string("%2e%2e/secret.bin"),
             std::string("./../secret.bin"), absolute}) {
        root["buffers"][0]["uri"] = uri;
        const std::string text = refusal(root);
        EXPECT_NE(text.find("buffers[0]"), std::string::npos) << text;
        EXPECT_NE(text.find("leaves the folder"), std::string::npos) << text;
        EXPECT_EQ(corners(load(root, {.allow_external = true})), kQuadCorners) << uri;
    }
    for (const char* uri : {"%zz", "a%2", "a%00b", "", "..\\secret.bin", ":", "data:x"}) {
        root["buffers"][0]["uri"] = uri;
        EXPECT_NE(refusal(root).find("buffers[0]"), std::string::npos) << uri;
    }
    for (const char* uri : {"file:///etc/passwd", "http://localhost/a.bin", "x:y"}) {
        root["buffers"][0]["uri"] = uri;
        EXPECT_EQ(load(root, {.allow_external = true}).triangles(), 0u) << "never fetched: " << uri;
        EXPECT_TRUE(warned("buffers[0] is left out")) << uri;
    }
}

TEST_F(GltfTest, DataUris) {
    json root = quad();
    std::string percent;
    for (const char c : quad_bytes())
        percent += fmt::format("%{:02x}", static_cast<std::uint8_t>(c));
    root["buffers"][0]["uri"] = "data:application/octet-stream," + percent;
    EXPECT_EQ(corners(load(root)), kQuadCorners);
    root["buffers"][0]["uri"] = "data:application/octet-stream;base64,AAA*";
    EXPECT_NE(refusal(root).find("not base64"), std::string::npos);
}

// --- What must not load
// ----------------------------------------------------------------------------

struct Mutation {
    const char* pointer; ///< what is replaced, or added
    json value;          ///< null: it is removed instead
    const char* expected;
};

TEST_F(GltfTest, RefusalsNameTheObject) {
    const Mutation mutations[] = {
        {"/asset", nullptr, "asset is missing"},
        {"/asset/version", "1.0", "asset.version is '1.0'"},
        {"/asset/version", 2.0, "asset.version is 2.0, expected a string"},
        {"/asset/minVersion", "3.0", "asset.minVersion is '3.0'"},
        {"/extensionsRequired", {"KHR_draco_mesh_compression"},
            "requires KHR_draco_mesh_compression"},
        {"/meshes", "x", "meshes is \"x\", expected an array"},
        {"/meshes/0", 3, "meshes[0] is 3, expected an object"},
        {"/scene", 1, "scene is 1"},
        {"/scenes/0/nodes/0", 1, "scenes[0].nodes[0] is 1, but the file has 1 nodes"},
        {"/scenes/0/nodes/0", -1, "scenes[0].nodes[0] is -1"},
        {"/nodes/0/mesh", 1, "nodes[0].mesh is 1, but the file has 1 meshes"},
        {"/nodes/0/mesh", -1, "nodes[0].mesh is -1"},
        {"/nodes/0/mesh", 0.5, "nodes[0].mesh is 0.5"},
        {"/nodes/0/mesh", "0", "nodes[0].mesh is \"0\""},
        {"/nodes/0/camera", 0, "nodes[0].camera is 0"},
        {"/nodes/0/children", {0}, "nodes[0] is its own ancestor"},
        {"/nodes/0/children", {7}, "nodes[0].children[0] is 7"},
        {"/nodes/0/children", {{"a", 1}}, "nodes[0].children is {\"a\":1}"},
        {"/nodes/0/translation", {1, 2}, "nodes[0].translation is [1,2], expected an array of 3"},
        {"/nodes/0/translation/1", 1e39, "nodes[0].translation[1] is 1e+39"},
        {"/nodes/0/translation/1", "y", "nodes[0].translation[1] is \"y\""},
        {"/nodes/0/matrix", {1, 0, 0, 1}, "nodes[0].matrix is [1,0,0,1]"},
        {"/nodes/0/scale", {3e38, 3e38, 3e38}, "nodes[0] '' is moved or scaled beyond"},
        {"/nodes/0/extensions", {{"KHR_lights_punctual", {{"light", 0}}}},
            "nodes[0].extensions.KHR_lights_punctual.light is 0"},
        {"/meshes/0/primitives", nullptr, "meshes[0].primitives is missing"},
        {"/meshes/0/primitives/0/attributes", nullptr, "primitives[0].attributes is missing"},
        {"/meshes/0/primitives/0/attributes/POSITION", 9, "attributes.POSITION is 9"},
        {"/meshes/0/primitives/0/attributes/POSITION", 1, "POSITION: accessors[1] has a format"},
        {"/meshes/0/primitives/0/attributes/NORMAL", 2, "NORMAL: accessors[2] has a format"},
        {"/meshes/0/primitives/0/attributes/TEXCOORD_0", 0,
            "TEXCOORD_0: accessors[0] has a format"},
        {"/meshes/0/primitives/0/indices", 3, "primitives[0].indices is 3"},
        {"/meshes/0/primitives/0/indices", 0, "indices: accessors[0] has component type 5126"},
        {"/meshes/0/primitives/0/material", 1, "primitives[0].material is 1"},
        {"/meshes/0/primitives/0/mode", -1, "primitives[0].mode is -1"},
        {"/materials/0/normalTexture", {{"index", 0}}, "materials[0].normalTexture.index is 0"},
        {"/materials/0/doubleSided", 1, "materials[0].doubleSided is 1"},
        {"/accessors/0/bufferView", 3, "accessors[0].bufferView is 3, but the file has 3"},
        {"/accessors/0/bufferView", -1, "accessors[0].bufferView is -1"},
        {"/accessors/0/byteOffset", 4, "accessors[0]: its 4 elements end at byte 52"},
        {"/accessors/0/byteOffset", -4, "accessors[0].byteOffset is -4"},
        {"/accessors/0/byteOffset", 9007199254740992,
            "accessors[0].byteOffset is 9007199254740992"},
        {"/accessors/0/count", 5,
            "accessors[0]: its 5 elements end at byte 60, but bufferViews[0] has 48"},
        {"/accessors/0/count", 8, "accessors[0]: its 8 elements"},
        {"/accessors/0/count", 3, "TEXCOORD_0: accessors[1] has 4 elements, POSITION has 3"},
        {"/accessors/0/count", 0, "accessors[0].count is 0"},
        {"/accessors/0/count", -1, "accessors[0].count is -1"},
        {"/accessors/0/count", 2147483648, "accessors[0].count is 2147483648"},
        {"/accessors/0/count", 9007199254740992, "accessors[0].count is 9007199254740992"},
        {"/accessors/0/count", 1e300, "accessors[0].count is 1e+300"},
        {"/accessors/0/count", "4", "accessors[0].count is \"4\""},
        {"/accessors/0/count", nullptr, "accessors[0].count is missing"},
        {"/accessors/0/componentType", 5130, "accessors[0] is read, but its type is unknown"},
        {"/accessors/0/type", "VEC9", "accessors[0] is read, but its type is unknown"},
        {"/accessors/0/type", "MAT4", "accessors[0]: its 4 elements end at byte 256"},
        {"/accessors/1/count", 3, "TEXCOORD_0: accessors[1] has 3 elements"},
        {"/accessors/2/componentType", 5125, "accessors[2]: its 6 elements end at byte 24"},
        {"/accessors/2/componentType", 5122, "indices: accessors[2] has component type 5122"},
        {"/bufferViews/0/buffer", 1, "bufferViews[0].buffer is 1, but the file has 1 buffers"},
        {"/bufferViews/0/byteLength", 93, "bufferViews[0] ends at byte 93, but buffers[0] has 92"},
        {"/bufferViews/0/byteLength", 47, "accessors[0]: its 4 elements end at byte 48"},
        {"/bufferViews/0/byteLength", 0, "bufferViews[0].byteLength is 0"},
        {"/bufferViews/0/byteLength", 4294967296, "bufferViews[0].byteLength is 4294967296"},
        {"/bufferViews/0/byteLength", nullptr, "bufferViews[0].byteLength is missing"},
        {"/bufferViews/0/byteOffset", 45, "bufferViews[0] ends at byte 93"},
        {"/bufferViews/0/byteOffset", 4294967295, "bufferViews[0] ends at byte 4294967343"},
        {"/bufferViews/0/byteStride", 8, "bufferViews[0].byteStride is 8"},
        {"/bufferViews/0/byteStride", 14, "bufferViews[0].byteStride is 14"},
        {"/bufferViews/0/byteStride", 256, "bufferViews[0].byteStride is 256"},
        {"/bufferViews/0/byteStride", 16, "accessors[0]: its 4 elements end at byte 60"},
        {"/buffers/0/byteLength", 93, "buffers[0] declares 93 bytes, its data has 92"},
        {"/buffers/0/byteLength", nullptr, "buffers[0].byteLength is missing"},
        {"/buffers/0/uri", 3, "buffers[0].uri is 3"},
        {"/cameras", json::parse(R"([{"type": "perspective"}])"),
            "cameras[0].perspective is missing"},
    };
    for (const Mutation& mutation : mutations) {
        json root = quad();
        const json::json_pointer pointer(mutation.pointer);
        if (mutation.value.is_null()) {
            root[pointer.parent_pointer()].erase(pointer.back());
        } else {
            root[pointer] = mutation.value;
        }
        const std::string text = refusal(root);
        EXPECT_NE(text.find(mutation.expected), std::string::npos)
            << mutation.pointer << " = " << mutation.value << "\ngave:     " << text
            << "\nexpected: " << mutation.expected;
    }
}

TEST_F(GltfTest, IndicesBeyondTheVerticesAreRefused) {
    json root = quad();
    for (const std::uint16_t bad : {std::uint16_t{4}, std::uint16_t{65535}}) {
        std::vector<std::uint16_t> indices = kIndices;
        indices[5] = bad;
        root["buffers"] = json::array({data_uri(pack(kCorners) + pack(kUvs) + pack(indices))});
        const std::string expected = fmt::format(
            "meshes[0].primitives[0].indices: index 5 is {}, but there are 4 vertices", bad);
        EXPECT_NE(refusal(root).find(expected), std::string::npos);
    }
}

TEST_F(GltfTest, PositionsThatAreNotFiniteAreRefused) {
    for (const float bad : {std::numeric_limits<float>::quiet_NaN(),
             std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity()}) {
        std::vector<glm::vec3> positions = kCorners;
        positions[2].y = bad;
        json root = quad();
        root["buffers"] = json::array({data_uri(pack(positions) + pack(kUvs) + pack(kIndices))});
        EXPECT_NE(refusal(root).find("POSITION: vertex 2 is"), std::string::npos);
    }
}

TEST_F(GltfTest, TextureCoordinatesThatAreNotFiniteAreTolerated) {
    std::vector<glm::vec2> uvs = kUvs;
    uvs[0].x = std::numeric_limits<float>::quiet_NaN();
    json root = quad();
    root["buffers"] = json::array({data_uri(pack(kCorners) + pack(uvs) + pack(kIndices))});
    EXPECT_EQ(first(load(root)).uvs[0][0], glm::vec2(0.0f));
    EXPECT_TRUE(warned("TEXCOORD_0: 1 vertices are not finite"));
    EXPECT_NE(refusal(root, {.strict = true}).find("--strict refuses this"), std::string::npos);
}

TEST_F(GltfTest, NodesWithTwoParentsAreRefused) {
    json root = quad();
    root["nodes"] = json::parse(R"([{"children": [2]}, {"children": [2]}, {"mesh": 0}])");
    EXPECT_NE(
        refusal(root).find("nodes[2] is a child of nodes[0] and of nodes[1]"), std::string::npos);
    root["nodes"] = json::parse(R"([{"children": [1]}, {"children": [2]}, {"children": [0]}])");
    EXPECT_NE(refusal(root).find("is its own ancestor"), std::string::npos);
}

TEST_F(GltfTest, AccessorsWithoutDataMayNotFillTheMemory) {
    json root = quad();
    root["accessors"][0].erase("bufferView");
    root["accessors"][0]["count"] = 200000000;
    EXPECT_NE(
        refusal(root).find("accessors[0] has 200000000 elements and no data"), std::string::npos);
    root = quad();
    for (json& accessor : root["accessors"]) {
        accessor.erase("bufferView");
        accessor["count"] = 10000000;
    }
    for (int i = 0; i < 20; ++i) {
        root["meshes"][0]["primitives"].push_back(root["meshes"][0]["primitives"][0]);
    }
    EXPECT_NE(refusal(root).find("have 420000000 vertices and indices, at most 4200192 are accepted "
                                 "of a file with 92 bytes of data"),
        std::string::npos);
}

TEST_F(GltfTest, ToleratedFindingsAreRefusedIfStrict) {
    const Mutation mutations[] = {
        {"/materials/0/pbrMetallicRoughness", {{"roughnessFactor", 1.5}}, "roughnessFactor is 1.5"},
        {"/materials/0/alphaCutoff", -1, "materials[0].alphaCutoff is -1"},
        {"/nodes/0/rotation", {0, 0, 0, 0.5}, "nodes[0].rotation has length 0.5"},
        {"/nodes/0/matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1},
            "nodes[0] has a matrix"},
        {"/textures", json::array(), "textures is "},
        {"/extensionsUsed", json::array(), "extensionsUsed is an empty array"},
        {"/extensionsRequired", {"KHR_texture_transform"}, "extensionsUsed has not"},
    };
    for (const Mutation& mutation : mutations) {
        json root = quad();
        root[json::json_pointer(mutation.pointer)] = mutation.value;
        EXPECT_EQ(load(root).triangles(), 2u);
        EXPECT_TRUE(warned(mutation.expected)) << warnings_;
        const std::string text = refusal(root, {.strict = true});
        EXPECT_NE(text.find(mutation.expected), std::string::npos) << text;
    }
}

/// What is not drawn anyway makes no file unusable, but --strict vouches for the whole file.
TEST_F(GltfTest, StrictAlsoLooksAtWhatIsNotRead) {
    json rich = quad();
    rich["extensionsUsed"] = {"KHR_materials_sheen", "KHR_materials_variants"};
    rich["animations"] = json::parse(R"([{"samplers": [{"input": 3, "output": 4}],
        "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}]}])");
    rich["accessors"].push_back(json::parse(R"({"bufferView": 3, "componentType": 5126, "count": 2,
        "type": "SCALAR", "min": [0.5], "max": [1.5]})"));
    rich["accessors"].push_back({{"componentType", 5126}, {"count", 2}, {"type", "VEC3"}});
    rich["bufferViews"].push_back({{"buffer", 1}, {"byteLength", 8}});
    rich["buffers"].push_back(data_uri(pack(std::vector<float>{0.5f, 1.5f})));
    rich["nodes"].push_back({{"children", {2}}});
    rich["nodes"].push_back(json::object());
    rich["skins"] = json::parse(R"([{"joints": [1, 2]}])");
    rich["images"] = json::array({{{"uri", kPng}}});
    ASSERT_EQ(load(rich, {.strict = true}).triangles(), 2u);

    const std::string decreasing = pack(std::vector<float>{1.5f, 0.5f});
    const Mutation mutations[] = {
        {"/accessors/0/max/1", 2.5, "accessors[0].max[1] is 2.5, its data has 2"},
        {"/accessors/3/max", {2.5}, "accessors[3].max[0] is 2.5, its data has 1.5"},
        {"/accessors/1/normalized", true, "accessors[1] is normalized, but of 32 bits"},
        {"/accessors/1/min", {0}, "accessors[1].min has 1 numbers, expected 2"},
        {"/buffers/1", data_uri(decreasing), "expected times that increase"},
        {"/bufferViews/3/byteStride", 4, "samplers[0].input: its view has a byteStride"},
        {"/bufferViews/1/target", 34963, "bufferViews[1], which serves something else"},
        {"/animations/0/channels/0/sampler", 1, "sampler is 1, but the animation has 1"},
        {"/animations/0/channels/0/target/node", 7, "the file has 3 nodes"},
        {"/animations/0/samplers/0/interpolation", "CUBICSPLINE", "has 2 elements, expected 6"},
        {"/skins/0/joints", {0, 1}, "skins[0].joints have no common root"},
        {"/skins/0/joints", {1, 1}, "skins[0].joints has an element twice"},
        {"/nodes/1/skin", 0, "nodes[1] has skin and no mesh"},
        {"/nodes/1/matrix", {1, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, "nodes[1].matrix"},
        {"/images/0/mimeType", "image/jpeg", "images[0] is declared as image/jpeg"},
        {"/images/0/uri", "none.png", "images[0]: cannot open"},
        {"/images/0/uri", "data:image/png;;base64,AAAA", "is no URI"},
        {"/meshes/0/primitives/0/attributes/COLOUR", 1, "COLOUR is no known attribute"},
        {"/meshes/0/primitives/0/attributes/TEXCOORD_2", 1, "TEXCOORD_n are not numbered from 0"},
        {"/materials/0/extensions", {{"KHR_materials_sheen", {{"sheenRoughnessFactor", 2}}}},
            "sheenRoughnessFactor is 2, out of range"},
        {"/nodes/0/extensions", {{"KHR_materials_sheen", json::object()}},
            "is not where KHR_materials_sheen may stand"},
        {"/nodes/0/extensions", {{"EXT_other", json::object()}}, "is not in extensionsUsed"},
        {"/meshes/0/primitives/0/extensions",
            json::parse(R"({"KHR_materials_variants": {"mappings": []}})"), "is an empty array"},
        {"/meshes/0/weights", {0.5}, "meshes[0] has 1 weights and 0 targets"},
    };
    for (const Mutation& mutation : mutations) {
        json root = rich;
        root[json::json_pointer(mutation.pointer)] = mutation.value;
        EXPECT_EQ(load(root).triangles(), 2u) << mutation.expected;
        const std::string text = refusal(root, {.strict = true});
        EXPECT_NE(text.find(mutation.expected), std::string::npos)
            << mutation.pointer << ": " << text;
    }
}

TEST_F(GltfTest, FilesThatAreNoGltf) {
    EXPECT_NE(refusal_of_bytes("").find("the file is empty"), std::string::npos);
    for (const std::string& bytes : {std::string(" \n"), std::string("[1]"), std::string("glT"),
             std::string(1000, '\0'), std::string("\xFF\xFE{\0}\0", 6), std::string("PK\3\4")}) {
        EXPECT_NE(refusal_of_bytes(bytes).find("it is no glTF"), std::string::npos) << bytes;
    }
    EXPECT_NE(refusal_of_bytes("{\"asset\": {\"version\": \"2.0\"}").find("not valid JSON"),
        std::string::npos);
    EXPECT_NE(refusal_of_bytes("{\"a\": 1e999}").find("not valid JSON"), std::string::npos);
    EXPECT_NE(refusal_of_bytes("{\"a\": \"\xC3\x28\"}").find("not valid JSON"), std::string::npos);
    const std::string quad_text = quad().dump();
    EXPECT_EQ(load_bytes("\xEF\xBB\xBF" + quad_text).triangles(), 2u);
    EXPECT_TRUE(warned("byte order mark"));
    EXPECT_THROW(load_bytes("\xEF\xBB\xBF" + quad_text, {.strict = true}), Error);
    EXPECT_THROW(load_gltf(folder_ / "none.gltf"), Error);
    EXPECT_THROW(load_gltf(folder_), Error);
}

TEST_F(GltfTest, DeepJsonDoesNotOverflowTheStack) {
    for (const std::size_t depth : {std::size_t{200}, std::size_t{1000000}}) {
        const std::string text =
            "{\"asset\": {\"version\": \"2.0\"}, \"extras\": " + std::string(depth, '[') +
            std::string(depth, ']') + "}";
        EXPECT_NE(refusal_of_bytes(text).find("nested deeper than"), std::string::npos);
    }
    json root = quad();
    root["extras"] = json::parse(std::string(50, '[') + std::string(50, ']'));
    EXPECT_EQ(load(root).triangles(), 2u);
}

TEST_F(GltfTest, EveryTruncationOfAGlbIsRefused) {
    const std::string whole = quad_glb();
    for (std::size_t length = 0; length < whole.size(); ++length) {
        EXPECT_NE(refusal_of_bytes(whole.substr(0, length)), "loaded") << length;
    }
}

TEST_F(GltfTest, EveryDamagedHeaderOfAGlbIsAnErrorOrAScene) {
    const std::string whole = quad_glb();
    const std::size_t json_bytes = 12 + 8 + (quad_glb().size() - 92 - 28);
    for (std::size_t at = 0; at < whole.size(); ++at) {
        if (at >= 20 && at < json_bytes) continue; // the JSON itself: see EveryMutation
        for (const int flip : {1, 0x80, 0xFF}) {
            std::string damaged = whole;
            damaged[at] = static_cast<char>(damaged[at] ^ flip);
            refusal_of_bytes(damaged);
        }
    }
}

/// Every value of a rich file replaced by each of several wrong ones, or removed: nothing but an
/// Error may come out, and what loads must be whole.
TEST_F(GltfTest, EveryMutationIsAnErrorOrAScene) {
    json root = quad();
    root["images"] = json::array({{{"uri", kPng}}, {{"bufferView", 2}, {"mimeType", "image/png"}}});
    root["samplers"] = json::array({{{"wrapS", 33071}}});
    root["textures"] = json::array({{{"source", 0}, {"sampler", 0}}, {{"source", 1}}});
    root["cameras"] =
        json::parse(R"([{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}},
        {"type": "orthographic", "orthographic": {"xmag": 3, "ymag": 2, "zfar": 9, "znear": 1}}])");
    root["extensions"]["KHR_lights_punctual"]["lights"] = json::parse(
        R"([{"type": "spot", "color": [1, 1, 1], "range": 3, "spot": {"innerConeAngle": 0.1}}])");
    root["nodes"][0]["children"] = {1, 2};
    root["nodes"].push_back(json::parse(
        R"({"camera": 0, "rotation": [0, 0, 0, 1], "extensions": {"KHR_lights_punctual": {"light": 0}}})"));
    root["nodes"].push_back(
        {{"camera", 1}, {"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}}});
    root["materials"][0] = json::parse(R"({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0,
        "extensions": {"KHR_texture_transform": {"offset": [1, 2], "rotation": 1, "texCoord": 0}}}},
        "normalTexture": {"index": 1, "scale": 2}, "alphaMode": "MASK",
        "extensions": {"KHR_materials_ior": {"ior": 1.4}, "KHR_materials_unlit": {}}})");
    root["meshes"][0]["primitives"][0]["attributes"]["TANGENT"] = 3;
    root["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = 4;
    root["accessors"].push_back({{"componentType", 5126}, {"count", 4}, {"type", "VEC4"}});
    root["accessors"].push_back({{"componentType", 5126}, {"count", 4}, {"type", "VEC3"},
        {"sparse", {{"count", 2}, {"indices", {{"bufferView", 2}, {"componentType", 5123}}},
                       {"values", {{"bufferView", 0}}}}}});
    ASSERT_EQ(load(root).triangles(), 2u);

    const std::vector<json> wrong{nullptr, true, -1, 0, 1, 2, 3, 255, 2147483648, 4294967295,
        9007199254740992, -9007199254740992, 0.5, 1e300, "x", "", json::array(), json::object(),
        json::array({0, 0}), json::array({json::object()})};
    std::size_t loaded = 0, refused = 0;
    const json flat = root.flatten();
    std::vector<json::json_pointer> places;
    for (const auto& [pointer, value] : flat.items()) {
        for (json::json_pointer place(pointer); !place.empty(); place.pop_back()) {
            if (std::find(places.begin(), places.end(), place) == places.end())
                places.push_back(place);
        }
    }
    for (const json::json_pointer& place : places) {
        std::vector<json> variants;
        for (const json& value : wrong) {
            variants.push_back(root);
            variants.back()[place] = value;
        }
        variants.push_back(root);
        json& parent = variants.back()[place.parent_pointer()];
        if (parent.is_array())
            parent.erase(std::stoul(place.back()));
        else
            parent.erase(place.back());
        for (const json& variant : variants) {
            if (refusal(variant) == "loaded") {
                ++loaded;
                refusal(variant, {.strict = true});
            } else {
                ++refused;
            }
        }
    }
    EXPECT_GT(loaded, 500u);
    EXPECT_GT(refused, 500u);
    std::printf("%zu places, %zu mutations loaded, %zu refused\n", places.size(), loaded, refused);
}

} // namespace
} // namespace ockham
