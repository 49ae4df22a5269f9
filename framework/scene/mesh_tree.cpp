// SPDX-License-Identifier: Apache-2.0
#include "framework/scene/mesh_tree.hpp"

#include "framework/core/image.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

namespace ockham {
namespace {

constexpr int kBins = 16;
constexpr int kParts = 4;        ///< of each side, where a triangle's look varies
constexpr float kBoxCost = 1.0f; ///< in triangles

float wrapped(float x, Wrap wrap) {
    if (wrap == Wrap::clamp) return std::clamp(x, 0.0f, 1.0f);
    if (wrap == Wrap::mirror) return 1.0f - std::abs(x - 2.0f * std::floor(0.5f * x) - 1.0f);
    return x - std::floor(x);
}

/// The nearest texel, linear; 1 without an image.
glm::vec4 texel(
    const Scene& scene, const TextureUse& use, const std::array<glm::vec2, 2>& coordinates) {
    if (!use.used()) return glm::vec4(1.0f);
    const TextureImage& image = scene.images[static_cast<std::size_t>(use.image)];
    const glm::vec3 uv(coordinates[static_cast<std::size_t>(use.uv_set)], 1.0f);
    const auto place = [](float x, int size) {
        return std::clamp(static_cast<int>(x * static_cast<float>(size)), 0, size - 1);
    };
    const int x = place(wrapped(glm::dot(use.transform_u, uv), use.wrap_u), image.width);
    const int y = place(wrapped(glm::dot(use.transform_v, uv), use.wrap_v), image.height);
    const std::uint8_t* rgba =
        &image.rgba[4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) +
                            static_cast<std::size_t>(x))];
    static const std::array<float, 256> linear = [] {
        std::array<float, 256> table{};
        for (std::size_t i = 0; i < table.size(); ++i)
            table[i] = srgb_decode(static_cast<float>(i) / 255.0f);
        return table;
    }();
    return {
        linear[rgba[0]], linear[rgba[1]], linear[rgba[2]], static_cast<float>(rgba[3]) / 255.0f};
}

std::uint32_t pack_unit(const glm::vec4& v) {
    std::uint32_t word = 0;
    for (int c = 3; c >= 0; --c)
        word = word << 8 |
               static_cast<std::uint32_t>(std::lround(255.0f * std::clamp(v[c], 0.0f, 1.0f)));
    return word;
}

/// Rounded to nearest; what is brighter than 65,408 is not.
std::uint32_t pack_shared_exponent(const glm::vec3& v) {
    const glm::vec3 c = glm::clamp(v, glm::vec3(0.0f), glm::vec3(65408.0f));
    int exponent = 0;
    std::frexp(std::max({c.x, c.y, c.z}), &exponent);
    exponent = std::max(exponent, -15);
    const auto mantissa = [&](float x, int e) { return std::lround(std::ldexp(x, 9 - e)); };
    if (mantissa(std::max({c.x, c.y, c.z}), exponent) > 511) ++exponent;
    std::uint32_t word = static_cast<std::uint32_t>(exponent + 15);
    for (int i = 2; i >= 0; --i)
        word = word << 9 | static_cast<std::uint32_t>(mantissa(c[i], exponent));
    return word;
}

/// Barycentric coordinates of the middles of the kParts^2 triangles that even cuts make of one.
std::vector<glm::vec3> places_on_triangle() {
    std::vector<glm::vec3> places;
    for (int i = 0; i < kParts; ++i) {
        for (int j = 0; i + j < kParts; ++j) {
            for (int turned = 0; turned < (i + j + 1 < kParts ? 2 : 1); ++turned) {
                const float aside = static_cast<float>(1 + turned) / 3;
                const float u = (static_cast<float>(i) + aside) / kParts;
                const float v = (static_cast<float>(j) + aside) / kParts;
                places.emplace_back(1 - u - v, u, v);
            }
        }
    }
    return places;
}

template <class T>
T blend(const std::vector<T>& values, std::span<const std::uint32_t> corners,
    const glm::vec3& weights, const T& none) {
    if (values.empty()) return none;
    return weights.x * values[corners[0]] + weights.y * values[corners[1]] +
           weights.z * values[corners[2]];
}

