// SPDX-License-Identifier: Apache-2.0
// A measured quantity that should never rise with a price, over log price: made so where noise says
// otherwise, read between its points and backwards. What choices by charts stand on. Called by
// aa_choice and volume_choice.
#pragma once

#include <vector>

namespace ockham {

class FallingCurve {
public:
    /// `prices`: above 0, rising strictly; as many `values`. At least one. Where values rise,
    /// neighbours are averaged: the nearest sequence that falls (isotonic regression).
    FallingCurve(const std::vector<double>& prices, std::vector<double> values);

    /// Linear over log price; beyond the ends these hold.
    double at(double price) const;
    /// The largest price whose value is at least `value`; the smallest there is where none is.
    double last_at_least(double value) const;
    /// The smallest price whose value is at most `value`; the largest there is where none is.
    double first_at_most(double value) const;
    double most() const { return y_.front(); }
    double least() const { return y_.back(); }

private:
    std::vector<double> x_, y_; ///< log price, value
};

} // namespace ockham
