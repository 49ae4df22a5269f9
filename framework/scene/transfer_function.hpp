// SPDX-License-Identifier: Apache-2.0
// What values look like: opacity, colour and emission, piecewise linear over data values. From a
// file, a preset or the histogram; tabulated for kernels. CPU only.
#pragma once

#include "framework/scene/volume.hpp"

#include <nlohmann/json_fwd.hpp>

#include <filesystem>
#include <string>
#include <vector>

namespace ockham {

struct TransferPoint {
    double value = 0;         ///< data units
    double opacity = 0;       ///< [0, 1]; 1 is an extinction of --density-scale per world unit
    glm::dvec3 color{1.0};    ///< linear, [0, 1]: scattering albedo before --albedo
    glm::dvec3 emission{0.0}; ///< radiance, >= 0, of the part that absorbs
};

struct TransferFunction {
    /// >= 1, values not decreasing; two of one value are a step, whose upper side holds at it.
    std::vector<TransferPoint> points;
    /// Linear between points; beyond the outermost these hold.
    TransferPoint at(double value) const;
    bool emits() const;
};

/// {"domain":[lo,hi], "points":[{"value","opacity","color","emission"}...]}; color, emission and
/// domain are optional. Outside of the domain its ends hold. Throws Error(input) naming file, key
/// and value; unknown keys are ignored with a warning. docs/formats.md.
TransferFunction load_transfer(const std::filesystem::path& path);
/// The same from a parsed file; `file` is its name in messages.
TransferFunction transfer_from_json(const nlohmann::json& json, const std::string& file);

/// Opacity 0 up to the Otsu threshold (histogram.hpp), then linearly up to 1 at the 99.5th
/// percentile, or at the highest value where the percentile is not above the threshold; white. Of a
/// constant volume: 1 if its value is above 0, else 0.
TransferFunction default_transfer(const Volume& volume);

/// ct-bone and ct-soft in Hounsfield units, whatever the volume; mri and smoke by its histogram.
///  - ct-bone: opacity from 150 HU on, ivory, teeth and metal white.
///  - ct-soft: skin and muscle translucent, fat fainter, bone dense; air and lungs empty.
///  - mri: as the default, with a tenth of the opacity up to halfway; grey-rose.
///  - smoke: opacity in proportion to the value above the lowest, grey.
/// Throws Error(input) that lists them.
TransferFunction preset_transfer(const std::string& name, const Volume& volume);

/// Opacity rises from 0 to 1 over [level - width / 2, level + width / 2]; white. width >= 0.
TransferFunction window_transfer(double level, double width);

/// The function at equally spaced values, linear between them: what kernels see.
struct TransferTable {
    double first = 0, last = 0;      ///< data values of the first and the last entry, first < last
    std::vector<glm::vec4> entries;  ///< colour, opacity; 2 to 4096
    std::vector<glm::vec3> emission; ///< as many, or none where nothing emits
    /// The greatest opacity of the table over [low, high], data values in either order, clamped to
    /// [first, last].
    float max_opacity(double low, double high) const;
};
/// Integer volumes with at most 4096 codes between their extremes get an entry for each code, so
/// that a step one code wide stays one; others 4096 over the points of the function, as far as the
/// volume has values there.
TransferTable tabulate(const TransferFunction& function, const Volume& volume);

} // namespace ockham
