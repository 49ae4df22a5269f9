// SPDX-License-Identifier: Apache-2.0
#include "framework/io/image_file.hpp"

#include "framework/core/error.hpp"
#include "framework/io/exr.hpp"

#include <algorithm>
#include <string>

namespace ockham {

bool is_exr_path(const std::filesystem::path& path) {
    std::string extension = path.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
        [](unsigned char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
    if (extension == ".exr") return true;
    if (extension == ".png") return false;
    fail_input("'{}': picture files end in .exr or .png, found '{}'", path.string(), extension);
}

Image load_image(const std::filesystem::path& path) {
    return is_exr_path(path) ? load_exr(path) : load_png(path);
}

void save_image(
    const std::filesystem::path& path, const Image& image, float exposure_ev, Tonemap curve) {
    is_exr_path(path) ? save_exr(path, image) : save_png8(path, image, exposure_ev, curve);
}

} // namespace ockham
