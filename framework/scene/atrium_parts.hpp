// SPDX-License-Identifier: Apache-2.0
// The parts of the built-in atrium: its measures, and a mesh for each thing that it repeats.
// Included by the atrium's own files only; builtin_atrium.cpp puts the parts in place.
#pragma once

#include "framework/scene/builtin_parts.hpp"

#include <array>
#include <cstdint>
#include <string>

namespace ockham::atrium {

inline constexpr double kBay = 3.0;
inline constexpr double kCourtX = 12.0; // column axes around the court
inline constexpr double kCourtZ = 3.0;
inline constexpr double kWall = 0.25;             // half the thickness of the court's walls
inline constexpr double kFaceX = kCourtX - kWall; // walls seen from the court
inline constexpr double kFaceZ = kCourtZ - kWall;
inline constexpr double kOuterX = 14.9; // inner face of the outer wall
inline constexpr double kOuterZ = 5.9;
inline constexpr double kArchRise = 1.8; // springing to the top of the arch wall
inline constexpr double kArchRadius = 1.25;
inline constexpr double kVaultRadius = 1.5;

struct Storey {
    double floor;     ///< metres
    double springing; ///< metres, top of the columns
};
inline constexpr std::array<Storey, 2> kStoreys{{{0.15, 2.95}, {5.05, 7.40}}};
inline constexpr double kLinkPitch = 0.083;  // inner length of a chain's link: neighbours touch
inline constexpr double kLanternDrop = 0.40; // hook to the middle of the glass

/// Indices of the scene's materials.
struct Materials {
    int ashlar, brick, limestone, plaster, paving, quarry, roof, clay, wood, red, blue, leaf, bark;
    int iron, glass, water, earth;
};

// Building: atrium_building.cpp. Bays are centred on x = 0 and look to +z.

/// Wall of one bay over an arch, springing at y = 0, with moulded arch and keystone.
Mesh arch_mesh(const Materials& m);
/// Turned column on a square plinth, its abacus ending at y = height.
Mesh column_mesh(const Materials& m, std::string name, double height, double radius);
/// Flat pier before the outer wall (local z = 0), its top at y = height.
Mesh pilaster_mesh(const Materials& m, std::string name, double height);
/// Groin vault of one bay, springing at y = 0, with diagonal ribs and a boss.
Mesh vault_mesh(const Materials& m);
/// Transverse arch between a pier at the outer wall (local z = 0) and a column 2.9 m before it.
Mesh transverse_mesh(const Materials& m);
/// Outer wall of one bay seen from the aisle, 4.6 m high, with dado; `door` puts a door into it.
Mesh outer_wall_mesh(const Materials& m, std::string name, int material, double tile, bool door);
/// Balustrade of one bay between two columns, standing on y = 0.
Mesh balustrade_mesh(const Materials& m);
/// Small blocks under the cornice, one bay.
Mesh dentil_mesh(const Materials& m);
/// Cornices and steps that run around the court, for a wall of the given half length.
Mesh bands_mesh(const Materials& m, std::string name, double half);
/// Floors, roof, and the outer shell: everything that is made once.
Mesh shell_mesh(const Materials& m);

// Furniture: atrium_furniture.cpp.

/// Chain across the court along z, hung up at z = +-half, y = 0; its middle link hangs `sag` lower.
void add_slack_chain(Shape& shape, double half, double sag);
/// Lantern that hangs from y = 0 on `links` of chain above it.
Mesh lantern_mesh(const Materials& m, std::string name, int links);
/// Banner that hangs from a rod at y = 0, z = 0.25 before a balustrade at z = -0.25.
Mesh banner_mesh(const Materials& m, std::string name, int cloth_material);
/// Pot with earth, plant of `leaves` cards; `trunk` metres of stem lift the crown.
Mesh planter_mesh(const Materials& m, std::string name, double trunk, double radius, int leaves,
    std::uint64_t seed);
/// Creeper that hangs over a balustrade (its outer face at z = 0) from y = 0 downwards.
Mesh creeper_mesh(const Materials& m);
/// Basin of 3.2 m with a bowl in its middle, standing on y = 0.
Mesh fountain_mesh(const Materials& m);

} // namespace ockham::atrium
