// SPDX-License-Identifier: Apache-2.0
// How often the values of a volume occur, and the two levels that transfer functions are laid by: a
// threshold between emptiness and matter, and percentiles. CPU only.
#pragma once

#include "framework/scene/volume.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace ockham {

struct Histogram {
    double low = 0, high = 0; ///< least and greatest value that occur, data units
    /// True: bin i counts the one value low + i * (high - low) / (bins - 1). False: the bins are
    /// equal intervals of [low, high]; each but the last is open at its upper end.
    bool discrete = false;
    std::vector<std::uint64_t> counts; ///< >= 1 bin; the first and the last are not empty

    /// The greatest value that `bin` may hold.
    double greatest(std::size_t bin) const;
    std::uint64_t total() const;
};

/// Integers with at most `bins` codes between the extremes get a bin for each code, all others
/// `bins` intervals; a constant volume has one bin. bins >= 1.
Histogram histogram(const Volume& volume, std::size_t bins = 4096);

/// The threshold that maximises the variance between two classes (Otsu 1979, equation 18), over
/// the histogram without its lowest bin, which is what scanners and simulations fill emptiness
/// with. In the middle of the values that separate equally well; halfway between the values of a
/// volume that has two; the value of a constant one.
double otsu_threshold(const Histogram& histogram);

/// The least of greatest(bin) that at least `share` (0 to 1) of the voxels do not exceed.
double percentile(const Histogram& histogram, double share);

} // namespace ockham
