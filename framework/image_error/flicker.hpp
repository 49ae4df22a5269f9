// SPDX-License-Identifier: Apache-2.0
// How restless a sequence of pictures is, each compared with the reference of its own moment: an
// error that stays is not seen as motion, one that changes is. For moving cameras.
#pragma once

#include "framework/core/image.hpp"

#include <cstddef>
#include <span>
#include <vector>

namespace ockham {

/// 255 times the root mean square, over pixels and R, G, B of all pairs of consecutive frames, of
/// the change of the error (test - reference). Displayed values: sRGB-encoded, clamped to [0,1].
/// Pixel by pixel, so meant for steps of the camera below a pixel or two.
class Flicker {
public:
    /// The next frame, linear R, G, B and its reference, all of one size.
    void add(const Image& test, const Image& reference);
    /// 0 before the second frame.
    double rms() const;

private:
    std::vector<float> error_; ///< of the frame before, R, G, B planes
    double sum_ = 0;
    std::size_t count_ = 0;
};

/// Share, in [0,1], of the numbers that differ by at least `least` between two equally long lists.
double share_changed(std::span<const float> before, std::span<const float> after, float least);

} // namespace ockham
