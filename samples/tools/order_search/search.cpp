// SPDX-License-Identifier: Apache-2.0
#include "samples/tools/order_search/search.hpp"

#include "framework/core/error.hpp"
#include "framework/core/rng.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

namespace ockham::order_search {
namespace {

/// Share of the unit square around the origin with x cos + y sin < offset, and its integral from
/// -infinity. Both components >= 0; corners are cut off the square one by one.
struct HalfPlane {
    double wide, narrow; ///< the larger and the smaller component

    HalfPlane(double cosine, double sine)
        : wide(std::max(cosine, sine)), narrow(std::max(std::min(cosine, sine), 1e-9)) {}
    /// Integral of order `power` - 1 of the share: 2 for the share itself, 3 for its integral.
    double ramp(double offset, int power) const {
        const double factorial = power == 2 ? 2.0 : 6.0;
        double sum = 0;
        for (const double x : {-1.0, 1.0}) {
            for (const double y : {-1.0, 1.0}) {
                const double beyond = offset + 0.5 * (x * wide + y * narrow);
                sum += x * y * std::pow(std::max(beyond, 0.0), power);
            }
        }
        return sum / (factorial * wide * narrow);
    }
    double area(double offset) const { return ramp(offset, 2); }
    double area_integral(double offset) const { return ramp(offset, 3); }
    double reach() const { return 0.5 * (wide + narrow); }
    /// Of the squared share over all offsets, by Gauss's three points on its three pieces, on which
    /// it is a polynomial of fourth degree.
    double area_squared() const {
        const double inner = 0.5 * (wide - narrow);
        const std::array<double, 4> ends = {-reach(), -inner, inner, reach()};
        double sum = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            const double middle = 0.5 * (ends[i] + ends[i + 1]), half = ends[i + 1] - middle;
            for (const int side : {-1, 0, 1}) {
                const double a = area(middle + side * std::sqrt(0.6) * half);
                sum += half * (side == 0 ? 8.0 : 5.0) / 9.0 * a * a;
            }
        }
        return sum;
    }
};

} // namespace

Judge::Judge(int m, int angles)
    : n_(static_cast<std::uint32_t>(m * m)), pair_(std::size_t{n_} * n_), single_(n_) {
    check(m >= 1 && m <= 8 && angles > 0, "windows are 1 to 8 samples wide");
    double measure = 0;
    std::vector<double> offset(n_);
    for (int a = 0; a < angles; ++a) {
        // Half a turn: an edge and its other side have the same error.
        const double angle = std::numbers::pi * (a + 0.5) / angles;
        const double cosine = std::cos(angle), sine = std::sin(angle);
        const HalfPlane half(std::abs(cosine), std::abs(sine));
        for (std::uint32_t i = 0; i < n_; ++i) {
            const double x = (i % static_cast<std::uint32_t>(m) + 0.5) / m - 0.5;
            const double y = (i / static_cast<std::uint32_t>(m) + 0.5) / m - 0.5;
            offset[i] = x * cosine + y * sine;
        }
        // The covered half lies before the edge: sample i is in it for edges from offset[i] on.
        const double reach = half.reach(), total = half.area_integral(reach);
        for (std::uint32_t i = 0; i < n_; ++i) {
            for (std::uint32_t j = 0; j < n_; ++j)
                pair_[i * n_ + j] += reach - std::max(offset[i], offset[j]);
            single_[i] += total - half.area_integral(offset[i]);
        }
        square_ += half.area_squared();
        measure += 2.0 * reach;

        Direction direction;
        direction.place.resize(n_);
        std::iota(direction.place.begin(), direction.place.end(), 0u);
        std::sort(direction.place.begin(), direction.place.end(),
            [&](std::uint32_t i, std::uint32_t j) { return offset[i] < offset[j]; });
        for (const std::uint32_t place : direction.place)
            direction.area.push_back(half.area(offset[place]));
        directions_.push_back(std::move(direction));
    }
    for (double& v : pair_) v /= measure;
    for (double& v : single_) v /= measure;
    square_ /= measure;
}