/// What light sees of a triangle, into `out`.
void look_at_triangle(const Scene& scene, const Primitive& primitive,
    std::span<const std::uint32_t> corners, shader::MeshTriangle& out) {
    const Material& material = scene.materials[static_cast<std::size_t>(primitive.material)];
    const float ratio = (material.ior - 1.0f) / (material.ior + 1.0f);
    const bool varies = material.base_color_texture.used() || material.emissive_texture.used() ||
                        !primitive.colors.empty();
    static const std::vector<glm::vec3> all = places_on_triangle(), middle = {glm::vec3(1.0f / 3)};
    const std::vector<glm::vec3>& places = varies ? all : middle;
    glm::vec3 base(0.0f), emissive(0.0f);
    int solid = 0;
    for (const glm::vec3& weights : places) {
        const std::array<glm::vec2, 2> uv{
            blend(primitive.uvs[0], corners, weights, glm::vec2(0.0f)),
            blend(primitive.uvs[1], corners, weights, glm::vec2(0.0f))};
        const glm::vec4 color = material.base_color *
                                blend(primitive.colors, corners, weights, glm::vec4(1.0f)) *
                                texel(scene, material.base_color_texture, uv);
        if (material.masked && color.a < material.alpha_cutoff) continue;
        ++solid;
        base += glm::vec3(color);
        emissive += material.emissive * glm::vec3(texel(scene, material.emissive_texture, uv));
    }
    const float count = static_cast<float>(std::max(solid, 1));
    base /= count;
    emissive /= count;
    const glm::vec3 albedo =
        material.unlit ? glm::vec3(0.0f) : base + (1.0f - material.metallic) * ratio * ratio;
    const float share = static_cast<float>(solid) / static_cast<float>(places.size());
    out.albedo = pack_unit(glm::vec4(albedo, share));
    out.emitted = pack_shared_exponent(material.unlit ? base : emissive);
}

std::vector<shader::MeshTriangle> triangles_of(const Scene& scene) {
    std::vector<shader::MeshTriangle> out;
    out.reserve(scene.triangles());
    for (const Instance& instance : scene.instances) {
        for (const Primitive& primitive :
            scene.meshes[static_cast<std::size_t>(instance.mesh)].primitives) {
            for (std::size_t i = 0; i + 2 < primitive.indices.size(); i += 3) {
                const std::span corners(&primitive.indices[i], 3);
                const auto world = [&](std::size_t c) {
                    return glm::vec3(
                        instance.world * glm::vec4(primitive.positions[corners[c]], 1.0f));
                };
                shader::MeshTriangle t{};
                t.corner = world(0);
                t.across = world(1) - t.corner;
                t.up = world(2) - t.corner;
                const float area = glm::length(glm::cross(t.across, t.up));
                if (!(area > 0.0f) || !std::isfinite(area) || !std::isfinite(glm::length(t.corner)))
                    continue;
                look_at_triangle(scene, primitive, corners, t);
                if (t.albedo >> 24 > 0) out.push_back(t); // else all of it is a hole
            }
        }
    }
    return out;
}

float half_area(const Bounds& box) {
    const glm::vec3 e = box.high - box.low;
    return box.empty() ? 0.0f : e.x * e.y + e.y * e.z + e.z * e.x;
}
void add(Bounds& to, const Bounds& box) {
    to.low = glm::min(to.low, box.low);
    to.high = glm::max(to.high, box.high);
}

/// A triangle while the tree is being built.
struct Item {
    Bounds box;
    glm::vec3 centre;
    std::uint32_t triangle;
};

/// Where items are divided: those whose bin is below `bin` go to the low side.
struct Split {
    int axis = 0, bin = 0;
    float cost = std::numeric_limits<float>::infinity(); ///< of both sides, area times triangles
};

int bin_of(const Item& item, const Bounds& centres, int axis) {
    const float extent = centres.high[axis] - centres.low[axis];
    const float x = (item.centre[axis] - centres.low[axis]) / extent;
    return std::min(static_cast<int>(x * kBins), kBins - 1);
}

