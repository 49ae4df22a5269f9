// SPDX-License-Identifier: Apache-2.0
#include "tests/support/gpu_fixture.hpp"

#include <memory>

namespace ockham::test {

namespace {

struct Devices {
    std::unique_ptr<gpu::Device> pushing;
    std::unique_ptr<gpu::Device> with_sets;
};

Devices& devices() {
    static Devices instance;
    return instance;
}

} // namespace

gpu::Device& GpuTest::device() {
    std::unique_ptr<gpu::Device>& device = devices().pushing;
    if (!device) {
        device =
            std::make_unique<gpu::Device>(gpu::DeviceOptions{.validation = gpu::Validation::sync});
    }
    return *device;
}

gpu::Device& GpuTest::device_without_push() {
    std::unique_ptr<gpu::Device>& device = devices().with_sets;
    if (!device) {
        device = std::make_unique<gpu::Device>(
            gpu::DeviceOptions{.validation = gpu::Validation::sync, .force_descriptor_sets = true});
    }
    return *device;
}

std::vector<std::string> GpuTest::take_messages() {
    std::vector<std::string> messages;
    for (const auto& device : {devices().pushing.get(), devices().with_sets.get()}) {
        if (!device) continue;
        for (std::string& message : device->validation_log().take()) {
            messages.push_back(std::move(message));
        }
    }
    return messages;
}

void GpuTest::TearDown() {
    for (const std::string& message : take_messages()) ADD_FAILURE() << message;
}

} // namespace ockham::test
