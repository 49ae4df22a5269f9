// SPDX-License-Identifier: Apache-2.0
#include "samples/viewer/canvas.hpp"

#include "framework/core/false_color.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace ockham::viewer {
namespace {

/// Linear [0, 1] in steps of 1 / 65535 to sRGB bytes.
const std::array<std::uint8_t, 65536>& srgb_bytes() {
    static const auto table = [] {
        std::array<std::uint8_t, 65536> bytes;
        for (std::size_t i = 0; i < bytes.size(); ++i)
            bytes[i] = static_cast<std::uint8_t>(
                std::lround(255.0f * srgb_encode(static_cast<float>(i) / 65535.0f)));
        return bytes;
    }();
    return table;
}

/// Displays one picture's pixels.
class Source {
public:
    Source(const Image& image, const Look& look, glm::ivec2 shown)
        : image_(image), shown_(shown), gain_(std::exp2(look.exposure)), curve_(look.curve) {
        for (int c = 0; c < 3; ++c) planes_[static_cast<std::size_t>(c)] = image.plane(c).data();
    }
    void put(glm::ivec2 pixel, std::uint8_t* rgb) const {
        const glm::ivec2 at = pixel * glm::ivec2(image_.width(), image_.height()) / shown_;
        const std::size_t index =
            static_cast<std::size_t>(at.y) * static_cast<std::size_t>(image_.width()) +
            static_cast<std::size_t>(at.x);
        for (std::size_t c = 0; c < 3; ++c) {
            const float linear = tonemap(gain_ * planes_[c][index], curve_); // [0, 1], no NaN
            rgb[c] = srgb_bytes()[static_cast<std::size_t>(linear * 65535.0f + 0.5f)];
        }
    }

private:
    const Image& image_;
    glm::ivec2 shown_;
    float gain_;
    Tonemap curve_;
    std::array<const float*, 3> planes_{};
};

void blend(std::uint8_t* rgb, const std::array<float, 3>& over, float opacity) {
    for (std::size_t c = 0; c < 3; ++c)
        rgb[c] = static_cast<std::uint8_t>(
            std::lerp(static_cast<float>(rgb[c]), 255.0f * over[c], opacity) + 0.5f);
}

std::array<float, 3> color_of(const Overlay& overlay, std::size_t index) {
    const Image& v = overlay.values;
    if (v.channels().size() == 3) return {v.plane(0)[index], v.plane(1)[index], v.plane(2)[index]};
    const float range = std::max(overlay.high - overlay.low, 1e-20f);
    const Rgb8 color = false_color((v.plane(0)[index] - overlay.low) / range);
    return {static_cast<float>(color.r) / 255.0f, static_cast<float>(color.g) / 255.0f,
        static_cast<float>(color.b) / 255.0f};
}

} // namespace

Canvas compose(const Image& a, const Image* b, const Overlay* overlay, const Look& look) {
    static std::uint64_t version = 0;
    Canvas canvas{.size = {a.width(), a.height()}, .rgba = {}, .version = ++version};
    canvas.rgba.resize(4 * a.pixels(), 255);
    const Source left(a, look, canvas.size);
    const Source right(b ? *b : a, look, canvas.size);
    const int split =
        b ? static_cast<int>(std::lround(look.wipe * static_cast<float>(a.width()))) : a.width();
    std::uint8_t* pixel = canvas.rgba.data();
    for (int y = 0; y < a.height(); ++y) {
        for (int x = 0; x < a.width(); ++x, pixel += 4) {
            const bool is_left = x < split;
            (is_left ? left : right).put({x, y}, pixel);
            if (!overlay || !is_left || look.overlay <= 0) continue;
            const glm::ivec2 at = glm::ivec2(x, y) *
                                  glm::ivec2(overlay->values.width(), overlay->values.height()) /
                                  canvas.size;
            blend(pixel,
                color_of(*overlay, static_cast<std::size_t>(at.y) *
                                           static_cast<std::size_t>(overlay->values.width()) +
                                       static_cast<std::size_t>(at.x)),
                look.overlay);
        }
    }
    return canvas;
}

Image code_error(const Image& a, const Image& b, const Look& look) {
    Image error(a.width(), a.height(), {"error"});
    const glm::ivec2 size(a.width(), a.height());
    const Source first(a, look, size), second(b, look, size);
    std::span<float> out = error.plane(0);
    std::size_t index = 0;
    for (int y = 0; y < size.y; ++y) {
        for (int x = 0; x < size.x; ++x, ++index) {
            std::array<std::uint8_t, 3> p{}, q{};
            first.put({x, y}, p.data());
            second.put({x, y}, q.data());
            int most = 0;
            for (std::size_t c = 0; c < 3; ++c) most = std::max(most, std::abs(p[c] - q[c]));
            out[index] = static_cast<float>(most);
        }
    }
    return error;
}

} // namespace ockham::viewer
