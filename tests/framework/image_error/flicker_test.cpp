// SPDX-License-Identifier: Apache-2.0
// Flicker on sequences whose value follows from their construction.
#include "framework/core/image.hpp"
#include "framework/image_error/flicker.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace ockham {
namespace {

/// 4 x 2 pixels of one displayed grey, given as linear light.
Image grey(float displayed_value, int bright_pixels = 8) {
    Image image(4, 2, {"R", "G", "B"});
    for (int c = 0; c < 3; ++c)
        for (int i = 0; i < 8; ++i)
            image.plane(c)[static_cast<std::size_t>(i)] =
                i < bright_pixels ? srgb_decode(displayed_value) : 0.0f;
    return image;
}

TEST(Flicker, IsZeroWithoutASecondFrameAndForASteadyError) {
    Flicker flicker;
    EXPECT_EQ(flicker.rms(), 0.0);
    flicker.add(grey(0.7f), grey(0.5f));
    EXPECT_EQ(flicker.rms(), 0.0);
    flicker.add(grey(0.4f), grey(0.2f)); // the picture changes, its error does not
    EXPECT_NEAR(flicker.rms(), 0.0, 1e-4);
}

TEST(Flicker, MeasuresTheChangeOfTheErrorInDisplayCodes) {
    Flicker flicker;
    flicker.add(grey(0.5f), grey(0.5f));
    flicker.add(grey(0.6f), grey(0.5f)); // by 0.1 everywhere
    EXPECT_NEAR(flicker.rms(), 25.5, 1e-3);
    flicker.add(grey(0.6f), grey(0.5f)); // and stays
    EXPECT_NEAR(flicker.rms(), 25.5 / std::sqrt(2.0), 1e-3);
}

TEST(Flicker, IsAMeanOverPixelsAndClampsAsADisplayDoes) {
    Flicker flicker;
    flicker.add(grey(0.0f), grey(0.0f));
    flicker.add(grey(1.0f, 2), grey(0.0f)); // two of eight pixels, from black to white
    EXPECT_NEAR(flicker.rms(), 255.0 * std::sqrt(2.0 / 8.0), 1e-3);
    Image blinding = grey(1.0f, 2);
    for (float& v : blinding.plane(0)) v *= 1000.0f;
    flicker.add(blinding, grey(0.0f)); // white is white
    EXPECT_NEAR(flicker.rms(), 255.0 * std::sqrt(0.5 * 2.0 / 8.0), 1e-3);
}

TEST(ShareChanged, CountsWhatMovesByAtLeastSoMuch) {
    const std::array<float, 4> before{1, 4, 16, 2}, after{1, 5, 14, 2};
    EXPECT_EQ(share_changed(before, after, 2.0f), 0.25);
    EXPECT_EQ(share_changed(before, after, 1.0f), 0.5);
    EXPECT_EQ(share_changed(before, before, 1.0f), 0.0);
}

} // namespace
} // namespace ockham
