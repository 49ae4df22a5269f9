// SPDX-License-Identifier: Apache-2.0
// Random valid graphs of everything that can be declared, and random devices to plan them for.
// Equal seeds give equal graphs on every machine. Says nothing of what the passes record.
#pragma once

#include "framework/core/rng.hpp"
#include "framework/graph/compile.hpp"
#include "framework/graph/graph.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

namespace ockham {

/// A device and how to plan for it.
struct RandomSetting {
    Capabilities capabilities;
    Policy policy;

    explicit RandomSetting(std::uint64_t seed) {
        Pcg32 rng(seed, 2);
        // The main family is not always the first.
        const std::uint32_t kind = rng.below(6);
        const QueueFamily main{true, true, true, 1 + rng.below(2)};
        const QueueFamily compute{false, true, true, 1 + rng.below(2)};
        const QueueFamily transfer{false, false, true, 1};
        if (kind >= 2) capabilities.families = {main};
        if (kind >= 3) capabilities.families.push_back(compute);
        if (kind >= 4)
            capabilities.families.insert(capabilities.families.begin() + rng.below(3), transfer);
        constexpr std::uint64_t granularities[] = {1, 1, 1024, 65536};
        capabilities.buffer_image_granularity = granularities[rng.below(4)];
        if (rng.below(3) == 0) policy.order = Order::batched;
        constexpr double excesses[] = {0, 0.25, std::numeric_limits<double>::infinity()};
        policy.batch_memory = excesses[rng.below(3)];
        policy.alias_memory = rng.below(8) != 0;
        policy.async_queues = rng.below(8) != 0;
    }
};

struct RandomOptions {
    std::uint32_t max_passes = 24;
    std::uint32_t largest_extent = 512;     ///< of images, a power of two
    std::uint32_t largest_chunk = 1u << 20; ///< of which buffers have 1 to 4
    std::vector<VkFormat> formats{VK_FORMAT_R8_UNORM, VK_FORMAT_R16G16_SFLOAT,
        VK_FORMAT_R16G16B16A16_SFLOAT, VK_FORMAT_R32G32B32A32_SFLOAT}; ///< of colour images
    bool parts = true;
    bool histories = true;
    bool guards = true;
    bool queues = true;  ///< wishes, and imports that queue families own
    bool volumes = true; ///< 3D images
    /// Called for each pass when all its uses are declared, e.g. to record().
    std::function<void(PassBuilder&)> finish;
};

class RandomDeclaration {
public:
    RandomDeclaration(std::uint64_t seed, const RandomOptions& options = {},
        const Capabilities& capabilities = {})
        : rng_(seed), options_(options), families_(capabilities.families.size()),
          graph_(fmt::format("random {}", seed)) {
        if (options.guards)
            for (std::uint32_t i = 0, count = rng_.below(4); i < count; ++i)
                conditions_.push_back(graph_.add_condition(fmt::format("c{}", i)));
        add_outside();
        passes_left_ = 1 + rng_.below(options.max_passes);
        while (passes_left_) add_block(0);
        for (Item& item : items_)
            if (is_exportable(item) && chance(8)) export_item(item);
        for (auto item = items_.rbegin(); item != items_.rend(); ++item)
            if (is_exportable(*item)) {
                export_item(*item);
                break;
            }
    }
    Graph& graph() { return graph_; }
    const Declaration& declaration() const { return graph_.declaration(); }

private:
    /// Who may read: nobody where empty, everybody where kNone is among them.
    using Writers = std::vector<GuardId>;

    /// A resource in columns (mips, or chunks of a buffer) and rows (layers).
    struct Item {
        bool image = false;
        bool depth_format = false;
        BufferHandle buffer;
        ImageHandle picture;
        std::uint64_t chunk = 0;
        std::uint32_t columns = 1, rows = 1;
        bool transient = false;
        bool exported = false;
        std::vector<Writers> content; ///< per cell, row by row

