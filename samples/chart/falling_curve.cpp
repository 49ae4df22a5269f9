// SPDX-License-Identifier: Apache-2.0
#include "samples/chart/falling_curve.hpp"

#include "framework/core/error.hpp"

#include <algorithm>
#include <cmath>

namespace ockham {

FallingCurve::FallingCurve(const std::vector<double>& prices, std::vector<double> values)
    : y_(std::move(values)) {
    check(!prices.empty() && prices.size() == y_.size(), "as many prices as values");
    for (const double price : prices) x_.push_back(std::log(price));
    std::vector<double> mean;
    std::vector<std::size_t> size;
    for (const double y : y_) {
        mean.push_back(y), size.push_back(1);
        while (mean.size() > 1 && mean[mean.size() - 2] < mean.back()) {
            const std::size_t a = size[size.size() - 2], b = size.back();
            const double sum = mean[mean.size() - 2] * static_cast<double>(a) +
                               mean.back() * static_cast<double>(b);
            mean.pop_back(), size.pop_back();
            mean.back() = sum / static_cast<double>(a + b), size.back() = a + b;
        }
    }
    std::size_t i = 0;
    for (std::size_t block = 0; block < mean.size(); ++block)
        for (std::size_t k = 0; k < size[block]; ++k) y_[i++] = mean[block];
}

double FallingCurve::at(double price) const {
    const double x = std::log(price);
    if (x <= x_.front()) return y_.front();
    if (x >= x_.back()) return y_.back();
    const auto above =
        static_cast<std::size_t>(std::upper_bound(x_.begin(), x_.end(), x) - x_.begin());
    const double t = (x - x_[above - 1]) / (x_[above] - x_[above - 1]);
    return std::lerp(y_[above - 1], y_[above], t);
}

double FallingCurve::last_at_least(double value) const {
    for (std::size_t i = y_.size(); i-- > 0;) {
        if (y_[i] < value) continue;
        if (i + 1 == y_.size()) return std::exp(x_.back());
        return std::exp(std::lerp(x_[i], x_[i + 1], (y_[i] - value) / (y_[i] - y_[i + 1])));
    }
    return std::exp(x_.front());
}

double FallingCurve::first_at_most(double value) const {
    for (std::size_t i = 0; i < y_.size(); ++i) {
        if (y_[i] > value) continue;
        if (i == 0) return std::exp(x_.front());
        return std::exp(std::lerp(x_[i - 1], x_[i], (y_[i - 1] - value) / (y_[i - 1] - y_[i])));
    }
    return std::exp(x_.back());
}

} // namespace ockham
