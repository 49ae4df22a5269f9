// SPDX-License-Identifier: Apache-2.0
#include "framework/image_error/flicker.hpp"

#include "framework/core/error.hpp"
#include "framework/image_error/image_error.hpp"

#include <cmath>
#include <string_view>
#include <utility>

namespace ockham {

void Flicker::add(const Image& test, const Image& reference) {
    check(!test.empty() && test.width() == reference.width() && test.height() == reference.height(),
        "compared images have one size");
    const Image shown = displayed(test), wanted = displayed(reference);
    std::vector<float> error;
    for (const std::string_view color : {"R", "G", "B"}) {
        const std::span<const float> a = shown.plane(color), b = wanted.plane(color);
        for (std::size_t i = 0; i < a.size(); ++i) error.push_back(a[i] - b[i]);
    }
    if (!error_.empty()) {
        check(error.size() == error_.size(), "the frames of a sequence have one size");
        for (std::size_t i = 0; i < error.size(); ++i) {
            const double change = double{error[i]} - double{error_[i]};
            sum_ += change * change;
        }
        count_ += error.size();
    }
    error_ = std::move(error);
}

double Flicker::rms() const {
    return count_ > 0 ? 255.0 * std::sqrt(sum_ / static_cast<double>(count_)) : 0.0;
}

double share_changed(std::span<const float> before, std::span<const float> after, float least) {
    check(before.size() == after.size() && !before.empty(), "compared lists are equally long");
    std::size_t changed = 0;
    for (std::size_t i = 0; i < before.size(); ++i)
        changed += std::abs(after[i] - before[i]) >= least;
    return static_cast<double>(changed) / static_cast<double>(before.size());
}

} // namespace ockham
