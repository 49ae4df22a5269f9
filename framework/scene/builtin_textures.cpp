// SPDX-License-Identifier: Apache-2.0
#include "framework/scene/builtin_textures.hpp"

#include "framework/scene/shapes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace ockham {

namespace {

constexpr int kSize = 512;

double smooth(double low, double high, double x) {
    const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

/// A number in [0, 1) for integer coordinates.
double hash01(int x, int y, std::uint32_t seed) {
    std::uint32_t h = static_cast<std::uint32_t>(x) * 0x9e3779b1u ^
                      static_cast<std::uint32_t>(y) * 0x85ebca77u ^ seed * 0xc2b2ae3du;
    h = (h ^ (h >> 15)) * 0x2c1b3c6du;
    h = (h ^ (h >> 12)) * 0x297a2d39u;
    return ((h ^ (h >> 15)) >> 8) * 0x1p-24;
}

/// A square field of numbers that repeats.
class Field {
public:
    explicit Field(int size = kSize, double value = 0.0)
        : size_(size), values_(std::size_t(size) * size, value) {}
    int size() const { return size_; }
    double& at(int x, int y) { return values_[std::size_t(y) * size_ + x]; }
    double at(int x, int y) const { return values_[std::size_t(y) * size_ + x]; }
    double wrapped(int x, int y) const { return at((x + size_) % size_, (y + size_) % size_); }

private:
    int size_;
    std::vector<double> values_;
};

/// Adds `amplitude` times value noise of `cells_x` by `cells_y` cells, in [-1, 1].
void add_octave(Field& field, int cells_x, int cells_y, double amplitude, std::uint32_t seed) {
    const int size = field.size();
    std::vector<double> row(size);
    std::vector<int> column(size);
    for (int x = 0; x < size; ++x) {
        const double u = double(x) * cells_x / size;
        column[x] = static_cast<int>(u);
        row[x] = smooth(0.0, 1.0, u - column[x]);
    }
    std::vector<double> upper(cells_x + 1), lower(cells_x + 1);
    for (int y = 0; y < size; ++y) {
        const double v = double(y) * cells_y / size;
        const int j = static_cast<int>(v);
        const double fraction = smooth(0.0, 1.0, v - j);
        for (int i = 0; i <= cells_x; ++i) {
            const double a = hash01(i % cells_x, j, seed);
            const double b = hash01(i % cells_x, (j + 1) % cells_y, seed);
            upper[i] = (a + (b - a) * fraction) * 2.0 - 1.0;
        }
        for (int x = 0; x < size; ++x)
            field.at(x, y) +=
                amplitude * (upper[column[x]] + (upper[column[x] + 1] - upper[column[x]]) * row[x]);
    }
}

/// Four octaves of noise from `cells` cells on, about [-1, 1].
Field noise(int cells_x, int cells_y, std::uint32_t seed, int size = kSize) {
    Field field(size);
    double amplitude = 0.5;
    for (int octave = 0; octave < 4; ++octave, amplitude *= 0.5)
        add_octave(field, std::min(cells_x << octave, size), std::min(cells_y << octave, size),
            amplitude, seed + octave);
    return field;
}

std::uint8_t byte_of(double value) {
    return static_cast<std::uint8_t>(std::clamp(value, 0.0, 1.0) * 255.0 + 0.5);
}

template <class PixelAt>
TextureImage image_of(std::string name, int size, PixelAt&& pixel_at) {
    TextureImage image{std::move(name), size, size, {}};
    image.rgba.reserve(std::size_t(size) * size * 4);
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x) {
            const glm::dvec4 pixel = pixel_at(x, y);
            for (int c = 0; c < 4; ++c) image.rgba.push_back(byte_of(pixel[c]));
        }
    return image;
}

/// Normal map of heights in metres over `metres` of width. Row y grows downwards while green
/// points up, hence the sign of the second slope.
TextureImage normal_map(std::string name, const Field& height, double metres) {
    const double scale = height.size() / (2.0 * metres);
    return image_of(std::move(name), height.size(), [&](int x, int y) {
        const double slope_u = (height.wrapped(x + 1, y) - height.wrapped(x - 1, y)) * scale;
        const double slope_v = (height.wrapped(x, y + 1) - height.wrapped(x, y - 1)) * scale;
        const double length = std::sqrt(slope_u * slope_u + slope_v * slope_v + 1.0);
        return glm::dvec4(
            -slope_u / length * 0.5 + 0.5, slope_v / length * 0.5 + 0.5, 0.5 / length + 0.5, 1.0);
    });
}

glm::dvec4 tone(glm::dvec3 srgb, double gain) { return {srgb * gain, 1.0}; }

/// One brick, block or tile of a bond: its random numbers and how deep a point lies inside it.
struct BondCell {
    double inside; ///< metres to the nearest joint centre
    int id_x, id_y;
};

/// Rows of equal cells; every other row is moved by `shift` of a cell. All lengths in metres.
BondCell bond_at(double u, double v, double metres, double width, double height, double shift) {
    const int row = static_cast<int>(std::floor(v / height));
    const double moved = u / width + (row % 2 != 0 ? shift : 0.0);
    const int columns = static_cast<int>(metres / width + 0.5);
    const int column = static_cast<int>(std::floor(moved));
    const double du = (moved - column) * width;
    const double dv = v - row * height;
    return {std::min(std::min(du, width - du), std::min(dv, height - dv)), column % columns, row};
}

} // namespace

