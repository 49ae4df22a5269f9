// SPDX-License-Identifier: Apache-2.0
// How small pictures in haste must be, by the time that the last ones took. Knows no picture.
// Called by the viewer.
#pragma once

#include <vector>

namespace ockham::viewer {

class HurryScale {
public:
    /// Divides the picture's sides, 1 to 16.
    int divisor() const { return divisor_; }
    /// A frame at the present divisor took so long.
    void add(double milliseconds);

    /// Of all frames, and of the later half of them.
    int count() const { return static_cast<int>(times_.size()); }
    double median_ms() const;

private:
    static constexpr double kMost = 140; ///< milliseconds: five frames a second with the rest
    static constexpr int kSmallest = 16; ///< divisor
    int divisor_ = 4;
    double slow_ = 0; ///< the frame before, where it was: the first after a change compiles kernels
    std::vector<double> times_;
};

} // namespace ockham::viewer