        ResourceId id() const { return image ? picture.resource : buffer.resource; }
    };
    struct Cells {
        std::uint32_t first_column = 0, columns = 1, first_row = 0, rows = 1;
    };
    /// What the pass that is being declared does so far.
    struct Touch {
        ResourceId resource;
        Cells cells;
        bool writes;
        VkImageLayout layout;
    };

    bool chance(std::uint32_t one_in) { return rng_.below(one_in) == 0; }

    // ---- Content --------------------------------------------------------------------------------

    template <class Visit>
    static void each(Item& item, const Cells& cells, Visit visit) {
        for (std::uint32_t row = cells.first_row; row < cells.first_row + cells.rows; ++row)
            for (std::uint32_t c = cells.first_column; c < cells.first_column + cells.columns; ++c)
                visit(item.content[row * item.columns + c]);
    }

    bool is_readable(Item& item, const Cells& cells) const {
        bool readable = true;
        each(item, cells, [&](const Writers& writers) {
            bool found = false;
            for (GuardId id = guard_;; id = graph_.declaration().guards[id].parent) {
                found |= std::find(writers.begin(), writers.end(), id) != writers.end();
                if (found || id == kNone) break;
            }
            readable &= found;
        });
        return readable;
    }

    void set_written(Item& item, const Cells& cells) {
        each(item, cells, [&](Writers& writers) { add_writer(writers, guard_); });
    }

    /// Two branches of one question make what is around them.
    void add_writer(Writers& writers, GuardId guard) const {
        if (std::find(writers.begin(), writers.end(), guard) != writers.end()) return;
        writers.push_back(guard);
        if (guard == kNone) return;
        const std::vector<Guard>& guards = graph_.declaration().guards;
        for (const GuardId other : writers)
            if (other != kNone && guards[other].condition == guards[guard].condition &&
                guards[other].parent == guards[guard].parent &&
                guards[other].wanted != guards[guard].wanted) {
                add_writer(writers, guards[guard].parent);
                return;
            }
    }

    static bool is_exportable(const Item& item) {
        bool some = false;
        for (const Writers& writers : item.content) {
            const bool always = std::find(writers.begin(), writers.end(), kNone) != writers.end();
            if (!writers.empty() && !always) return false;
            some |= always;
        }
        return some && item.transient && !item.exported;
    }

    void export_item(Item& item) {
        item.exported = true;
        if (item.image)
            graph_.export_resource(item.picture, "wanted");
        else
            graph_.export_resource(item.buffer, "wanted");
    }

    // ---- Resources ------------------------------------------------------------------------------

    std::string next_name(const char* prefix) { return fmt::format("{}{}", prefix, names_++); }

    BufferDesc some_buffer(Item& item) {
        const std::uint32_t most = std::max(options_.largest_chunk / 256, 1u);
        std::uint32_t chunks = 1 + rng_.below(most);
        chunks >>= rng_.below(12); // mostly small
        item.chunk = 256 * std::uint64_t{std::max(chunks, 1u)};
        item.columns = 1 + rng_.below(4);
        // Not every buffer ends with a whole chunk.
        const std::uint64_t cut = chance(2) ? 4 * rng_.below(64) : 0;
        return {item.chunk * item.columns - cut};
    }

    std::uint32_t some_extent() {
        std::uint32_t log = 0;
        while ((2u << log) <= options_.largest_extent) ++log;
        return 1u << rng_.below(log + 1);
    }

    ImageDesc some_image(Item& item) {
        const std::vector<VkFormat>& formats = options_.formats;
        const VkFormat format = formats[rng_.below(static_cast<std::uint32_t>(formats.size()))];
        ImageDesc desc{format, some_extent(), some_extent()};
        std::uint32_t largest = std::max(desc.width, desc.height);
        if (options_.volumes && chance(10)) {
            desc.depth = 1 + rng_.below(8);
            largest = std::max(largest, desc.depth);
        } else if (chance(4)) {
            desc.layers = 1 + rng_.below(4);
        }
        if (chance(3)) {
            std::uint32_t most = 1;
            while ((largest >> most) != 0) ++most;
            desc.mips = 1 + rng_.below(std::min(most, 4u));
        }
        item.columns = desc.mips;
        item.rows = desc.layers;
        return desc;
    }