double Judge::rms(double pair_sum, double single_sum, std::uint32_t k) const {
    return std::sqrt(
        std::max(0.0, pair_sum / (double{1} * k * k) - 2.0 * single_sum / k + square_));
}

double Judge::worst(std::uint64_t set) const {
    const double share = 1.0 / std::popcount(set);
    double most = 0;
    for (const Direction& direction : directions_) {
        // Coverage steps where the edge passes a sample: largest just before or just after.
        double covered = 0;
        for (std::uint32_t i = 0; i < n_; ++i) {
            if (!(set >> direction.place[i] & 1u)) continue;
            most = std::max(most, std::abs(covered - direction.area[i]));
            covered += share;
            most = std::max(most, std::abs(covered - direction.area[i]));
        }
    }
    return most;
}

std::vector<CoverageError> Judge::judge(const Order& order) const {
    std::vector<CoverageError> errors;
    std::uint64_t set = 0;
    double pair_sum = 0, single_sum = 0;
    for (std::uint32_t k = 1; k <= order.size(); ++k) {
        const std::uint32_t added = order[k - 1];
        for (std::uint32_t i = 0; i + 1 < k; ++i) pair_sum += 2.0 * pair(order[i], added);
        pair_sum += pair(added, added);
        single_sum += single(added);
        set |= std::uint64_t{1} << added;
        errors.push_back({rms(pair_sum, single_sum, k), worst(set)});
    }
    return errors;
}

Order best_order(const Judge& judge, Goal goal) {
    const std::uint32_t n = judge.samples();
    check(n <= 16, "all sets are visited: m <= 4");
    const std::uint32_t sets = 1u << n;
    // Least sum of errors on the way to each set, and the sample that was added last.
    std::vector<double> cost(sets, 0.0), pair_sum(sets, 0.0), single_sum(sets, 0.0);
    std::vector<std::uint8_t> last(sets, 0);
    for (std::uint32_t set = 1; set < sets; ++set) {
        const auto low = static_cast<std::uint32_t>(std::countr_zero(set));
        const std::uint32_t rest = set & (set - 1);
        pair_sum[set] = pair_sum[rest] + judge.pair(low, low);
        for (std::uint32_t bits = rest; bits; bits &= bits - 1) {
            pair_sum[set] +=
                2.0 * judge.pair(low, static_cast<std::uint32_t>(std::countr_zero(bits)));
        }
        single_sum[set] = single_sum[rest] + judge.single(low);
        double least = std::numeric_limits<double>::infinity();
        for (std::uint32_t bits = set; bits; bits &= bits - 1) {
            const double before = cost[set & ~(bits & ~(bits - 1))];
            if (before >= least) continue;
            least = before;
            last[set] = static_cast<std::uint8_t>(std::countr_zero(bits));
        }
        const auto k = static_cast<std::uint32_t>(std::popcount(set));
        cost[set] = least + (goal == Goal::rms ? judge.rms(pair_sum[set], single_sum[set], k)
                                               : judge.worst(set));
    }
    Order order(n);
    std::uint32_t set = sets - 1;
    for (std::uint32_t rank = n; rank-- > 0; set &= ~(1u << last[set])) order[rank] = last[set];
    return order;
}

namespace {

/// What annealing lowers: the sum of rms errors, and dearly what exceeds the bar of each k.
class Annealed {
public:
    Annealed(const Judge& judge, Order order, std::vector<double> bar)
        : judge_(judge), n_(judge.samples()), order_(std::move(order)), bar_(std::move(bar)) {
        recount();
    }

    const Order& order() const { return order_; }
    double cost() const { return cost_; }