TextureImage checker_image(int size) {
    return image_of("checker", size, [&](int x, int y) {
        const double value = (2 * x < size) == (2 * y < size) ? 0.0 : 1.0;
        return glm::dvec4(value, value, value, 1.0);
    });
}

SurfaceImages ashlar_images() {
    constexpr double kMetres = 2.0;
    const Field stain = noise(4, 4, 11);
    const Field grain = noise(48, 48, 12);
    Field height;
    SurfaceImages images;
    images.color = image_of("ashlar_color", kSize, [&](int x, int y) {
        const double u = (x + 0.5) * kMetres / kSize;
        const double v = (y + 0.5) * kMetres / kSize;
        const BondCell cell = bond_at(u, v, kMetres, 1.0, 0.5, 0.5);
        const double face = smooth(0.004, 0.014, cell.inside + 0.003 * grain.at(x, y));
        const double tint = hash01(cell.id_x, cell.id_y, 13);
        height.at(x, y) = 0.010 * face + 0.0016 * grain.at(x, y) + 0.003 * stain.at(x, y);
        const glm::dvec3 stone =
            glm::mix(glm::dvec3(0.86, 0.78, 0.65), glm::dvec3(0.78, 0.71, 0.60), tint);
        return tone(
            stone, (0.74 + 0.26 * face) * (0.97 + 0.07 * stain.at(x, y) + 0.08 * grain.at(x, y) +
                                              0.08 * (hash01(cell.id_x, cell.id_y, 14) - 0.5)));
    });
    images.normal = normal_map("ashlar_normal", height, kMetres);
    return images;
}

SurfaceImages brick_images() {
    constexpr double kMetres = 1.0;
    const Field stain = noise(5, 5, 21);
    const Field grain = noise(64, 64, 22);
    Field height;
    SurfaceImages images;
    images.color = image_of("brick_color", kSize, [&](int x, int y) {
        const double u = (x + 0.5) * kMetres / kSize;
        const double v = (y + 0.5) * kMetres / kSize;
        const BondCell cell = bond_at(u, v, kMetres, 0.25, 0.0625, 0.5);
        const double face = smooth(0.004, 0.009, cell.inside + 0.002 * grain.at(x, y));
        const double tint = hash01(cell.id_x, cell.id_y, 23);
        height.at(x, y) = 0.007 * face + 0.0012 * grain.at(x, y) +
                          0.002 * face * hash01(cell.id_x, cell.id_y, 24);
        const glm::dvec3 clay =
            glm::mix(glm::dvec3(0.67, 0.43, 0.33), glm::dvec3(0.74, 0.55, 0.42), tint);
        const glm::dvec3 color = glm::mix(glm::dvec3(0.66, 0.62, 0.55), clay, face);
        return tone(color, 0.95 + 0.10 * stain.at(x, y) + 0.14 * grain.at(x, y));
    });
    images.normal = normal_map("brick_normal", height, kMetres);
    return images;
}

