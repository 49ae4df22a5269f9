// SPDX-License-Identifier: Apache-2.0
// Cuts resources where uses begin and end, so that every use covers whole pieces: mips x layers of
// an image, bytes of a buffer. Phases of compile() keep content, order and layout per piece. Where
// no use names a part, a piece is a resource and costs nothing.
#pragma once

#include "framework/graph/declaration.hpp"

#include <cstdint>
#include <vector>

namespace ockham {

using PieceId = std::uint32_t;

class Pieces {
public:
    /// All parts of the declaration must lie inside their resources.
    explicit Pieces(const Declaration& declaration);

    /// Of all resources together. Those of one resource are consecutive, those of a smaller id
    /// first.
    std::uint32_t count() const { return count_; }
    /// No resource has more than one.
    bool whole() const { return grids_.empty(); }
    PieceId first(ResourceId resource) const {
        return whole() ? resource : grids_[resource].first_piece;
    }
    std::uint32_t count(ResourceId resource) const {
        return whole() ? 1 : grids_[resource].columns * grids_[resource].rows;
    }
    ResourceId resource_of(PieceId piece) const { return whole() ? piece : resources_[piece]; }
    /// Where it lies, with ends resolved.
    Part part_of(PieceId piece) const;

    /// Calls visit(PieceId) for each piece that the use covers, in ascending order.
    template <class Visit>
    void each(const Use& use, Visit visit) const {
        if (whole()) {
            visit(PieceId{use.resource});
            return;
        }
        const Grid& grid = grids_[use.resource];
        const Cells all{0, grid.columns, 0, grid.rows};
        const Cells& cells = use.part == kNone ? all : cells_[use.part];
        for (std::uint32_t row = cells.first_row; row < cells.end_row; ++row)
            for (std::uint32_t column = cells.first_column; column < cells.end_column; ++column)
                visit(grid.first_piece + row * grid.columns + column);
    }

private:
    /// Pieces of one resource. Columns: mips, or bytes of a buffer; rows: layers.
    struct Grid {
        PieceId first_piece = 0;
        std::uint32_t columns = 1, rows = 1;
        std::uint32_t first_cut = 0; ///< into cuts_: columns + 1, then rows + 1
    };
    /// The cells of its resource's grid that a part covers.
    struct Cells {
        std::uint32_t first_column = 0, end_column = 0, first_row = 0, end_row = 0;
    };

    const Declaration& declaration_;
    std::uint32_t count_ = 0;
    std::vector<Grid> grids_; ///< per resource; empty: all whole
    std::vector<std::uint64_t> cuts_;
    std::vector<Cells> cells_;          ///< per element of Declaration::parts
    std::vector<ResourceId> resources_; ///< per piece
};

} // namespace ockham