    /// Change of the cost if ranks a < b were exchanged. Only sets of a + 1 ... b samples change.
    double change(std::uint32_t a, std::uint32_t b) const {
        const std::uint32_t out = order_[a], in = order_[b];
        double change = 0;
        for (std::uint32_t k = a + 1; k <= b; ++k) {
            const double* sums = &row_sums_[std::size_t{k} * n_];
            const double pairs = pair_sums_[k] - 2.0 * sums[out] + judge_.pair(out, out) +
                                 2.0 * (sums[in] - judge_.pair(out, in)) + judge_.pair(in, in);
            const double singles = single_sums_[k] - judge_.single(out) + judge_.single(in);
            change += price(judge_.rms(pairs, singles, k), k) - prices_[k];
        }
        return change;
    }
    void exchange(std::uint32_t a, std::uint32_t b) {
        std::swap(order_[a], order_[b]);
        recount();
    }

private:
    double price(double error, std::uint32_t k) const {
        return error + 1000.0 * std::max(0.0, error - bar_[k - 1]);
    }
    void recount() {
        row_sums_.assign(std::size_t{n_ + 1} * n_, 0.0);
        pair_sums_.assign(n_ + 1, 0.0);
        single_sums_ = prices_ = pair_sums_;
        cost_ = 0;
        for (std::uint32_t k = 1; k <= n_; ++k) {
            const std::uint32_t added = order_[k - 1];
            const double* before = &row_sums_[std::size_t{k - 1} * n_];
            double* sums = &row_sums_[std::size_t{k} * n_];
            for (std::uint32_t i = 0; i < n_; ++i) sums[i] = before[i] + judge_.pair(i, added);
            pair_sums_[k] = pair_sums_[k - 1] + 2.0 * before[added] + judge_.pair(added, added);
            single_sums_[k] = single_sums_[k - 1] + judge_.single(added);
            prices_[k] = price(judge_.rms(pair_sums_[k], single_sums_[k], k), k);
            cost_ += prices_[k];
        }
    }

    const Judge& judge_;
    std::uint32_t n_;
    Order order_;
    std::vector<double> bar_;
    std::vector<double> row_sums_;                         ///< [k][i]: pairs of i with the first k
    std::vector<double> pair_sums_, single_sums_, prices_; ///< [k]
    double cost_ = 0;
};

} // namespace

Order anneal_order(
    const Judge& judge, const std::vector<Order>& bars, std::uint64_t seed, std::uint32_t steps) {
    const std::uint32_t n = judge.samples();
    Order start(n);
    std::iota(start.begin(), start.end(), 0u);
    std::vector<double> bar(n, std::numeric_limits<double>::infinity());
    for (const Order& order : bars) {
        const std::vector<CoverageError> errors = judge.judge(order);
        for (std::uint32_t k = 0; k < n; ++k) bar[k] = std::min(bar[k], errors[k].rms + 1e-12);
        start = order;
    }
    Annealed state(judge, start, bar);
    Order best = state.order();
    double least = state.cost();
    Pcg32 rng(seed);
    for (std::uint32_t step = 0; step < steps; ++step) {
        const double temperature = 0.02 * std::pow(1e-5, double{1} * step / steps);
        const std::uint32_t i = rng.below(n), j = rng.below(n);
        if (i == j) continue;
        const std::uint32_t a = std::min(i, j), b = std::max(i, j);
        const double change = state.change(a, b);
        if (change > 0 && rng.uniform() >= std::exp(-change / temperature)) continue;
        state.exchange(a, b);
        if (state.cost() < least) {
            least = state.cost();
            best = state.order();
        }
    }
    return best;
}

Order void_and_cluster(int m) {
    const auto n = static_cast<std::uint32_t>(m * m);
    const auto energy = [&](std::uint32_t i, std::uint32_t j) {
        const auto wrapped = [&](int d) { return std::min(std::abs(d), m - std::abs(d)); };
        const int x = wrapped(static_cast<int>(i) % m - static_cast<int>(j) % m);
        const int y = wrapped(static_cast<int>(i) / m - static_cast<int>(j) / m);
        return std::exp(-(x * x + y * y) / (2.0 * 1.5 * 1.5));
    };
    // Each sample goes where those before it left the largest void.
    Order order;
    std::vector<double> crowd(n, 0.0);
    std::vector<bool> taken(n, false);
    for (std::uint32_t rank = 0; rank < n; ++rank) {
        std::uint32_t place = n;
        for (std::uint32_t i = 0; i < n; ++i)
            if (!taken[i] && (place == n || crowd[i] < crowd[place] - 1e-12)) place = i;
        taken[place] = true;
        order.push_back(place);
        for (std::uint32_t i = 0; i < n; ++i) crowd[i] += energy(i, place);
    }
    return order;
}

} // namespace ockham::order_search