Split best_split(std::span<const Item> items, const Bounds& centres) {
    Split best;
    for (int axis = 0; axis < 3; ++axis) {
        if (!(centres.high[axis] > centres.low[axis])) continue;
        std::array<Bounds, kBins> boxes{};
        std::array<int, kBins> counts{};
        for (const Item& item : items) {
            const auto bin = static_cast<std::size_t>(bin_of(item, centres, axis));
            add(boxes[bin], item.box);
            ++counts[bin];
        }
        std::array<float, kBins> above{}; // cost of bins from this one on
        Bounds box;
        int count = 0;
        for (std::size_t i = kBins - 1; i > 0; --i) {
            add(box, boxes[i]);
            count += counts[i];
            above[i] = half_area(box) * static_cast<float>(count);
        }
        box = {};
        count = 0;
        for (std::size_t i = 1; i < kBins; ++i) {
            add(box, boxes[i - 1]);
            count += counts[i - 1];
            const float cost = half_area(box) * static_cast<float>(count) + above[i];
            const bool divides = count > 0 && count < static_cast<int>(items.size());
            if (divides && cost < best.cost) best = {axis, static_cast<int>(i), cost};
        }
    }
    return best;
}

/// Where a node's items are divided, which it sorts by side; 0: they are a leaf.
std::size_t divide(std::span<Item> items, const Bounds& box, int& axis) {
    Bounds centres;
    for (const Item& item : items) centres.add(item.centre);
    const Split split = best_split(items, centres);
    const auto count = static_cast<float>(items.size());
    axis = split.axis;
    if (items.size() <= MESH_LEAF &&
        half_area(box) * count <= kBoxCost * half_area(box) + split.cost)
        return 0;
    if (std::isinf(split.cost)) return items.size() / 2; // all in one place
    const auto middle = std::stable_partition(items.begin(), items.end(),
        [&](const Item& item) { return bin_of(item, centres, split.axis) < split.bin; });
    return static_cast<std::size_t>(middle - items.begin());
}

/// Where walks go on behind each node; parents come before their children.
void thread(std::vector<shader::MeshNode>& nodes) {
    std::fill(std::begin(nodes[0].next), std::end(nodes[0].next), MESH_END);
    for (const shader::MeshNode& node : nodes) {
        if (node.kind >= 4) continue;
        const std::size_t children = node.first / MESH_NODE_ROWS;
        for (std::uint32_t octant = 0; octant < 8; ++octant) {
            const std::uint32_t far_side = 1 - (octant >> node.kind & 1);
            nodes[children + 1 - far_side].next[octant] = node.first + far_side * MESH_NODE_ROWS;
            nodes[children + far_side].next[octant] = node.next[octant];
        }
    }
}

} // namespace

MeshTree build_mesh_tree(const Scene& scene) {
    const std::vector<shader::MeshTriangle> triangles = triangles_of(scene);
    MeshTree tree;
    if (triangles.empty()) return tree;
    std::vector<Item> items;
    items.reserve(triangles.size());
    for (const shader::MeshTriangle& t : triangles) {
        Bounds box;
        for (const glm::vec3& corner : {t.corner, t.corner + t.across, t.corner + t.up})
            box.add(corner);
        items.push_back({box, box.center(), static_cast<std::uint32_t>(items.size())});
    }
    struct Range {
        std::size_t first, count;
    };
    std::vector<Range> ranges{{0, items.size()}}; // of each node
    for (std::size_t i = 0; i < ranges.size(); ++i) {
        const Range range = ranges[i];
        const std::span part(&items[range.first], range.count);
        shader::MeshNode node{};
        Bounds box;
        for (const Item& item : part) add(box, item.box);
        node.low = box.low;
        node.high = box.high;
        int axis = 0;
        const std::size_t low_side = divide(part, box, axis);
        if (low_side == 0) {
            node.first = static_cast<std::uint32_t>(tree.triangles.size());
            node.kind = 4 * static_cast<std::uint32_t>(range.count);
            for (const Item& item : part) tree.triangles.push_back(triangles[item.triangle]);
        } else {
            node.first = MESH_NODE_ROWS * static_cast<std::uint32_t>(ranges.size());
            node.kind = static_cast<std::uint32_t>(axis);
            ranges.push_back({range.first, low_side});
            ranges.push_back({range.first + low_side, range.count - low_side});
        }
        tree.nodes.push_back(node);
    }
    for (shader::MeshNode& node : tree.nodes) { // triangles follow the nodes
        if (node.kind >= 4) {
            node.first = MESH_NODE_ROWS * static_cast<std::uint32_t>(tree.nodes.size()) +
                         MESH_TRIANGLE_ROWS * node.first;
        }
    }
    thread(tree.nodes);
    return tree;
}

} // namespace ockham
