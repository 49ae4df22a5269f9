// SPDX-License-Identifier: Apache-2.0
// How error texts name passes and resources: kind, name and the place of the declaration. For the
// files of framework/graph only.
#pragma once

#include "framework/graph/declaration.hpp"

#include <fmt/format.h>

#include <array>
#include <string>
#include <string_view>

namespace ockham {

inline const char* name_of(ResourceKind kind) {
    return kind == ResourceKind::buffer ? "buffer" : "image";
}
inline const char* name_of(Lifetime lifetime) {
    constexpr std::array<const char*, 3> names{"transient", "persistent", "external"};
    return names[static_cast<std::size_t>(lifetime)];
}
inline const char* name_of(PassKind kind) {
    constexpr std::array<const char*, 3> names{"compute", "raster", "transfer"};
    return names[static_cast<std::size_t>(kind)];
}
inline const char* name_of(QueueWish queue) {
    constexpr std::array<const char*, 3> names{"main", "async compute", "transfer"};
    return names[static_cast<std::size_t>(queue)];
}

/// "frame.cpp:41": the file without its folders.
inline std::string place_of(const std::source_location& where) {
    const std::string_view path = where.file_name();
    return fmt::format("{}:{}", path.substr(path.find_last_of("/\\") + 1), where.line());
}
/// "pass 'blur' (frame.cpp:41)"
inline std::string describe(const PassDecl& pass) {
    return fmt::format("pass '{}' ({})", pass.name, place_of(pass.where));
}
/// "condition 'has_media' (frame.cpp:9)"
inline std::string describe(const ConditionDecl& condition) {
    return fmt::format("condition '{}' ({})", condition.name, place_of(condition.where));
}
/// "transient image 'color' (frame.cpp:12)"
inline std::string describe(const ResourceDecl& resource) {
    return fmt::format("{} {} '{}' ({})", name_of(resource.lifetime), name_of(resource.kind),
        resource.name, place_of(resource.where));
}

} // namespace ockham
