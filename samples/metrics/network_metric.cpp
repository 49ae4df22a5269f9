// SPDX-License-Identifier: Apache-2.0
#include "samples/metrics/network_metric.hpp"

#include "framework/core/error.hpp"
#include "framework/core/file.hpp"
#include "framework/graph/fingerprint.hpp"
#include "framework/image_error/image_error.hpp"
#include "samples/metrics/one_line.hpp"
#include "samples/metrics/onnx_inputs.hpp"

#ifdef OCKHAM_HAS_OPENCV_DNN
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/dnn.hpp>
#endif

namespace ockham {

#ifndef OCKHAM_HAS_OPENCV_DNN

struct NetworkMetric::Network {};

std::string NetworkMetric::obstacle() {
    return "this program was built without OpenCV's dnn: apt-get install libopencv-dnn-dev, and "
           "build again";
}

NetworkMetric::NetworkMetric(const std::filesystem::path&) {
    fail_input("networks: {}", obstacle());
}

double NetworkMetric::operator()(const Image&, const Image&) { return 0; }

#else

namespace {

/// [1, 3, height, width]: R, G, B as displayed, from -1 to 1.
cv::Mat tensor(const Image& linear) {
    const Image picture = displayed(linear);
    const int sizes[] = {1, 3, picture.height(), picture.width()};
    cv::Mat values(4, sizes, CV_32F);
    float* to = values.ptr<float>();
    for (const char* name : {"R", "G", "B"})
        for (const float value : picture.plane(name)) *to++ = 2 * value - 1;
    return values;
}

} // namespace

struct NetworkMetric::Network {
    cv::dnn::Net net;
    std::vector<std::string> inputs;
};

std::string NetworkMetric::obstacle() { return {}; }

NetworkMetric::NetworkMetric(const std::filesystem::path& onnx)
    : path_(onnx), network_(std::make_unique<Network>()) {
    const std::vector<std::byte> bytes = read_file(onnx);
    const std::string_view file(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    network_->inputs = onnx_inputs(file);
    if (network_->inputs.size() != 2)
        fail_input("'{}': a network that compares pictures has two inputs; found {}: {}",
            onnx.string(), network_->inputs.size(), fmt::join(network_->inputs, ", "));
    cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT); // errors are thrown
    try {
        network_->net = cv::dnn::readNetFromONNX(file.data(), file.size());
        network_->net.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
    } catch (const cv::Exception& error) {
        fail_input("'{}' is no network that OpenCV {} runs: {}", onnx.string(), CV_VERSION,
            one_line(error.err));
    }
    Fingerprint print;
    print.mix(file);
    name_ = fmt::format("{} {:016x}", onnx.filename().string(), print.high);
}

double NetworkMetric::operator()(const Image& test, const Image& reference) {
    if (test.width() != reference.width() || test.height() != reference.height())
        fail_input("'{}': the picture has {} x {} pixels, the reference {} x {}", path_.string(),
            test.width(), test.height(), reference.width(), reference.height());
    try {
        network_->net.setInput(tensor(test), network_->inputs[0]);
        network_->net.setInput(tensor(reference), network_->inputs[1]);
        const cv::Mat output = network_->net.forward();
        const float* values = output.ptr<float>();
        double sum = 0;
        for (std::size_t i = 0; i < output.total(); ++i) sum += double{values[i]};
        return sum / static_cast<double>(output.total());
    } catch (const cv::Exception& error) {
        fail_input("'{}' does not take pictures of {} x {} pixels: {}", path_.string(),
            test.width(), test.height(), one_line(error.err));
    }
}

#endif

NetworkMetric::~NetworkMetric() = default;

} // namespace ockham
