// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/compile/pieces.hpp"

#include <algorithm>

namespace ockham {

namespace {

/// Of a resource along one axis: [begin, end) in bytes or mips (columns), or in layers (rows).
struct Interval {
    std::uint64_t begin, end;
};

Interval columns_of(const ResourceDecl& resource, const Part& part) {
    if (resource.kind == ResourceKind::buffer) return {part.offset, part.offset + part.bytes};
    return {part.first_mip, std::uint64_t{part.first_mip} + part.mips};
}
Interval rows_of(const ResourceDecl& resource, const Part& part) {
    if (resource.kind == ResourceKind::buffer) return {0, 1};
    return {part.first_layer, std::uint64_t{part.first_layer} + part.layers};
}

/// Appends the sorted, distinct values; returns how many intervals lie between them.
std::uint32_t append_cuts(std::vector<std::uint64_t>& cuts, std::vector<std::uint64_t>& values) {
    std::sort(values.begin(), values.end());
    values.erase(std::unique(values.begin(), values.end()), values.end());
    cuts.insert(cuts.end(), values.begin(), values.end());
    return static_cast<std::uint32_t>(values.size() - 1);
}

std::uint32_t index_of(const std::uint64_t* cuts, std::uint32_t intervals, std::uint64_t value) {
    return static_cast<std::uint32_t>(std::lower_bound(cuts, cuts + intervals, value) - cuts);
}

} // namespace

Pieces::Pieces(const Declaration& declaration)
    : declaration_(declaration), count_(static_cast<std::uint32_t>(declaration.resources.size())) {
    if (declaration.parts.empty()) return;
    const std::size_t resources = declaration.resources.size();

    // Uses that name a part, grouped by resource.
    std::vector<const Use*> uses;
    for (const Use& use : declaration.uses)
        if (use.part != kNone) uses.push_back(&use);
    std::stable_sort(uses.begin(), uses.end(),
        [](const Use* a, const Use* b) { return a->resource < b->resource; });

    grids_.resize(resources);
    cells_.resize(declaration.parts.size());
    count_ = 0;
    std::vector<std::uint64_t> columns, rows;
    auto next = uses.begin();
    for (ResourceId id = 0; id < resources;) {
        // Ages of a history change places, so they are cut alike.
        const ResourceDecl& resource = declaration.resources[id];
        const ResourceId end = id + 1 + resource.history_depth - resource.history_age;
        const auto first = next;
        while (next != uses.end() && (*next)->resource < end) ++next;

        const auto add = [&](const Part& part) {
            const Interval c = columns_of(resource, part), r = rows_of(resource, part);
            columns.insert(columns.end(), {c.begin, c.end});
            rows.insert(rows.end(), {r.begin, r.end});
        };
        columns.clear();
        rows.clear();
        add(ockham::part_of(declaration, Use{.resource = id}));
        for (auto use = first; use != next; ++use) add(ockham::part_of(declaration, **use));

        Grid grid;
        grid.first_cut = static_cast<std::uint32_t>(cuts_.size());
        grid.columns = append_cuts(cuts_, columns);
        grid.rows = append_cuts(cuts_, rows);
        const std::uint64_t* const column_cuts = cuts_.data() + grid.first_cut;
        const std::uint64_t* const row_cuts = column_cuts + grid.columns + 1;
        for (auto use = first; use != next; ++use) {
            const Part part = ockham::part_of(declaration, **use);
            const Interval c = columns_of(resource, part), r = rows_of(resource, part);
            cells_[(*use)->part] = {index_of(column_cuts, grid.columns, c.begin),
                index_of(column_cuts, grid.columns, c.end), index_of(row_cuts, grid.rows, r.begin),
                index_of(row_cuts, grid.rows, r.end)};
        }
        for (; id < end; ++id) {
            grid.first_piece = count_;
            grids_[id] = grid;
            count_ += grid.columns * grid.rows;
            resources_.resize(count_, id);
        }
    }
}

Part Pieces::part_of(PieceId piece) const {
    const ResourceId id = resource_of(piece);
    const Part all = ockham::part_of(declaration_, Use{.resource = id});
    if (whole()) return all;
    const Grid& grid = grids_[id];
    const std::uint64_t* const columns =
        cuts_.data() + grid.first_cut + (piece - grid.first_piece) % grid.columns;
    const std::uint64_t* const rows = cuts_.data() + grid.first_cut + grid.columns + 1 +
                                      (piece - grid.first_piece) / grid.columns;
    Part part = all;
    if (declaration_.resources[id].kind == ResourceKind::buffer) {
        part.offset = columns[0];
        part.bytes = columns[1] - columns[0];
    } else {
        part.first_mip = static_cast<std::uint32_t>(columns[0]);
        part.mips = static_cast<std::uint32_t>(columns[1] - columns[0]);
        part.first_layer = static_cast<std::uint32_t>(rows[0]);
        part.layers = static_cast<std::uint32_t>(rows[1] - rows[0]);
    }
    return part;
}

} // namespace ockham