    /// Adds an item; `create` makes its handle from its description.
    Item& add_item(Item item, bool has_content) {
        item.content.assign(
            std::size_t{item.columns} * item.rows, has_content ? Writers{kNone} : Writers{});
        items_.push_back(std::move(item));
        return items_.back();
    }

    std::uint32_t add_buffer() {
        Item item;
        const BufferDesc desc = some_buffer(item);
        item.buffer = graph_.create_buffer(next_name("b"), desc);
        item.transient = true;
        add_item(item, false);
        return static_cast<std::uint32_t>(items_.size() - 1);
    }

    std::uint32_t add_image(std::optional<ImageDesc> wanted = {}) {
        Item item;
        item.image = true;
        ImageDesc desc = some_image(item);
        if (wanted) {
            desc = *wanted;
            item.columns = desc.mips;
            item.rows = desc.layers;
            item.depth_format = desc.format == VK_FORMAT_D32_SFLOAT;
        }
        item.picture = graph_.create_image(next_name("i"), desc);
        item.transient = true;
        add_item(item, false);
        return static_cast<std::uint32_t>(items_.size() - 1);
    }

    AccessState some_state(bool image, bool entry) {
        constexpr Access choices[] = {Access::storage_write, Access::storage_read,
            Access::transfer_write, Access::transfer_read, Access::sampled};
        AccessState state = state_of(choices[rng_.below(image ? 5 : 4)], Stage::compute);
        if (entry && chance(4)) { // the caller has waited
            state.stages = 0;
            state.access = 0;
        }
        if (!image) state.layout = VK_IMAGE_LAYOUT_UNDEFINED;
        if (options_.queues && families_ > 1 && chance(3))
            state.queue_family = rng_.below(static_cast<std::uint32_t>(families_));
        return state;
    }

    AccessState some_exit(bool image) {
        return chance(2) ? some_state(image, false) : AccessState{};
    }

    void add_outside() {
        for (std::uint32_t i = 0, count = rng_.below(3); i < count; ++i) {
            Item item;
            if (chance(2)) {
                const BufferDesc desc = some_buffer(item);
                item.buffer = graph_.create_persistent_buffer(next_name("pb"), desc);
            } else {
                item.image = true;
                const ImageDesc desc = some_image(item);
                item.picture = graph_.create_persistent_image(next_name("pi"), desc);
            }
            add_item(item, true);
        }
        for (std::uint32_t i = 0, count = rng_.below(3); i < count; ++i) {
            Item item;
            if (chance(2)) {
                const BufferDesc desc = some_buffer(item);
                const AccessState entry = some_state(false, true), exit = some_exit(false);
                item.buffer = graph_.import_buffer(next_name("xb"), desc, entry, exit);
                add_item(item, true);
            } else {
                item.image = true;
                const ImageDesc desc = some_image(item);
                AccessState entry = some_state(true, true);
                if (chance(5)) entry.layout = VK_IMAGE_LAYOUT_UNDEFINED;
                const AccessState exit = some_exit(true);
                item.picture = graph_.import_image(next_name("xi"), desc, entry, exit);
                add_item(item, entry.layout != VK_IMAGE_LAYOUT_UNDEFINED);
            }
        }
        if (!options_.histories) return;
        for (std::uint32_t i = 0, count = rng_.below(3); i < count; ++i) {
            Item item;
            const std::uint32_t depth = 1 + rng_.below(3);
            if (chance(2)) {
                const BufferDesc desc = some_buffer(item);
                const auto ring = graph_.create_history_buffer(next_name("hb"), desc, depth);
                item.buffer = ring.now;
                add_item(item, true);
                for (const BufferHandle& previous : ring.previous) {
                    item.buffer = previous;
                    add_item(item, true);
                }
            } else {
                item.image = true;
                const ImageDesc desc = some_image(item);
                const auto ring = graph_.create_history_image(next_name("hi"), desc, depth);
                item.picture = ring.now;
                add_item(item, true);
                for (const ImageHandle& previous : ring.previous) {
                    item.picture = previous;
                    add_item(item, true);
                }
            }
        }
    }

