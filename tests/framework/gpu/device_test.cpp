// SPDX-License-Identifier: Apache-2.0
// Choosing a device and refusing to, validation modes, and silence at destruction.
#include "framework/core/error.hpp"
#include "framework/core/log.hpp"
#include "framework/gpu/buffer.hpp"
#include "framework/gpu/device.hpp"
#include "framework/gpu/image.hpp"
#include "tests/support/gpu_fixture.hpp"

#include <cstdlib>
#include <optional>

namespace ockham::gpu {
namespace {

using test::error_of;

/// Sets a variable of the environment for its life.
class Environment {
public:
    Environment(const char* name, const char* value) : name_(name) {
        if (const char* present = std::getenv(name)) before_ = present;
        setenv(name, value, 1);
    }
    ~Environment() {
        if (before_) {
            setenv(name_, before_->c_str(), 1);
        } else {
            unsetenv(name_);
        }
    }
    Environment(const Environment&) = delete;
    Environment& operator=(const Environment&) = delete;

private:
    const char* name_;
    std::optional<std::string> before_;
};

class DeviceTest : public test::GpuTest {};

TEST_F(DeviceTest, ListsEveryGpuWithScore) {
    const std::string list = list_gpus();
    EXPECT_EQ(list.rfind("[0] ", 0), 0u) << list;
    EXPECT_NE(list.find("score "), std::string::npos) << list;
}

TEST_F(DeviceTest, IsChosenByIndexOrPartOfItsName) {
    const Device first({.gpu = "0"});
    ASSERT_GE(first.info().name.size(), 3u);
    std::string part = first.info().name.substr(0, 4);
    for (char& c : part) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    const Device same({.gpu = part});
    EXPECT_EQ(same.info().name, first.info().name);
    EXPECT_FALSE(first.info().driver.empty());
    EXPECT_FALSE(first.info().driver_version.empty());
    EXPECT_EQ(first.info().api_version.rfind("1.", 0), 0u);
    EXPECT_GE(first.limits().image_extent, 4096u);
    EXPECT_GE(first.limits().storage_bytes, std::uint64_t{1} << 27);
}

TEST_F(DeviceTest, IsOfTheDriverUnderTest) {
    const char* wanted = std::getenv("OCKHAM_TEST_GPU"); // set where a second driver is tested
    const bool second = wanted && std::string_view(wanted) == "SwiftShader";
    for (const std::string& name : {Device().info().name, device().info().name}) {
        EXPECT_EQ(name.find("SwiftShader") != std::string::npos, second) << name;
    }
}

TEST_F(DeviceTest, AnUnknownGpuIsRefusedWithTheListOfAll) {
    for (const char* wish : {"no such gpu", "77"}) {
        const std::string text = error_of([&] { Device device({.gpu = wish}); });
        EXPECT_NE(text.find(wish), std::string::npos) << text;
        EXPECT_NE(text.find("[0] "), std::string::npos) << text;
    }
}

TEST_F(DeviceTest, ExtensionsAskedForAreEnabledOrRefusedByName) {
    const Device device({.instance_extensions = {VK_KHR_SURFACE_EXTENSION_NAME},
        .device_extensions = {VK_KHR_SWAPCHAIN_EXTENSION_NAME}});
    EXPECT_NE(vkGetInstanceProcAddr(device.instance(), "vkDestroySurfaceKHR"), nullptr);
    EXPECT_NE(vkGetDeviceProcAddr(device.handle(), "vkCreateSwapchainKHR"), nullptr);
    EXPECT_NE(device.main_queue_handle(), nullptr);

    EXPECT_NE(
        error_of([] { Device({.instance_extensions = {"VK_NO_window"}}); }).find("VK_NO_window"),
        std::string::npos);
    EXPECT_NE(error_of([] {
        Device({.device_extensions = {"VK_NO_screen"}});
    }).find("refused: no VK_NO_screen"),
        std::string::npos);
}

TEST_F(DeviceTest, NoDriverIsADeviceError) {
    const Environment drivers("VK_DRIVER_FILES", "/nonexistent/icd.json");
    try {
        const Device device;
        FAIL() << "made a device without a driver";
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::device);
        EXPECT_NE(std::string(error.what()).find("mesa-vulkan-drivers"), std::string::npos)
            << error.what();
    }
}

TEST_F(DeviceTest, AMissingValidationLayerNamesThePackage) {
    const Environment layers("VK_LAYER_PATH", "/nonexistent");
    try {
        const Device device({.validation = Validation::core});
        FAIL() << "made a validated device without the layer";
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::device);
        EXPECT_NE(std::string(error.what()).find("vulkan-validationlayers"), std::string::npos)
            << error.what();
    }
}

