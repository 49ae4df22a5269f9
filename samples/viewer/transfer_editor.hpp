// SPDX-License-Identifier: Apache-2.0
// A transfer function drawn over the histogram of its volume: points are dragged, added and
// removed, coloured, or come from a preset. Isovalues are lines that are dragged. Called by the
// viewer.
#pragma once

#include "framework/scene/histogram.hpp"
#include "framework/scene/transfer_function.hpp"

#include <vector>

namespace ockham::viewer {

/// What a person has done in this frame.
struct TransferEdit {
    bool transfer = false;  ///< the points are others
    bool isovalues = false; ///< so are the isovalues
};

class TransferEditor {
public:
    /// Draws, at the width there is. Points keep their order; opacity stays within [0, 1].
    TransferEdit draw(
        const Histogram& histogram, TransferFunction& transfer, std::vector<double>& isovalues);

private:
    int point_ = -1; ///< chosen
    int dragged_ = -1, dragged_iso_ = -1;
};

/// Moves a point as far as its neighbours, values in [low, high], opacity in [0, 1].
void move_point(TransferFunction& transfer, std::size_t point, double value, double opacity,
    double low, double high);

} // namespace ockham::viewer
