// SPDX-License-Identifier: Apache-2.0
// An image on the CPU: named float channels over width x height pixels. What the GPU reads back,
// what io loads and saves, and what image_error compares. Not a GPU image.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace ockham {

/// Pixels in row-major order, top row first; channels are planes, so that each is contiguous.
/// Colour is linear, unclamped and Rec. 709 unless a function says otherwise.
class Image {
public:
    Image() = default;
    /// All channels zero. `width`, `height` >= 1.
    Image(int width, int height, std::vector<std::string> channels);

    int width() const { return width_; }
    int height() const { return height_; }
    /// width * height.
    std::size_t pixels() const;
    bool empty() const { return pixels() == 0; }

    /// Names in the order of the planes, as given ("R", "G", "B", "A", "depth.Z", ...).
    const std::vector<std::string>& channels() const { return channels_; }
    /// Index of a channel, or nothing.
    std::optional<int> find(std::string_view channel) const;
    /// The plane of a channel, width * height floats. The name must exist.
    std::span<float> plane(std::string_view channel);
    std::span<const float> plane(std::string_view channel) const;
    std::span<float> plane(int channel);
    std::span<const float> plane(int channel) const;
    /// Adds a plane of zeros (or finds the one of that name) and returns it.
    std::span<float> add_channel(const std::string& channel);

    float& at(int x, int y, int channel);
    float at(int x, int y, int channel) const;

    /// Free text that travels in an EXR header: rendering parameters, device, commit.
    std::map<std::string, std::string> metadata;

private:
    int width_ = 0;
    int height_ = 0;
    std::vector<std::string> channels_;
    std::vector<std::vector<float>> planes_;
};

/// sRGB transfer function, IEC 61966-2-1; input clamped to [0,1].
float srgb_encode(float linear);
float srgb_decode(float encoded);

} // namespace ockham