SurfaceImages limestone_images() {
    constexpr double kMetres = 1.0;
    const Field bed = noise(3, 12, 31);
    const Field grain = noise(64, 64, 32);
    Field height;
    SurfaceImages images;
    images.color = image_of("limestone_color", kSize, [&](int x, int y) {
        const double pit = smooth(0.38, 0.62, grain.at(x, y));
        height.at(x, y) = 0.0012 * bed.at(x, y) - 0.0012 * pit + 0.0004 * grain.at(x, y);
        return tone(
            {0.84, 0.78, 0.68}, 0.96 + 0.08 * bed.at(x, y) + 0.04 * grain.at(x, y) - 0.10 * pit);
    });
    images.normal = normal_map("limestone_normal", height, kMetres);
    return images;
}

SurfaceImages plaster_images() {
    constexpr double kMetres = 2.0;
    const Field patch = noise(3, 3, 41);
    const Field trowel = noise(10, 24, 42);
    Field height;
    SurfaceImages images;
    images.color = image_of("plaster_color", kSize, [&](int x, int y) {
        height.at(x, y) = 0.004 * trowel.at(x, y) + 0.003 * patch.at(x, y);
        const glm::dvec3 wash = glm::mix(glm::dvec3(0.86, 0.76, 0.60), glm::dvec3(0.78, 0.66, 0.52),
            smooth(-0.4, 0.5, patch.at(x, y)));
        return tone(wash, 0.97 + 0.05 * trowel.at(x, y));
    });
    images.normal = normal_map("plaster_normal", height, kMetres);
    return images;
}

SurfaceImages paving_images() {
    constexpr double kMetres = 2.0;
    constexpr double kSlab = 0.5;
    const Field vein = noise(6, 6, 51);
    const Field grain = noise(56, 56, 52);
    Field height;
    Field rough;
    SurfaceImages images;
    images.color = image_of("paving_color", kSize, [&](int x, int y) {
        const double u = (x + 0.5) * kMetres / kSize;
        const double v = (y + 0.5) * kMetres / kSize;
        const BondCell slab = bond_at(u, v, kMetres, kSlab, kSlab, 0.0);
        // Lozenge insets at the slabs' corners.
        const double cu = std::abs(u / kSlab - std::floor(u / kSlab + 0.5)) * kSlab;
        const double cv = std::abs(v / kSlab - std::floor(v / kSlab + 0.5)) * kSlab;
        const double lozenge = (0.11 - cu - cv) * 0.7071;
        const bool inset = lozenge > 0.0;
        const double depth = inset ? lozenge : std::min(slab.inside, -lozenge);
        const double face = smooth(0.002, 0.007, depth);
        const int corner_x = static_cast<int>(std::floor(u / kSlab + 0.5)) & 3;
        const int corner_y = static_cast<int>(std::floor(v / kSlab + 0.5)) & 3;
        const double tint =
            inset ? hash01(corner_x, corner_y, 53) : hash01(slab.id_x, slab.id_y, 54);
        const glm::dvec3 stone =
            inset ? glm::mix(glm::dvec3(0.30, 0.22, 0.20), glm::dvec3(0.36, 0.27, 0.24), tint)
                  : glm::mix(glm::dvec3(0.75, 0.68, 0.58), glm::dvec3(0.66, 0.61, 0.53), tint);
        const double line = std::abs(vein.at(x, y));
        height.at(x, y) = 0.004 * face + 0.0005 * grain.at(x, y) + 0.002 * tint;
        rough.at(x, y) = 0.42 + 0.16 * (1.0 - face) + 0.14 * grain.at(x, y) +
                         0.22 * smooth(0.0, 0.5, vein.at(x, y)) - (inset ? 0.08 : 0.0);
        return tone(
            stone, (0.55 + 0.45 * face) * (1.0 - 0.07 * smooth(0.05, 0.0, line) +
                                              0.07 * vein.at(x, y) + 0.07 * grain.at(x, y)));
    });
    images.normal = normal_map("paving_normal", height, kMetres);
    images.roughness = image_of("paving_roughness", kSize, [&](int x, int y) {
        return glm::dvec4(1.0, std::clamp(rough.at(x, y), 0.3, 0.9), 0.0, 1.0);
    });
    return images;
}

