// SPDX-License-Identifier: Apache-2.0
// Metrics of other programs: VMAF through a program that stands for FFmpeg, and through a real one
// where configure was given it; networks in ONNX files, written here byte by byte.
#include "framework/core/error.hpp"
#include "framework/core/file.hpp"
#include "framework/core/process.hpp"
#include "samples/metrics/network_metric.hpp"
#include "samples/metrics/onnx_inputs.hpp"
#include "samples/metrics/vmaf.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>

namespace ockham {
namespace {

namespace fs = std::filesystem;

/// A checker with `noise` in codes of 8 bits on it.
Image picture(int width, int height, float noise = 0) {
    Image image(width, height, {"R", "G", "B"});
    std::mt19937 random(1);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const float uniform = static_cast<float>(random()) * 0x1p-32f - 0.5f;
            const float code = ((x / 16 + y / 16) % 2 == 0 ? 0.35f : 0.65f) +
                               0.1f * std::sin(0.3f * static_cast<float>(x)) +
                               noise / 255 * std::sqrt(12.0f) * uniform;
            for (int c = 0; c < 3; ++c) image.at(x, y, c) = srgb_decode(code);
        }
    return image;
}

template <typename Call>
void expect_refused(Call call, const std::string& part) {
    try {
        call();
        ADD_FAILURE() << "not refused: " << part;
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
}

/// A program that answers as FFmpeg does, with 97 for equal films and 50 for others.
class FakeFfmpeg : public testing::Test {
protected:
    fs::path ffmpeg(const std::string& option, const std::string& run) const {
        const fs::path path = folder_.path() / "ff mpeg";
        write_text(path, "#!/bin/sh\nif [ \"$2\" = -h ]; then echo '" + option +
                             " <string> libvmaf'; exit 0; fi\n" + run);
        fs::permissions(path, fs::perms::owner_all);
        return path;
    }
    std::string scores() const {
        return "echo \"$*\" > '" + (folder_.path() / "arguments").string() + "'\ncp test.y4m '" +
               folder_.path().string() +
               "'\ncmp -s test.y4m reference.y4m && score=97 || score=50\n"
               "echo '{\"version\":\"1.2\",\"frames\":[{\"metrics\":{\"vmaf\":'$score'}}]}' "
               "> log.json\n";
    }
    std::string arguments() const { return read_text(folder_.path() / "arguments"); }
    TemporaryFolder folder_;
};

TEST_F(FakeFfmpeg, IsGivenBothFilmsAndTheModel) {
    const fs::path model = folder_.path() / "a model, [odd]: 'name'.pkl";
    write_text(model, "model");
    const Vmaf vmaf(ffmpeg("   model_path  ", scores()), model);
    EXPECT_EQ(vmaf.made_by(), model.filename().string() + ", libvmaf 1.2");
    EXPECT_EQ(vmaf(picture(32, 18), picture(32, 18)), 97);
    EXPECT_EQ(vmaf(picture(32, 18, 9), picture(32, 18)), 50);
    EXPECT_NE(arguments().find(":model_path=model.pkl "), std::string::npos) << arguments();

    const Vmaf newer(ffmpeg("   model  ", scores()), model);
    EXPECT_EQ(newer(picture(32, 18), picture(32, 18)), 97);
    EXPECT_NE(arguments().find(":model=path=model.pkl "), std::string::npos) << arguments();
}

TEST_F(FakeFfmpeg, FilmsAreOneFrameOfLumaInVideoRange) {
    const Vmaf vmaf(ffmpeg("   model  ", scores()));
    Image image(16, 16, {"R", "G", "B"});
    image.at(0, 0, 0) = image.at(0, 0, 1) = image.at(0, 0, 2) = 2; // clamped
    image.at(1, 0, 1) = 1;
    image.at(2, 0, 2) = std::nanf("");
    (void)vmaf(image, image);
    const std::string film = read_text(folder_.path() / "test.y4m");
    const std::string heading = "YUV4MPEG2 W16 H16 F25:1 Ip A1:1 C444\nFRAME\n";
    ASSERT_TRUE(film.starts_with(heading));
    ASSERT_EQ(film.size(), heading.size() + 3 * 256);
    const auto byte = [&](std::size_t i) {
        return static_cast<unsigned char>(film[heading.size() + i]);
    };
    EXPECT_EQ(byte(0), 235);
    EXPECT_EQ(byte(1), 173) << "green: 16 + 219 * 0.7152";
    EXPECT_EQ(byte(3), 16);
    EXPECT_EQ(byte(256), 128);
    EXPECT_EQ(arguments().find("model="), std::string::npos) << "its own";
}

TEST_F(FakeFfmpeg, ReasonsAreGivenWhereThereIsNoScore) {
    expect_refused([] { Vmaf vmaf("no-such-ffmpeg"); }, "no program 'no-such-ffmpeg'");
    expect_refused([] { Vmaf vmaf("/bin/true"); }, "no FFmpeg with libvmaf");
    expect_refused([&] { Vmaf vmaf(ffmpeg(" model ", "echo no model; exit 1")); },
        "libvmaf's own model: no model");
    expect_refused([&] { Vmaf vmaf(ffmpeg(" model ", "echo '{}' > log.json")); }, "no score");
    expect_refused(
        [&] { Vmaf vmaf(ffmpeg(" model ", scores()), "no/model.json"); }, "no/model.json");
    const Vmaf vmaf(ffmpeg(" model ", scores()));
    expect_refused([&] { (void)vmaf(picture(32, 18), picture(18, 32)); }, "32 x 18");
    expect_refused([&] { (void)vmaf(picture(32, 8), picture(32, 8)); }, "16 x 16 or more");
}

#ifdef OCKHAM_FFMPEG
TEST(RealFfmpeg, EqualPicturesScoreHighAndNoiseLowersIt) {
    const Vmaf vmaf(OCKHAM_FFMPEG, OCKHAM_VMAF_MODEL);
    const Image reference = picture(192, 144);
    double last = vmaf(reference, reference);
    EXPECT_NEAR(last, 97.43, 0.01) << "a film of one frame, by v0.6.1";
    for (const float noise : {2.0f, 8.0f, 20.0f}) {
        const double score = vmaf(picture(192, 144, noise), reference);
        EXPECT_LT(score, last - 1) << noise;
        last = score;
    }
    EXPECT_GT(last, 0);
}
#endif

// protobuf: what a small writer needs.
std::string varint(std::uint64_t value) {
    std::string bytes;
    for (; value >= 0x80; value >>= 7) bytes += static_cast<char>((value & 0x7f) | 0x80);
    return bytes += static_cast<char>(value);
}
std::string number(unsigned field, std::uint64_t value) {
    return varint(field << 3) + varint(value);
}
std::string bytes(unsigned field, const std::string& content) {
    return varint(field << 3 | 2) + varint(content.size()) + content;
}

/// [1, 3, height, width], the last two free.
std::string tensor_type(const std::string& name) {
    const std::string shape = bytes(1, number(1, 1)) + bytes(1, number(1, 3)) +
                              bytes(1, bytes(2, "height")) + bytes(1, bytes(2, "width"));
    return bytes(1, name) + bytes(2, bytes(1, number(1, 1) + bytes(2, shape)));
}
std::string node(const std::string& type, const std::vector<std::string>& in,
    const std::string& out, const std::string& attributes = {}) {
    std::string text;
    for (const std::string& name : in) text += bytes(1, name);
    return bytes(1, text + bytes(2, out) + bytes(3, out) + bytes(4, type) + attributes);
}

/// Mean of |1 (r - r') + 2 (g - g') + 3 (b - b')| over pixels, as a network: a 1 x 1 convolution of
/// the difference.
std::string weighted_difference() {
    std::string weights;
    for (const float value : {1.0f, 2.0f, 3.0f}) {
        char raw[4];
        std::memcpy(raw, &value, 4);
        weights.append(raw, 4);
    }
    const std::string tensor = number(1, 1) + number(1, 3) + number(1, 1) + number(1, 1) +
                               number(2, 1) + bytes(8, "weights") + bytes(9, weights);
    const std::string kernel =
        bytes(5, bytes(1, "kernel_shape") + number(8, 1) + number(8, 1) + number(20, 7));
    const std::string graph =
        node("Sub", {"picture", "reference"}, "difference") +
        node("Conv", {"difference", "weights"}, "sum", kernel) + node("Abs", {"sum"}, "size") +
        node("GlobalAveragePool", {"size"}, "distance") + bytes(2, "weighted_difference") +
        bytes(5, tensor) + bytes(11, tensor_type("picture")) + bytes(11, tensor_type("reference")) +
        bytes(11, tensor_type("weights")) + bytes(12, tensor_type("distance"));
    return number(1, 7) + bytes(7, graph) + bytes(8, bytes(1, "") + number(2, 11));
}

TEST(OnnxInputs, AreThePicturesWithoutTheWeights) {
    const std::string file = weighted_difference();
    EXPECT_EQ(onnx_inputs(file), (std::vector<std::string>{"picture", "reference"}));
    EXPECT_TRUE(onnx_inputs("").empty());
    for (std::size_t size = 0; size < file.size(); ++size)
        EXPECT_LE(onnx_inputs(file.substr(0, size)).size(), 2u) << size;
    std::string endless(20, '\xff');
    EXPECT_TRUE(onnx_inputs(endless).empty());
}

#ifdef OCKHAM_HAS_OPENCV_DNN
TEST(NetworkMetric, MeasuresWhatTheNetworkComputes) {
    const TemporaryFolder folder;
    const fs::path path = folder.path() / "small.onnx";
    write_text(path, weighted_difference());
    NetworkMetric metric(path);
    EXPECT_TRUE(metric.name().starts_with("small.onnx ")) << metric.name();
    EXPECT_EQ(metric.name().size(), std::strlen("small.onnx ") + 16);
    Image white(12, 7, {"R", "G", "B"}), black(12, 7, {"R", "G", "B"});
    for (int c = 0; c < 3; ++c)
        for (float& value : white.plane(c)) value = c == 2 ? 1.5f : 0.0f; // blue, clamped
    EXPECT_NEAR(metric(white, black), 6, 1e-5) << "3 (1 - -1)";
    EXPECT_NEAR(metric(black, white), 6, 1e-5);
    EXPECT_EQ(metric(white, white), 0);
    white.at(0, 0, 0) = 1;
    EXPECT_NEAR(metric(white, black), 6 + 2.0 / (12 * 7), 1e-5);
    // Another size, and the order of the channels' weights.
    EXPECT_NEAR(metric(picture(20, 30), picture(20, 30)), 0, 1e-6);

    // The fingerprint tells networks of one name apart.
    std::string other = weighted_difference();
    other.replace(other.find("weighted"), 8, "WEIGHTED");
    write_text(path, other);
    EXPECT_NE(NetworkMetric(path).name(), metric.name());
}

TEST(NetworkMetric, RefusesWhatIsNoSuchNetwork) {
    const TemporaryFolder folder;
    const fs::path path = folder.path() / "bad.onnx";
    expect_refused([&] { NetworkMetric metric(path); }, "bad.onnx");
    write_text(path, "no network");
    expect_refused([&] { NetworkMetric metric(path); }, "has two inputs; found 0");
    std::string unknown = weighted_difference();
    unknown.replace(unknown.find("GlobalAveragePool"), 17, "NoSuchThingAtAll!");
    write_text(path, unknown);
    expect_refused([&] { NetworkMetric metric(path); }, "no network that OpenCV");
    write_text(path, weighted_difference());
    NetworkMetric metric(path);
    expect_refused([&] { metric(picture(4, 4), picture(5, 4)); }, "4 x 4");
}
#else
TEST(NetworkMetric, SaysWhatIsMissing) {
    expect_refused([] { NetworkMetric metric("any.onnx"); }, "libopencv-dnn-dev");
}
#endif

} // namespace
} // namespace ockham
