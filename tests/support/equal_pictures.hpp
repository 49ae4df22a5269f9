// SPDX-License-Identifier: Apache-2.0
// Two pictures of the same graph, bit for bit. For tests that render.
#pragma once

#include "framework/core/image.hpp"

#include <algorithm>

namespace ockham::test {

/// The same number of pixels, and equal values in R, G, B and A.
inline bool equal(const Image& a, const Image& b) {
    bool same = a.pixels() == b.pixels();
    for (int c = 0; same && c < 4; ++c) same = std::ranges::equal(a.plane(c), b.plane(c));
    return same;
}

} // namespace ockham::test
