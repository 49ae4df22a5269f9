// SPDX-License-Identifier: Apache-2.0
#include "samples/viewer/hurry_scale.hpp"

#include <algorithm>
#include <cmath>

namespace ockham::viewer {

void HurryScale::add(double milliseconds) {
    times_.push_back(milliseconds);
    if (milliseconds > kMost) {
        if (slow_ > 0 && divisor_ < kSmallest) {
            // As if all of it were pixels; at most half the side at once, and then another look.
            const double factor = std::sqrt(std::min(slow_, milliseconds) / kMost);
            const int enough = static_cast<int>(std::ceil(divisor_ * std::min(factor, 2.0)));
            divisor_ = std::clamp(enough, divisor_ + 1, kSmallest);
            slow_ = 0;
        } else {
            slow_ = milliseconds;
        }
        return;
    }
    slow_ = 0;
    const double finer = divisor_ > 1 ? static_cast<double>(divisor_) / (divisor_ - 1) : 1e9;
    if (milliseconds * finer * finer < 0.6 * kMost) --divisor_;
}

double HurryScale::median_ms() const {
    if (times_.empty()) return 0;
    std::vector<double> later(times_.begin() + std::ssize(times_) / 2, times_.end());
    const auto middle = later.begin() + std::ssize(later) / 2;
    std::ranges::nth_element(later, middle);
    return *middle;
}

} // namespace ockham::viewer