TEST_F(DeviceTest, EveryValidationModeStartsAndEndsInSilence) {
    for (const Validation validation :
        {Validation::off, Validation::core, Validation::sync, Validation::gpu}) {
        std::vector<std::string> errors;
        log::set_sink([&](log::Level level, std::string_view text) {
            if (level >= log::Level::warning) errors.emplace_back(text);
        });
        {
            Device device({.validation = validation});
            const Buffer buffer(
                device, {.bytes = 100, .usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, .name = "b"});
            const Image image(device, {.format = VK_FORMAT_R8G8B8A8_UNORM,
                                          .width = 7,
                                          .height = 5,
                                          .usage = VK_IMAGE_USAGE_SAMPLED_BIT,
                                          .name = "i"});
            image.view(VK_IMAGE_VIEW_TYPE_2D_ARRAY);
            device.sampler(VK_FILTER_LINEAR, VK_SAMPLER_ADDRESS_MODE_REPEAT);
        }
        log::set_sink({});
        EXPECT_TRUE(errors.empty()) << name_of(validation) << ": " << errors.front();
    }
}

TEST_F(DeviceTest, QueuesOfFamiliesThatComputeOrCopy) {
    const std::span<const FamilyInfo> families = device().families();
    const QueueId main = device().main_queue();
    ASSERT_LT(main.family, families.size());
    EXPECT_TRUE(families[main.family].graphics && families[main.family].compute);
    for (std::uint32_t i = 0; i < families.size(); ++i) {
        EXPECT_LE(families[i].queues, i == main.family ? 2u : 1u);
        EXPECT_TRUE(families[i].queues == 0 || families[i].transfer);
        for (std::uint32_t queue = 0; queue < families[i].queues; ++queue) {
            device().submit({.queue = {i, queue}}, "nothing"); // each of them exists
        }
    }
    EXPECT_GE(families[main.family].queues, 1u);
}

TEST_F(DeviceTest, TheEnvironmentSwitchesPushDescriptorsOff) {
    const Environment unforced("OCKHAM_FORCE_DESCRIPTOR_SETS", "0");
    const Device own;
    // The same device once more, as an embedder would hand it over.
    VkPhysicalDeviceFeatures2 features{};
    VkPhysicalDeviceVulkan12Features v12{};
    VkPhysicalDeviceVulkan13Features v13{};
    features.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2;
    v12.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES;
    v13.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES;
    features.pNext = &v12;
    v12.pNext = &v13;
    features.features.shaderStorageImageExtendedFormats = VK_TRUE;
    v12.scalarBlockLayout = v12.timelineSemaphore = VK_TRUE;
    v13.synchronization2 = v13.maintenance4 = VK_TRUE;
    ExternalDevice external;
    external.physical = own.physical();
    external.device = own.handle();
    external.queues.push_back({.family = own.queue_family()});
    vkGetDeviceQueue(own.handle(), own.queue_family(), 0, &external.queues[0].handle);
    external.features = &features;
    if (own.pushes_descriptors()) external.extensions = {VK_KHR_PUSH_DESCRIPTOR_EXTENSION_NAME};
    EXPECT_EQ(Device(external).pushes_descriptors(), own.pushes_descriptors());
    const Environment forced("OCKHAM_FORCE_DESCRIPTOR_SETS", "1");
    EXPECT_FALSE(Device(external).pushes_descriptors());
    EXPECT_FALSE(Device().pushes_descriptors());
}

TEST_F(DeviceTest, ValidationReportsMistakes) {
    Device device({.validation = Validation::core});
    log::set_sink([](log::Level, std::string_view) {});
    const VkBufferCreateInfo nonsense{.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
        .pNext = nullptr,
        .flags = 0,
        .size = 0,
        .usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
        .sharingMode = VK_SHARING_MODE_EXCLUSIVE,
        .queueFamilyIndexCount = 0,
        .pQueueFamilyIndices = nullptr};
    VkBuffer buffer = VK_NULL_HANDLE;
    vkCreateBuffer(device.handle(), &nonsense, nullptr, &buffer);
    vkDestroyBuffer(device.handle(), buffer, nullptr);
    log::set_sink({});
    ASSERT_EQ(device.validation_log().count(), 1u);
    EXPECT_NE(device.validation_messages()[0].find("VkBufferCreateInfo"), std::string::npos);
}

TEST_F(DeviceTest, ResultsHaveWordsAndAdvice) {
    EXPECT_EQ(error_of([] { expect(VK_SUCCESS, "this"); }), "");
    EXPECT_EQ(error_of([] { expect(VK_INCOMPLETE, "this"); }), "");
    const std::string text = error_of([] { expect(VK_ERROR_OUT_OF_DEVICE_MEMORY, "painting"); });
    EXPECT_NE(text.find("painting failed: out of device memory"), std::string::npos) << text;
    EXPECT_NE(text.find("VK_ERROR_OUT_OF_DEVICE_MEMORY"), std::string::npos) << text;
}

} // namespace
} // namespace ockham::gpu