    // ---- Parts ----------------------------------------------------------------------------------

    /// Some cells of the item: of images `one_mip` and `one_layer` where asked.
    Cells some_cells(const Item& item, bool one_mip = false, bool one_layer = false) {
        Cells cells{0, item.columns, 0, item.rows};
        if (item.image && one_mip) cells = {rng_.below(item.columns), 1, 0, item.rows};
        if (item.image && one_layer) {
            cells.first_row = rng_.below(item.rows);
            cells.rows = 1;
        }
        if (!options_.parts || chance(2)) return cells;
        const auto narrow = [&](std::uint32_t& first, std::uint32_t& count) {
            const std::uint32_t begin = rng_.below(count);
            count = 1 + rng_.below(count - begin);
            first += begin;
        };
        narrow(cells.first_column, cells.columns);
        narrow(cells.first_row, cells.rows);
        return cells;
    }

    /// Without parts, what must be one mip or layer can only be an image that has one.
    bool fits(const Item& item, bool one_mip, bool one_layer) const {
        return options_.parts || !item.image ||
               ((!one_mip || item.columns == 1) && (!one_layer || item.rows == 1));
    }

    static bool is_whole(const Item& item, const Cells& cells) {
        return cells.columns == item.columns && cells.rows == item.rows;
    }

    BufferPart buffer_part(const Item& item, const Cells& cells) const {
        if (is_whole(item, cells)) return item.buffer;
        const bool rest = cells.first_column + cells.columns == item.columns;
        return item.buffer.range(
            cells.first_column * item.chunk, rest ? kRest : cells.columns * item.chunk);
    }

    static ImagePart image_part(const Item& item, const Cells& cells) {
        if (is_whole(item, cells)) return item.picture;
        ImagePart part = item.picture;
        if (cells.columns != item.columns) part = part.mips(cells.first_column, cells.columns);
        if (cells.rows != item.rows) part = part.layers(cells.first_row, cells.rows);
        return part;
    }

    /// Whether the pass may use the cells besides what it does already.
    bool is_free(const Item& item, const Cells& cells, bool writes, VkImageLayout layout) const {
        return std::none_of(touched_.begin(), touched_.end(), [&](const Touch& touch) {
            const Cells& other = touch.cells;
            const bool apart = touch.resource != item.id() ||
                               other.first_column >= cells.first_column + cells.columns ||
                               cells.first_column >= other.first_column + other.columns ||
                               other.first_row >= cells.first_row + cells.rows ||
                               cells.first_row >= other.first_row + other.rows;
            return !apart && (writes || touch.writes || (item.image && touch.layout != layout));
        });
    }

    /// Claims cells of an item that exists and is mostly recent, for reading what is there
    /// (`needs`) or for writing.
    struct Claim {
        std::uint32_t item = kNone;
        Cells cells;
        explicit operator bool() const { return item != kNone; }
    };
    Claim claim(bool image, bool needs, bool writes, VkImageLayout layout, bool one_mip = false,
        bool one_layer = false) {
        if (items_.empty()) return {};
        for (int attempt = 0; attempt < 6; ++attempt) {
            const auto size = static_cast<std::uint32_t>(items_.size());
            const std::uint32_t recent = chance(4) ? size : std::max(size / 3, 1u);
            const std::uint32_t index = size - 1 - rng_.below(recent);
            Item& item = items_[index];
            if (item.image != image || !fits(item, one_mip, one_layer)) continue;
            if (item.depth_format && layout != VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL) continue;
            const Cells cells = some_cells(item, one_mip, one_layer);
            if (needs && !is_readable(item, cells)) continue;
            if (!is_free(item, cells, writes, layout)) continue;
            return claim_of(index, cells, writes, layout);
        }
        return {};
    }
    Claim claim_of(std::uint32_t index, const Cells& cells, bool writes, VkImageLayout layout) {
        touched_.push_back({items_[index].id(), cells, writes, layout});
        return {index, cells};
    }
    /// Cells of a new resource, to write.
    Claim claim_new(
        bool image, VkImageLayout layout, bool one_mip = false, bool one_layer = false) {
        std::uint32_t index = image ? add_image() : add_buffer();
        while (!fits(items_[index], one_mip, one_layer)) index = add_image();
        return claim_of(index, some_cells(items_[index], one_mip, one_layer), true, layout);
    }

