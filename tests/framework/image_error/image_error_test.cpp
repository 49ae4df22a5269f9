// SPDX-License-Identifier: Apache-2.0
// The metrics against values of the programs that define them, and the front door's contract.
#include "framework/core/error.hpp"
#include "framework/image_error/image_error.hpp"
#include "framework/image_error/mse.hpp"
#include "tests/framework/image_error/test_pictures.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

namespace ockham {
namespace {

namespace pictures = test_pictures;

struct Expected {
    const char* name;
    pictures::Picture (*make)();
    double mse; // of bytes
    double psnr, ssim, ssim_rgb, flip, flip_max;
};

class KnownPicture : public testing::TestWithParam<Expected> {};

TEST_P(KnownPicture, HasTheValuesOfTheReferencePrograms) {
    const Expected& expected = GetParam();
    const ImageError error = image_error(expected.make().linear(), pictures::reference().linear());
    EXPECT_NEAR(error.mse * 255.0 * 255.0, expected.mse, expected.mse * 1e-6);
    EXPECT_NEAR(error.psnr, expected.psnr, 1e-4);
    EXPECT_NEAR(error.ssim, expected.ssim, 1e-5);
    EXPECT_NEAR(error.ssim_rgb, expected.ssim_rgb, 1e-5);
    EXPECT_NEAR(error.flip.mean, expected.flip, 5e-5);
    EXPECT_NEAR(error.flip.max, expected.flip_max, 5e-5);
    EXPECT_FALSE(error.hdr);
    EXPECT_FALSE(error.hdr_flip.has_value());
    EXPECT_EQ(error.non_finite, 0u);
}

INSTANTIATE_TEST_SUITE_P(ImageError, KnownPicture,
    testing::Values(
        Expected{"noise", pictures::noise, 81.558304, 29.0161, .705971, .561081, .094552, .309520},
        Expected{
            "shift", pictures::shift, 1158.055837, 17.4935, .906778, .901673, .091699, .982335},
        Expected{"blur", pictures::blur, 443.398427, 21.6629, .938602, .932397, .070789, .602035},
        Expected{"bias", pictures::bias, 58.365133, 30.4693, .996268, .980935, .156592, .272804}),
    [](const auto& param_info) { return param_info.param.name; });

struct ExpectedHdr {
    const char* name;
    Image (*make)();
    double flip, relmse, mse;
};

class KnownHdrPicture : public testing::TestWithParam<ExpectedHdr> {};

TEST_P(KnownHdrPicture, HasTheValuesOfTheReferencePrograms) {
    const ExpectedHdr& expected = GetParam();
    const Image test = expected.make(), reference = pictures::hdr_reference();
    const ImageError error = image_error(test, reference);
    EXPECT_TRUE(error.hdr);
    ASSERT_TRUE(error.hdr_flip.has_value());
    EXPECT_NEAR(error.hdr_flip->mean, expected.flip, 5e-5);
    EXPECT_NEAR(error.hdr_flip->start_exposure, -2.8057, 1e-4);
    EXPECT_NEAR(error.hdr_flip->stop_exposure, .1659, 1e-4);
    EXPECT_EQ(error.hdr_flip->exposures, 3);
    EXPECT_NEAR(error.relmse, expected.relmse, 1e-6);
    EXPECT_NEAR(mse(test, reference), expected.mse, 1e-6);
}

INSTANTIATE_TEST_SUITE_P(ImageError, KnownHdrPicture,
    testing::Values(ExpectedHdr{"noise", pictures::hdr_noise, .087695, .018465, .430851},
        ExpectedHdr{"bias", pictures::hdr_bias, .136286, .0087595, .202361}),
    [](const auto& param_info) { return param_info.param.name; });

TEST(ImageError, EqualPicturesHaveNone) {
    const Image image = pictures::reference().linear();
    const ImageError error = image_error(image, image);
    EXPECT_EQ(error.mse, 0.0);
    EXPECT_EQ(error.psnr, std::numeric_limits<double>::infinity());
    EXPECT_NEAR(error.ssim, 1.0, 1e-12);
    EXPECT_NEAR(error.ssim_rgb, 1.0, 1e-12);
    EXPECT_EQ(error.flip.mean, 0.0);
    EXPECT_EQ(error.flip.max, 0.0);
    EXPECT_EQ(error.max, 0.0);
    EXPECT_EQ(error.p99, 0.0);
    EXPECT_EQ(error.relmse, 0.0);
}

TEST(ImageError, WhiteAgainstBlackIsTheLargest) {
    Image white(16, 16, {"R", "G", "B"});
    for (int c = 0; c < 3; ++c) std::ranges::fill(white.plane(c), 1.0f);
    const ImageError error = image_error(white, Image(16, 16, {"R", "G", "B"}));
    // To single precision: srgb_encode(1) is one unit in the last place below 1.
    EXPECT_NEAR(error.mse, 1.0, 2e-7);
    EXPECT_NEAR(error.psnr, 0.0, 1e-6);
    EXPECT_FLOAT_EQ(static_cast<float>(error.max), 1.0f);
    EXPECT_FLOAT_EQ(static_cast<float>(error.p99), 1.0f);
    EXPECT_NEAR(error.ssim, 1e-4, 2e-6); // C1 / (1 + C1), of a luma of .9999
    EXPECT_LE(error.flip.max, 1.0);
    EXPECT_GT(error.flip.mean, 0.9);
}

TEST(ImageError, P99IgnoresOnePercentOfThePixels) {
    const Image reference(40, 25, {"R", "G", "B"});
    Image test = reference;
    for (std::size_t i = 0; i < 10; ++i) test.plane("G")[i * 97] = 1.0f;
    ImageError error = image_error(test, reference);
    EXPECT_FLOAT_EQ(static_cast<float>(error.max), 1.0f);
    EXPECT_EQ(error.p99, 0.0);
    test.plane("G")[1] = 1.0f;
    error = image_error(test, reference);
    EXPECT_FLOAT_EQ(static_cast<float>(error.p99), 1.0f);
}

TEST(ImageError, OtherChannelsDoNotCount) {
    const Image reference(8, 8, {"R", "G", "B"});
    Image test(8, 8, {"depth.Z", "B", "G", "R", "A"});
    test.plane("depth.Z")[3] = std::numeric_limits<float>::infinity();
    test.plane("A")[5] = 0.5f;
    const ImageError error = image_error(test, reference);
    EXPECT_EQ(error.mse, 0.0);
    EXPECT_EQ(error.non_finite, 0u);
}

TEST(ImageError, TinyPicturesHaveFiniteValues) {
    for (const auto& [width, height] : {std::pair{1, 1}, std::pair{7, 5}, std::pair{300, 2}}) {
        Image test(width, height, {"R", "G", "B"});
        test.at(0, 0, 1) = 0.5f;
        const ImageError error = image_error(test, Image(width, height, {"R", "G", "B"}));
        EXPECT_GT(error.mse, 0.0);
        EXPECT_TRUE(std::isfinite(error.ssim) && error.ssim < 1.0) << width << " x " << height;
        EXPECT_TRUE(std::isfinite(error.flip.mean) && error.flip.mean > 0)
            << width << " x " << height;
    }
}

TEST(ImageError, NonFinitePixelsCountAsOne) {
    const Image reference = pictures::reference().linear();
    Image test = reference;
    test.at(3, 4, 0) = std::numeric_limits<float>::quiet_NaN();
    test.at(200, 100, 2) = std::numeric_limits<float>::infinity();
    const ImageError error = image_error(test, reference);
    const double share = 2.0 / (256.0 * 256.0);
    EXPECT_EQ(error.non_finite, 2u);
    EXPECT_NEAR(error.mse, share, share * 1e-6);
    EXPECT_EQ(error.max, 1.0);
    EXPECT_NEAR(error.relmse, share, share * 1e-6);
    EXPECT_EQ(error.flip.max, 1.0);
    EXPECT_EQ(error.map.at(3, 4, 0), 1.0f);
    EXPECT_EQ(error.map.at(4, 4, 0), 0.0f);
    EXPECT_EQ(error.flip.map.at(3, 4, 0), 1.0f);
    EXPECT_EQ(error.flip.map.at(200, 100, 0), 1.0f);
    EXPECT_GE(error.flip.mean, share);
    EXPECT_TRUE(std::isfinite(error.ssim));
    EXPECT_LT(error.ssim, 1.0);
}

TEST(ImageError, NonFinitePixelsCountInHdrFlip) {
    const Image reference = pictures::hdr_reference();
    Image test = reference;
    test.at(3, 4, 0) = -std::numeric_limits<float>::infinity();
    const ImageError error = image_error(test, reference);
    ASSERT_TRUE(error.hdr_flip.has_value());
    EXPECT_EQ(error.hdr_flip->map.at(3, 4, 0), 1.0f);
    EXPECT_EQ(error.hdr_flip->max, 1.0);
    EXPECT_TRUE(std::isfinite(error.hdr_flip->mean));
}

TEST(ImageError, HdrFlipStaysFiniteForBlackAndHugeValues) {
    const Image black(8, 8, {"R", "G", "B"});
    Image huge = black;
    huge.at(1, 1, 0) = std::numeric_limits<float>::max();
    huge.at(2, 2, 1) = -1.0f;
    for (const HdrFlip& result : {hdr_flip(huge, black), hdr_flip(black, huge)}) {
        EXPECT_TRUE(std::isfinite(result.mean));
        EXPECT_GT(result.max, 0.5);
        EXPECT_LE(result.max, 1.0);
    }
    EXPECT_EQ(hdr_flip(black, black).mean, 0.0);
}

std::string message_of(const Image& test, const Image& reference) {
    try {
        image_error(test, reference);
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::input);
        return error.what();
    }
    return "no error";
}

TEST(ImageError, RefusesWhatCannotBeCompared) {
    const Image image(4, 3, {"R", "G", "B"});
    EXPECT_EQ(message_of(image, Image(5, 3, {"R", "G", "B"})),
        "cannot compare: the test picture has 4 x 3 pixels, the reference 5 x 3");
    EXPECT_EQ(message_of(Image(), Image()),
        "cannot compare: the test picture has 0 x 0 pixels, the reference 0 x 0");
    EXPECT_EQ(message_of(Image(4, 3, {"R", "Y"}), image),
        "cannot compare: the test picture has no channel G, only R, Y");
    Image bad = image;
    bad.at(2, 1, 0) = std::numeric_limits<float>::quiet_NaN();
    EXPECT_EQ(message_of(image, bad),
        "cannot compare: 1 of 12 pixels of the reference are not finite (the first at x 2, y 1)");
}

} // namespace
} // namespace ockham
