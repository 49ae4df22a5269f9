// SPDX-License-Identifier: Apache-2.0
// What a network in an ONNX file calls the pictures it takes: OpenCV takes them by name and does
// not tell the names. No reader of networks. Called by network_metric.cpp.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace ockham {

/// Names of the graph's inputs in their order, without those that have an initial value: weights.
/// `file`: the content of an ONNX file (ModelProto). Nothing where it is damaged or something else.
std::vector<std::string> onnx_inputs(std::string_view file);

} // namespace ockham