    // ---- Passes ---------------------------------------------------------------------------------

    /// Passes, and blocks of them under conditions.
    void add_block(std::uint32_t depth) {
        const std::uint32_t count = 1 + rng_.below(4);
        for (std::uint32_t i = 0; i < count && passes_left_; ++i) {
            if (!conditions_.empty() && depth < 3 && chance(4)) {
                const Condition condition =
                    conditions_[rng_.below(static_cast<std::uint32_t>(conditions_.size()))];
                if (chance(2)) {
                    const GuardScope scope = graph_.when(condition);
                    add_block(depth + 1);
                } else {
                    const GuardScope scope = graph_.unless(condition);
                    add_block(depth + 1);
                }
            } else {
                add_pass();
            }
        }
    }

    void add_pass() {
        --passes_left_;
        touched_.clear();
        const std::uint32_t kind = rng_.below(10);
        if (kind < 6)
            add_compute();
        else if (kind < 8)
            add_raster();
        else
            add_transfer();
    }

    void begin(PassBuilder& pass, bool may_run_aside, bool transfer) {
        guard_ = graph_.declaration().passes.back().guard;
        if (chance(20)) pass.side_effect("by chance");
        if (!options_.queues || !may_run_aside || !chance(2)) return;
        pass.prefer(transfer && chance(2) ? QueueWish::transfer : QueueWish::async_compute);
    }
    void end(PassBuilder& pass) {
        if (options_.finish) options_.finish(pass);
    }

    static constexpr VkImageLayout kGeneral = VK_IMAGE_LAYOUT_GENERAL;
    static constexpr VkImageLayout kReadOnly = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;

    void add_reads(PassBuilder& pass, Stage stage) {
        for (std::uint32_t i = 0, count = rng_.below(4); i < count; ++i) {
            const std::string name = fmt::format("r{}", i);
            if (chance(2)) {
                const Claim from = claim(false, true, false, VK_IMAGE_LAYOUT_UNDEFINED);
                if (!from) continue;
                const BufferPart part = buffer_part(items_[from.item], from.cells);
                const std::uint32_t how = rng_.below(stage == Stage::compute ? 6 : 8);
                if (how == 0)
                    pass.indirect(part);
                else if (how == 1)
                    pass.uniform(name, part, stage);
                else if (how == 6)
                    pass.vertices(part);
                else if (how == 7)
                    pass.indices(part);
                else
                    pass.read(name, part, stage);
            } else if (chance(4)) {
                if (const Claim from = claim(true, true, false, kGeneral, true))
                    pass.read(name, image_part(items_[from.item], from.cells), stage);
            } else if (const Claim from = claim(true, true, false, kReadOnly)) {
                pass.sample(name, image_part(items_[from.item], from.cells), stage);
            }
        }
    }