SurfaceImages quarry_images() {
    constexpr double kMetres = 1.0;
    const Field stain = noise(4, 4, 61);
    const Field grain = noise(64, 64, 62);
    Field height;
    SurfaceImages images;
    images.color = image_of("quarry_color", kSize, [&](int x, int y) {
        const double u = (x + 0.5) * kMetres / kSize;
        const double v = (y + 0.5) * kMetres / kSize;
        const BondCell tile = bond_at(u, v, kMetres, 0.25, 0.25, 0.0);
        const double face = smooth(0.002, 0.007, tile.inside);
        const double tint = hash01(tile.id_x, tile.id_y, 63);
        height.at(x, y) = 0.004 * face + 0.0006 * grain.at(x, y) + 0.0015 * stain.at(x, y);
        const bool dark = ((tile.id_x + tile.id_y) & 1) != 0;
        const glm::dvec3 clay =
            dark ? glm::mix(glm::dvec3(0.46, 0.27, 0.21), glm::dvec3(0.52, 0.33, 0.25), tint)
                 : glm::mix(glm::dvec3(0.66, 0.47, 0.34), glm::dvec3(0.71, 0.54, 0.40), tint);
        return tone(glm::mix(glm::dvec3(0.42, 0.38, 0.33), clay, face),
            1.0 + 0.10 * stain.at(x, y) + 0.06 * grain.at(x, y));
    });
    images.normal = normal_map("quarry_normal", height, kMetres);
    return images;
}

SurfaceImages roof_images() {
    constexpr double kMetres = 1.0;
    const Field stain = noise(6, 6, 71);
    const Field grain = noise(64, 64, 72);
    Field height;
    SurfaceImages images;
    images.color = image_of("roof_color", kSize, [&](int x, int y) {
        const double u = (x + 0.5) / kSize * 5.0; // 0.2 m wide tiles
        const double v = (y + 0.5) / kSize * 3.0; // rows of 0.33 m
        const int column = static_cast<int>(u);
        const int row = static_cast<int>(v);
        const double across = (u - column) * 2.0 - 1.0;
        const double along = v - row;
        const double cover = 1.0 - across * across; // parabola for the round
        const double tint = hash01(column, row, 73);
        height.at(x, y) = 0.05 * cover + 0.025 * along + 0.001 * grain.at(x, y);
        const double shade =
            (0.55 + 0.45 * smooth(0.0, 0.5, cover)) * (0.7 + 0.3 * smooth(0.0, 0.12, along));
        return tone(glm::mix(glm::dvec3(0.64, 0.36, 0.25), glm::dvec3(0.76, 0.52, 0.38), tint),
            shade * (1.0 + 0.12 * stain.at(x, y) + 0.10 * grain.at(x, y)));
    });
    images.normal = normal_map("roof_normal", height, kMetres);
    return images;
}

SurfaceImages wood_images() {
    constexpr double kMetres = 1.0;
    const Field fibre = noise(40, 3, 81);
    Field height;
    SurfaceImages images;
    images.color = image_of("wood_color", kSize, [&](int x, int y) {
        const double u = (x + 0.5) / kSize * 6.0;
        const int plank = static_cast<int>(u);
        const double inside = 0.5 - std::abs(u - plank - 0.5);
        const double face = smooth(0.01, 0.06, inside);
        height.at(x, y) = 0.006 * face + 0.0015 * fibre.at(x, y);
        return tone({0.40, 0.27, 0.18},
            (0.4 + 0.6 * face) * (0.85 + 0.35 * hash01(plank, 0, 82) + 0.30 * fibre.at(x, y)));
    });
    images.normal = normal_map("wood_normal", height, kMetres);
    return images;
}

SurfaceImages cloth_images() {
    const Field fade = noise(4, 4, 91);
    Field height;
    SurfaceImages images;
    images.color = image_of("cloth_color", kSize, [&](int x, int y) {
        const double u = (x + 0.5) / kSize;
        const double v = (y + 0.5) / kSize;
        const double edge = std::min(u, 1.0 - u);
        // Lozenges, six across, with a dot inside; a border on both selvages and at the hem.
        const double a = u * 6.0 + v * 6.0;
        const double b = u * 6.0 - v * 6.0;
        const double la = std::abs(a - std::floor(a) - 0.5);
        const double lb = std::abs(b - std::floor(b) - 0.5);
        double gold = std::max(smooth(0.44, 0.46, la), smooth(0.44, 0.46, lb));
        gold = std::max(gold, smooth(0.16, 0.14, std::sqrt(la * la + lb * lb)));
        const double frame = std::min(edge, std::min(v, 1.0 - v) * 1.0);
        if (frame < 0.075) gold = smooth(0.030, 0.026, std::abs(frame - 0.042));
        const double weave = ((x / 2 + y / 2) & 1) != 0 ? 1.0 : 0.0;
        height.at(x, y) = 0.0006 * weave + 0.0012 * gold;
        const glm::dvec3 color =
            glm::mix(glm::dvec3(0.60, 0.60, 0.60), glm::dvec3(1.0, 0.93, 0.72), gold);
        return tone(color, 0.94 + 0.06 * weave + 0.10 * fade.at(x, y));
    });
    images.normal = normal_map("cloth_normal", height, 1.0);
    return images;
}

