// SPDX-License-Identifier: Apache-2.0
// Names of shader variants, as passes/CMakeLists.txt builds them: "surface/shade.comp:loop,shadow".
#pragma once

#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>

namespace ockham {

/// `shader` with the features that are on, in the given order, which must be the build's.
inline std::string shader_variant(
    std::string_view shader, std::initializer_list<std::pair<std::string_view, bool>> features) {
    std::string name(shader);
    char separator = ':';
    for (const auto& [feature, on] : features) {
        if (!on) continue;
        name += separator;
        name += feature;
        separator = ',';
    }
    return name;
}

} // namespace ockham
