// SPDX-License-Identifier: Apache-2.0
// Base of every test that needs a device: one device per process, under synchronisation validation.
// Any validation message fails the test, unless it was expected and taken. The environment may ask
// for another driver or for GPU-assisted validation (cmake/AddTest.cmake).
#pragma once

#include "framework/gpu/device.hpp"
#include "framework/runtime/executor.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <vector>

namespace ockham::test {

class GpuTest : public testing::Test {
protected:
    /// Made by the first test that asks; validation is `sync`, or `gpu` if
    /// OCKHAM_TEST_VALIDATION=gpu. Its name contains OCKHAM_TEST_GPU, if that is set.
    static gpu::Device& device();
    /// Like device(), but descriptor sets come from pools.
    static gpu::Device& device_without_push();
    /// Messages of both since the last call; what is taken does not fail the test.
    static std::vector<std::string> take_messages();
    void TearDown() override;
};

/// The content of a buffer as an array of T.
template <class T>
std::vector<T> read_as(Executor& executor, BufferHandle buffer) {
    const std::vector<std::byte> bytes = executor.read(buffer);
    std::vector<T> values(bytes.size() / sizeof(T));
    std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
    return values;
}

/// Runs `statement`, which must throw Error, and returns its text; "" if it does not.
template <class Statement>
std::string error_of(Statement statement) {
    try {
        statement();
    } catch (const std::exception& error) {
        return error.what();
    }
    return "";
}

} // namespace ockham::test