SurfaceImages sprig_images() {
    constexpr int kSprig = 256;
    const Field mottle = noise(16, 16, 101, kSprig);
    struct Leaf {
        glm::dvec2 base, along; ///< unit square, v down; `along` from base to tip
        double width;
    };
    std::vector<Leaf> leaves;
    for (int i = 0; i < 4; ++i)
        for (int side = -1; side <= 1; side += 2) {
            const double v = 0.86 - 0.19 * i - (side > 0 ? 0.06 : 0.0);
            const double reach = 0.36 - 0.035 * i;
            leaves.push_back({{0.5, v}, {side * reach, -0.13 - 0.02 * i}, 0.20 - 0.015 * i});
        }
    leaves.push_back({{0.5, 0.26}, {0.01, -0.24}, 0.17});
    SurfaceImages images;
    images.color = image_of("sprig_color", kSprig, [&](int x, int y) {
        const glm::dvec2 p((x + 0.5) / kSprig, (y + 0.5) / kSprig);
        const double m = mottle.at(x, y);
        const glm::dvec3 green(0.42 + 0.06 * m, 0.55 + 0.07 * m, 0.20 + 0.04 * m);
        glm::dvec4 pixel(green, 0.0); // green outside too, so that filtering finds no dark rim
        if (std::abs(p.x - 0.5) < 0.009 && p.y > 0.2) pixel = {0.36, 0.34, 0.18, 1.0};
        double best = 0.0;
        for (const Leaf& leaf : leaves) {
            const double length = std::sqrt(glm::dot(leaf.along, leaf.along));
            const glm::dvec2 axis = leaf.along / length;
            const double s = glm::dot(p - leaf.base, axis) / length;
            if (s <= 0.0 || s >= 1.0) continue;
            const double t = glm::dot(p - leaf.base, glm::dvec2(-axis.y, axis.x)) / length;
            // Half width: a pointed oval, widest a third along.
            const double half = leaf.width / length * 1.45 * (1.0 - s) * std::sqrt(s);
            const double inside = (half - std::abs(t)) * length * kSprig; // pixels
            const double alpha = std::clamp(inside + 0.5, 0.0, 1.0);
            if (alpha <= best) continue;
            best = alpha;
            const double ribs = (s - std::abs(t) * 0.9) * 9.0;
            const double rib = smooth(0.16, 0.06, std::abs(ribs - std::floor(ribs) - 0.5));
            const double middle = smooth(0.035, 0.012, std::abs(t));
            const double light = 0.90 + 0.18 * s + 0.12 * std::max(rib, 1.6 * middle);
            pixel = {green * light, std::max(alpha, pixel.w)};
        }
        return pixel;
    });
    return images;
}

SurfaceImages blades_images() {
    constexpr int kBlades = 256;
    constexpr int kCount = 14;
    const Field mottle = noise(16, 16, 111, kBlades);
    SurfaceImages images;
    images.color = image_of("blades_color", kBlades, [&](int x, int y) {
        const double u = (x + 0.5) / kBlades;
        const double up = 1.0 - (y + 0.5) / kBlades; // from the foot
        const glm::dvec3 green =
            glm::mix(glm::dvec3(0.30, 0.40, 0.16), glm::dvec3(0.55, 0.66, 0.28), up);
        double alpha = 0.0, light = 1.0;
        for (int i = 0; i < kCount; ++i) {
            const double height = 0.55 + 0.42 * hash01(i, 0, 112);
            if (up >= height) continue;
            const double s = up / height;
            const double lean = 0.36 * (hash01(i, 1, 112) - 0.5);
            const double middle = 0.18 + 0.64 * (i + 0.5) / kCount + lean * s * s;
            const double half = 0.021 * (1.0 - s * s);
            const double inside = (half - std::abs(u - middle)) * kBlades; // pixels
            const double cover = std::clamp(inside + 0.5, 0.0, 1.0);
            if (cover <= alpha) continue;
            alpha = cover;
            light = 0.75 + 0.4 * hash01(i, 2, 112) + 0.08 * mottle.at(x, y);
        }
        return glm::dvec4(green * light, alpha);
    });
    return images;
}