    void add_shader_write(PassBuilder& pass, const std::string& name, Stage stage) {
        const bool image = chance(2);
        const bool change = chance(4);
        Claim to;
        if (change || chance(3)) to = claim(image, change, true, kGeneral, true);
        const bool read_write = to && change;
        if (!to) to = claim_new(image, kGeneral, true);
        Item& item = items_[to.item];
        if (image) {
            const ImagePart part = image_part(item, to.cells);
            item.picture =
                read_write ? pass.read_write(name, part, stage) : pass.write(name, part, stage);
        } else {
            const BufferPart part = buffer_part(item, to.cells);
            item.buffer =
                read_write ? pass.read_write(name, part, stage) : pass.write(name, part, stage);
        }
        set_written(item, to.cells);
    }

    void add_compute() {
        auto pass = graph_.add_compute_pass(next_name("compute"));
        begin(pass, true, false);
        add_reads(pass, Stage::compute);
        for (std::uint32_t i = 0, count = 1 + rng_.below(2); i < count; ++i)
            add_shader_write(pass, fmt::format("w{}", i), Stage::compute);
        end(pass);
    }

    void add_raster() {
        auto pass = graph_.add_raster_pass(next_name("raster"));
        begin(pass, false, false);
        add_reads(pass, chance(3) ? Stage::vertex : Stage::fragment);
        constexpr VkImageLayout layout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
        auto load = static_cast<LoadOp>(rng_.below(3));
        Claim to;
        if (chance(3)) to = claim(true, load == LoadOp::load, true, layout, true, true);
        if (to && graph_.desc(items_[to.item].picture).depth > 1) to = {};
        if (!to) {
            load = chance(2) ? LoadOp::clear : LoadOp::discard;
            Item shape;
            ImageDesc desc = some_image(shape);
            desc.depth = 1;
            desc.mips = options_.parts ? desc.mips : 1;
            desc.layers = options_.parts ? desc.layers : 1;
            std::uint32_t most = 1;
            while ((std::max(desc.width, desc.height) >> most) != 0) ++most;
            desc.mips = std::min(desc.mips, most);
            const std::uint32_t index = add_image(desc);
            to = claim_of(index, some_cells(items_[index], true, true), true, layout);
        }
        const ImageDesc desc = graph_.desc(items_[to.item].picture);
        items_[to.item].picture = pass.color(image_part(items_[to.item], to.cells), load);
        set_written(items_[to.item], to.cells);
        if (chance(2)) {
            const std::uint32_t index = add_image(
                ImageDesc{VK_FORMAT_D32_SFLOAT, std::max(desc.width >> to.cells.first_column, 1u),
                    std::max(desc.height >> to.cells.first_column, 1u)});
            items_[index].picture = pass.depth(items_[index].picture, 0);
            set_written(items_[index], {});
        }
        if (chance(4)) add_shader_write(pass, "w", Stage::fragment);
        end(pass);
    }

    void add_transfer() {
        auto pass = graph_.add_transfer_pass(next_name("transfer"));
        begin(pass, true, true);
        if (const Claim from = claim(false, true, false, VK_IMAGE_LAYOUT_UNDEFINED))
            pass.copy_from(buffer_part(items_[from.item], from.cells));
        if (chance(2))
            if (const Claim from = claim(true, true, false, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL))
                pass.copy_from(image_part(items_[from.item], from.cells));
        for (std::uint32_t i = 0, count = 1 + rng_.below(2); i < count; ++i) {
            const bool image = chance(3);
            constexpr VkImageLayout layout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
            Claim to;
            if (chance(2)) to = claim(image, false, true, layout);
            if (!to) to = claim_new(image, layout);
            Item& item = items_[to.item];
            if (image)
                item.picture = pass.copy_to(image_part(item, to.cells));
            else
                item.buffer = pass.copy_to(buffer_part(item, to.cells));
            set_written(item, to.cells);
        }
        end(pass);
    }

    Pcg32 rng_;
    RandomOptions options_;
    std::size_t families_;
    Graph graph_;
    std::vector<Condition> conditions_;
    std::vector<Item> items_;
    std::vector<Touch> touched_;
    GuardId guard_ = kNone; ///< of the pass that is being declared
    std::uint32_t passes_left_ = 0;
    std::uint32_t names_ = 0;
};

} // namespace ockham
