// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/compile/checks.hpp"
#include "framework/graph/describe.hpp"

#include <algorithm>
#include <bit>

namespace ockham {

namespace {

/// Index of the first element whose name an earlier one has, and that earlier one; kNone if none.
template <class T>
std::pair<std::uint32_t, std::uint32_t> find_duplicate(const std::vector<T>& all) {
    const std::size_t mask = std::bit_ceil(2 * all.size() + 1) - 1;
    std::vector<std::uint32_t> table(mask + 1, kNone);
    for (std::uint32_t i = 0; i < all.size(); ++i) {
        std::size_t slot = hash_of(all[i].name) & mask;
        for (; table[slot] != kNone; slot = (slot + 1) & mask)
            if (all[table[slot]].name == all[i].name) return {i, table[slot]};
        table[slot] = i;
    }
    return {kNone, kNone};
}

template <class T>
void check_names(const Declaration& declaration, const std::vector<T>& all, const char* code) {
    const auto nameless =
        std::find_if(all.begin(), all.end(), [](const T& one) { return one.name.empty(); });
    if (nameless != all.end())
        fail_misuse(
            declaration, "missing-name", "{} has no name; give it one", describe(*nameless));
    if (const auto [second, first] = find_duplicate(all); second != kNone)
        fail_misuse(declaration, code, "{} has the name of {}; rename one", describe(all[second]),
            describe(all[first]));
}

void check_buffer(const Declaration& declaration, const ResourceDecl& resource,
    const Capabilities& capabilities) {
    const std::uint64_t bytes = resource.buffer.bytes;
    if (bytes == 0)
        fail_misuse(
            declaration, "bad-size", "{} has 0 bytes; ask for at least 1", describe(resource));
    if (bytes > capabilities.max_buffer_bytes)
        fail_misuse(declaration, "bad-size", "{} has {} bytes, the device allows {}; split it",
            describe(resource), bytes, capabilities.max_buffer_bytes);
}

void check_image(const Declaration& declaration, const ResourceDecl& resource,
    const Capabilities& capabilities) {
    const ImageDesc& image = resource.image;
    const std::uint32_t largest = std::max({image.width, image.height, image.depth});
    if (std::min({image.width, image.height, image.depth, image.layers, image.mips}) == 0)
        fail_misuse(declaration, "bad-size",
            "{} is {}x{}x{} with {} layers and {} mips; each must be at least 1",
            describe(resource), image.width, image.height, image.depth, image.layers, image.mips);
    if (largest > capabilities.max_image_extent)
        fail_misuse(declaration, "bad-size",
            "{} is {}x{}x{}, the device allows {} per axis; make it smaller", describe(resource),
            image.width, image.height, image.depth, capabilities.max_image_extent);
    if (image.layers > capabilities.max_image_layers)
        fail_misuse(declaration, "bad-size", "{} has {} layers, the device allows {}; split it",
            describe(resource), image.layers, capabilities.max_image_layers);
    if (image.depth > 1 && image.layers > 1)
        fail_misuse(declaration, "bad-size",
            "{} has depth {} and {} layers; a 3D image has one layer", describe(resource),
            image.depth, image.layers);
    if (image.mips > static_cast<std::uint32_t>(std::bit_width(largest)))
        fail_misuse(declaration, "bad-size",
            "{} is {}x{}x{} with {} mips; that size has at most {}", describe(resource),
            image.width, image.height, image.depth, image.mips, std::bit_width(largest));
    if (texel_bytes(image.format) == 0)
        fail_misuse(declaration, "bad-format",
            "{} has format {}, which format.hpp does not know; use another", describe(resource),
            format_text(image.format));
}

} // namespace

void check_resources(const Declaration& declaration, const Capabilities& capabilities) {
    check_names(declaration, declaration.passes, "duplicate-pass");
    check_names(declaration, declaration.resources, "duplicate-resource");
    check_names(declaration, declaration.conditions, "duplicate-condition");
    for (const ResourceDecl& resource : declaration.resources) {
        if (resource.kind == ResourceKind::buffer)
            check_buffer(declaration, resource, capabilities);
        else
            check_image(declaration, resource, capabilities);
    }
}

} // namespace ockham
