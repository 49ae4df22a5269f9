// SPDX-License-Identifier: Apache-2.0
#include "framework/scene/histogram.hpp"

#include "framework/core/error.hpp"
#include "framework/scene/voxels.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <type_traits>

namespace ockham {

double Histogram::greatest(std::size_t bin) const {
    if (bin + 1 >= counts.size()) return high;
    const double parts = double(counts.size()) - (discrete ? 1.0 : 0.0);
    return low + (high - low) * (double(bin) + (discrete ? 0.0 : 1.0)) / parts;
}

std::uint64_t Histogram::total() const {
    return std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
}

Histogram histogram(const Volume& volume, std::size_t bins) {
    check(bins >= 1, "a histogram has at least one bin");
    return with_voxels(volume, [&](auto values) {
        using Voxel = std::remove_cv_t<typename decltype(values)::element_type>;
        const auto [least, greatest] = std::minmax_element(values.begin(), values.end());
        const double low = *least, high = *greatest;
        Histogram result;
        result.low = volume.value_offset + volume.value_scale * low;
        result.high = volume.value_offset + volume.value_scale * high;
        result.discrete = low == high || (std::is_integral_v<Voxel> && high - low < double(bins));
        result.counts.resize(low == high       ? 1
                             : result.discrete ? static_cast<std::size_t>(high - low) + 1
                                               : bins);
        const std::size_t last = result.counts.size() - 1;
        const double per_unit = result.discrete ? 1.0 : double(bins) / (high - low);
        for (const Voxel voxel : values)
            ++result.counts[std::min(
                last, static_cast<std::size_t>((double(voxel) - low) * per_unit))];
        return result;
    });
}

double otsu_threshold(const Histogram& histogram) {
    const std::vector<std::uint64_t>& counts = histogram.counts;
    if (counts.size() == 1) return histogram.low;
    // Bin numbers stand for values: the result does not depend on scale and offset.
    double total = 0, moment = 0;
    for (std::size_t bin = 1; bin < counts.size(); ++bin) {
        total += double(counts[bin]);
        moment += double(counts[bin]) * double(bin);
    }
    double below = 0, moment_below = 0, best = 0;
    std::size_t first = 0, last = 0; // the best thresholds lie behind these bins
    for (std::size_t bin = 1; bin + 1 < counts.size(); ++bin) {
        below += double(counts[bin]);
        moment_below += double(counts[bin]) * double(bin);
        if (below == 0) continue;
        const double above = total - below; // > 0: the last bin is not empty
        const double apart = moment_below / below - (moment - moment_below) / above;
        const double variance = below * above * apart * apart;
        if (variance > best) best = variance, first = bin;
        if (variance == best) last = bin;
    }
    if (best == 0) last = counts.size() - 2; // one value beside the lowest, which is the first
    // Where bins are single values, the threshold lies halfway to the next.
    const double half = histogram.discrete ? 0.5 * (histogram.greatest(1) - histogram.low) : 0.0;
    return 0.5 * (histogram.greatest(first) + histogram.greatest(last)) + half;
}

double percentile(const Histogram& histogram, double share) {
    const double wanted = share * double(histogram.total());
    double seen = 0;
    for (std::size_t bin = 0; bin < histogram.counts.size(); ++bin) {
        seen += double(histogram.counts[bin]);
        if (seen >= wanted) return histogram.greatest(bin);
    }
    return histogram.high;
}

} // namespace ockham
