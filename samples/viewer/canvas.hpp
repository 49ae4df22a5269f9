// SPDX-License-Identifier: Apache-2.0
// From linear pictures to what the window shows: exposure, tone curve, sRGB, a wipe between two
// pictures, false colours over them. On the host, where the pictures are; no Vulkan. Called by the
// viewer.
#pragma once

#include "framework/core/image.hpp"
#include "framework/io/png.hpp"
#include "samples/viewer/presenter.hpp"

#include <string>

namespace ockham::viewer {

/// One value per pixel in false colour, or a ready-made colour per pixel.
struct Overlay {
    std::string name;
    std::string legend; ///< what the values are
    Image values;       ///< one channel: values; three: display-encoded colour, 0 to 1
    float low = 0, high = 1;
};

struct Look {
    float exposure = 0; ///< stops
    Tonemap curve = Tonemap::none;
    float wipe = 1;    ///< share of the width, from the left, that shows `a`; the rest shows `b`
    float overlay = 0; ///< opacity, 0 to 1
};

/// `a` (R, G, B linear) beside `b` where there is one, of any size: it is scaled to a's. `overlay`
/// may be null, and also has a's size or is scaled to it.
Canvas compose(const Image& a, const Image* b, const Overlay* overlay, const Look& look);

/// |a - b|, the greatest of the display-encoded channels, times 255: codes of an 8-bit display.
Image code_error(const Image& a, const Image& b, const Look& look);

} // namespace ockham::viewer
