// SPDX-License-Identifier: Apache-2.0
#include "tests/support/gpu_fixture.hpp"

#include "framework/core/error.hpp"
#include "framework/core/log.hpp"

#include <cstdlib>
#include <memory>

namespace ockham::test {

namespace {

/// The devices of this process. Destroyed before main() returns: later, the validation layer's own
/// statics are gone.
class Devices : public testing::Environment {
public:
    std::unique_ptr<gpu::Device> pushing;
    std::unique_ptr<gpu::Device> with_sets;

    void TearDown() override {
        // What is left undestroyed is reported while the device goes.
        log::set_sink([](log::Level level, std::string_view text) {
            if (level == log::Level::error) ADD_FAILURE() << text;
        });
        pushing.reset();
        with_sets.reset();
        log::set_sink({});
    }
};

/// Owned by GoogleTest.
Devices* const environment = static_cast<Devices*>(testing::AddGlobalTestEnvironment(new Devices));

Devices& devices() { return *environment; }

/// The environment says what cmake/AddTest.cmake runs a test again with. A driver that is asked for
/// and absent is an error, never another one.
gpu::DeviceOptions options() {
    gpu::DeviceOptions options{.validation = gpu::Validation::sync};
    if (const char* gpu = std::getenv("OCKHAM_TEST_GPU")) options.gpu = gpu;
    if (const char* validation = std::getenv("OCKHAM_TEST_VALIDATION")) {
        check(std::string_view(validation) == name_of(gpu::Validation::gpu),
            "OCKHAM_TEST_VALIDATION is 'gpu' or absent");
        options.validation = gpu::Validation::gpu;
    }
    return options;
}

} // namespace

gpu::Device& GpuTest::device() {
    std::unique_ptr<gpu::Device>& device = devices().pushing;
    if (!device) device = std::make_unique<gpu::Device>(options());
    return *device;
}

gpu::Device& GpuTest::device_without_push() {
    std::unique_ptr<gpu::Device>& device = devices().with_sets;
    if (!device) {
        gpu::DeviceOptions with_sets = options();
        with_sets.force_descriptor_sets = true;
        device = std::make_unique<gpu::Device>(with_sets);
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