SurfaceImages meadow_images() {
    constexpr double kMetres = 4.0;
    const Field patch = noise(5, 5, 121);
    const Field grain = noise(64, 64, 122);
    Field height;
    SurfaceImages images;
    images.color = image_of("meadow_color", kSize, [&](int x, int y) {
        const double soil = smooth(0.10, 0.42, patch.at(x, y) + 0.25 * grain.at(x, y));
        height.at(x, y) = 0.03 * grain.at(x, y) * (1.0 - 0.6 * soil) + 0.05 * patch.at(x, y);
        const glm::dvec3 color =
            glm::mix(glm::dvec3(0.46, 0.54, 0.27), glm::dvec3(0.55, 0.46, 0.36), soil);
        return tone(color, 0.92 + 0.25 * grain.at(x, y));
    });
    images.normal = normal_map("meadow_normal", height, kMetres);
    return images;
}

namespace {

/// The nearest of one point per cell of `cells` x `cells`, each somewhere in its cell.
struct NearestPoint {
    double distance; ///< cells
    int id_x, id_y;
};

NearestPoint nearest_point(double u, double v, int cells, std::uint32_t seed) {
    const int column = static_cast<int>(std::floor(u * cells));
    const int row = static_cast<int>(std::floor(v * cells));
    NearestPoint nearest{1e9, 0, 0};
    for (int j = row - 1; j <= row + 1; ++j)
        for (int i = column - 1; i <= column + 1; ++i) {
            const int id_x = (i + cells) % cells, id_y = (j + cells) % cells;
            const double du = i + hash01(id_x, id_y, seed) - u * cells;
            const double dv = j + hash01(id_x, id_y, seed + 1) - v * cells;
            const double distance = std::sqrt(du * du + dv * dv);
            if (distance < nearest.distance) nearest = {distance, id_x, id_y};
        }
    return nearest;
}

} // namespace

SurfaceImages hammered_images() {
    constexpr double kMetres = 0.5;
    constexpr int kDents = 24; // 2 cm
    const Field grain = noise(32, 32, 131);
    Field height;
    for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x) {
            const double d =
                nearest_point((x + 0.5) / kSize, (y + 0.5) / kSize, kDents, 132).distance;
            height.at(x, y) = 0.004 * d * d + 0.0003 * grain.at(x, y);
        }
    SurfaceImages images;
    images.normal = normal_map("hammered_normal", height, kMetres);
    return images;
}

SurfaceImages ripple_images() {
    constexpr double kMetres = 2.0;
    const Field puddle = noise(6, 6, 141);
    const Field grain = noise(64, 64, 142);
    Field height;
    SurfaceImages images;
    images.color = image_of("ripple_color", kSize, [&](int x, int y) {
        const double dry = smooth(-0.2, 0.4, puddle.at(x, y));
        height.at(x, y) = 0.004 * puddle.at(x, y) + (0.0012 + 0.0035 * dry) * grain.at(x, y);
        return tone(glm::dvec3(0.42, 0.40, 0.38), 0.7 + 0.35 * dry + 0.15 * grain.at(x, y));
    });
    images.normal = normal_map("ripple_normal", height, kMetres);
    return images;
}

SurfaceImages flake_images() {
    constexpr int kFlakes = 160; // 3 mm, about three texels
    constexpr double kSlope = 0.9;
    SurfaceImages images;
    images.normal = image_of("flake_normal", kSize, [&](int x, int y) {
        const NearestPoint flake =
            nearest_point((x + 0.5) / kSize, (y + 0.5) / kSize, kFlakes, 151);
        // Products of two numbers: most flakes lean little, few a lot.
        const auto slope = [&](std::uint32_t seed) {
            return kSlope * (2.0 * hash01(flake.id_x, flake.id_y, seed) - 1.0) *
                   hash01(flake.id_x, flake.id_y, seed + 1);
        };
        const glm::dvec2 lean(slope(153), slope(155));
        const double length = std::sqrt(glm::dot(lean, lean) + 1.0);
        return glm::dvec4(
            -lean.x / length * 0.5 + 0.5, lean.y / length * 0.5 + 0.5, 0.5 / length + 0.5, 1.0);
    });
    return images;
}

} // namespace ockham
