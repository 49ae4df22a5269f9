// SPDX-License-Identifier: Apache-2.0
// The distance of two pictures by a neural network, such as LPIPS, out of an ONNX file that the
// user has: this program brings none. Run on the processor by OpenCV's dnn, where it was built with
// that. Called by compare and chart.
#pragma once

#include "framework/core/image.hpp"

#include <filesystem>
#include <memory>
#include <string>

namespace ockham {

class NetworkMetric {
public:
    /// Why this build has none of it, and what to do; empty: it has.
    static std::string obstacle();

    /// Of two inputs, [1, 3, height, width] each: R, G, B as displayed, from -1 to 1, as LPIPS
    /// takes them, the picture first. Its output is a number, or a map whose mean counts. Throws
    /// Error(input) naming the file and what is wrong with it.
    explicit NetworkMetric(const std::filesystem::path& onnx);
    ~NetworkMetric();

    /// Of two pictures of one size. Throws Error(input) where the network does not take it.
    double operator()(const Image& test, const Image& reference);

    /// "lpips_alex.onnx 1a2b3c4d5e6f7081": the file's name and a fingerprint of its content, for no
    /// two networks of that name need be the same.
    const std::string& name() const { return name_; }

private:
    struct Network;
    std::filesystem::path path_;
    std::string name_;
    std::unique_ptr<Network> network_;
};

} // namespace ockham
