// SPDX-License-Identifier: Apache-2.0
// Reflection of embedded shaders, against what their sources say.
#include "framework/gpu/shader.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <stdexcept>

namespace ockham::gpu {
namespace {

Reflection reflect_by_name(const char* name) { return reflect(name, find_shader(name)); }

TEST(ShaderTest, FindsByNameAndVariant) {
    EXPECT_EQ(find_shader("test/reflect.comp")[0], 0x07230203u); // SPIR-V's magic number
    EXPECT_NE(find_shader("test/reflect.comp").size(),
        find_shader("test/reflect.comp:small,no_push").size());
    try {
        (void)find_shader("test/nothing.comp");
        FAIL();
    } catch (const std::runtime_error& error) {
        EXPECT_NE(std::string(error.what()).find("test/nothing.comp"), std::string::npos);
        EXPECT_NE(std::string(error.what()).find("test/reflect.comp"), std::string::npos);
    }
}

TEST(ShaderTest, ReflectsEveryKindOfBinding) {
    const Reflection shader = reflect_by_name("test/reflect.comp");
    EXPECT_EQ(shader.stage, VK_SHADER_STAGE_COMPUTE_BIT);
    std::map<std::string, ShaderBinding> found;
    for (const ShaderBinding& binding : shader.bindings) found[binding.name] = binding;
    EXPECT_EQ(found.size(), 9u);
    EXPECT_FALSE(found.contains("unused"));
    const auto expect_binding = [&](const char* name, std::uint32_t set, std::uint32_t binding,
                                    VkDescriptorType type, bool reads, bool writes) {
        ASSERT_TRUE(found.contains(name)) << name;
        EXPECT_EQ(found[name].set, set) << name;
        EXPECT_EQ(found[name].binding, binding) << name;
        EXPECT_EQ(found[name].type, type) << name;
        EXPECT_EQ(found[name].reads, reads) << name;
        EXPECT_EQ(found[name].writes, writes) << name;
    };
    expect_binding("inputs", 1, 2, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, true, false);
    // No instance name, so the block's.
    expect_binding("Outputs", 0, 4, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, false, true);
    expect_binding("both", 0, 0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, true, true);
    expect_binding("settings", 0, 1, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, true, false);
    expect_binding("layers", 0, 2, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, true, false);
    expect_binding("volume", 0, 3, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, true, false);
    expect_binding("target", 0, 5, VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, false, true);
    expect_binding("cells", 0, 6, VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, true, false);
    expect_binding("history", 0, 7, VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, true, true);
    EXPECT_EQ(found["layers"].view_type, VK_IMAGE_VIEW_TYPE_2D_ARRAY);
    EXPECT_EQ(found["volume"].view_type, VK_IMAGE_VIEW_TYPE_3D);
    EXPECT_EQ(found["target"].view_type, VK_IMAGE_VIEW_TYPE_2D);
    EXPECT_EQ(found["target"].format, VK_FORMAT_R16G16B16A16_SFLOAT);
    EXPECT_EQ(found["cells"].format, VK_FORMAT_R32_UINT);
    EXPECT_EQ(found["history"].format, VK_FORMAT_R32_SFLOAT);
    EXPECT_EQ(found["history"].view_type, VK_IMAGE_VIEW_TYPE_2D_ARRAY);
}

TEST(ShaderTest, ReflectsConstantsPushAndLocalSize) {
    const Reflection shader = reflect_by_name("test/reflect.comp");
    EXPECT_EQ(shader.push_bytes, 64u); // scalar layout: vec3, uint, mat4x3
    for (const std::uint32_t id : {3u, 5u, 9u}) {
        EXPECT_TRUE(std::ranges::find(shader.constant_ids, id) != shader.constant_ids.end()) << id;
    }
    using Size = std::array<std::uint32_t, 3>;
    EXPECT_EQ(shader.local_size({}), (Size{1, 4, 1}));
    EXPECT_EQ(shader.local_size({{3, 99}, {5, 16}}), (Size{16, 4, 1}));
    const Reflection small = reflect_by_name("test/reflect.comp:small,no_push");
    EXPECT_EQ(small.push_bytes, 0u);
    EXPECT_EQ(small.local_size({{5, 16}}), (Size{8, 1, 1}));
}

TEST(ShaderTest, RefusesArraysOfDescriptors) {
    try {
        (void)reflect_by_name("test/array.comp");
        FAIL();
    } catch (const std::runtime_error& error) {
        EXPECT_NE(std::string(error.what()).find("'test/array.comp'"), std::string::npos);
        EXPECT_NE(std::string(error.what()).find("'pictures'"), std::string::npos);
    }
}

TEST(ShaderTest, RefusesWhatIsNotSpirv) {
    const std::uint32_t words[] = {1, 2, 3, 4, 5, 6};
    EXPECT_THROW((void)reflect("garbage", words), std::runtime_error);
}

} // namespace
} // namespace ockham::gpu
