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
    double opacity = 0;       ///< [0, 1]
    glm::dvec3 color{1.0};    ///< linear, [0, 1]: scattering albedo before --albedo
    glm::dvec3 emission{0.0}; ///< radiance, >= 0
};

/// Beyond its ends the outermost points hold. Values do not decrease; two equal ones are a step.
struct TransferFunction {
    std::vector<TransferPoint> points; ///< >= 1
    TransferPoint at(double value) const;
    bool emits() const;
};

/// {"domain":[lo,hi], "points":[{"value","opacity","color","emission"}...]}; domain is optional and
/// clamps. Throws Error(input) naming file, key and value.
TransferFunction load_transfer(const std::filesystem::path& path);
TransferFunction transfer_from_json(const nlohmann::json& json, const std::string& where);
/// Opacity 0 up to the Otsu threshold, then linearly up to 1 at the 99.5th percentile; white.
TransferFunction default_transfer(const Volume& volume);
/// ct-bone, ct-soft (in HU), mri, smoke (by the volume's own percentiles). Error(input) lists them.
TransferFunction preset_transfer(const std::string& name, const Volume& volume);
/// Opacity rises from 0 to 1 over [level - width / 2, level + width / 2].
TransferFunction window_transfer(double level, double width);

/// The function at equally spaced values, and between them linear: what kernels see.
struct TransferTable {
    double first = 0, last = 0;      ///< data values of the first and the last entry
    std::vector<glm::vec4> entries;  ///< colour, opacity; 2 to 4096
    std::vector<glm::vec3> emission; ///< as many, or none where nothing emits
    /// The greatest opacity over [low, high], data values.
    float max_opacity(double low, double high) const;
};
/// Integer volumes of at most 4096 codes get an entry for each code, so that a step one code wide
/// stays one; others 4096 over the values that the volume has.
TransferTable tabulate(const TransferFunction& function, const Volume& volume);

} // namespace ockham
