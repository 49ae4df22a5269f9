// SPDX-License-Identifier: Apache-2.0
// From one tentative collision of a ray with the medium to the next: delta tracking (Woodcock et al.
// 1965) under the majorant of each cell, where what is left of an exponentially distributed optical
// depth goes on in the next cell (Novak et al. 2018, section 5). With chance sigma_t / majorant a
// tentative collision is real; ratio tracking multiplies a transmittance by what remains.
#ifndef OCKHAM_VOLUME_TRACKING_GLSL
#define OCKHAM_VOLUME_TRACKING_GLSL

#include "volume/cells.glsl"

const float kRouletteTransmittance = 0.1; // what is below it lives on by chance

// Cells entered in one call of fly().
#ifdef GRID
const uint kFlightCells = 16u;
#else
const uint kFlightCells = 0u;
#endif

uint tentative_collisions = 0u; // a lookup of the field each
uint clamped_collisions = 0u;   // those with an extinction above its majorant: never

/// A ray that crosses the medium.
struct Flight {
    vec3 origin;    // unit coordinates
    vec3 direction; // unit coordinates per world unit
#ifdef GRID
    CellWalk walk;
#endif
    float limit;    // t where the ray leaves the medium or meets a surface
    float majorant; // where it is, per world unit
};

/// Exponentially distributed; no less than 0 whatever a driver's logarithm says near 1.
float depth_of(float xi) { return max(-0.693147181 * log2(xi), 0.0); }

/// Goes on from `t` by an optical depth under the majorants: true at a tentative collision. Else the
/// rest of the depth is left, and `t` is the limit, or the flight goes on with the next call.
bool fly(inout Flight flight, inout float t, inout float depth) {
    bool met = false;
#ifdef GRID
    for (uint i = 0u; i < kFlightCells && !met && t < flight.limit; ++i) {
        flight.majorant = enter_cell(flight.walk);
        float exit = cell_exit(flight.walk), end = max(min(exit, flight.limit), t);
        float most = flight.majorant * (end - t);
        met = depth < most;
        if (met) {
            t += depth / flight.majorant;
        } else {
            depth -= most;
            t = end;
            if (exit < flight.limit) next_cell(flight.walk);
        }
    }
#else
    float most = flight.majorant * (flight.limit - t);
    met = depth < most;
    t = met ? t + depth / flight.majorant : flight.limit;
    depth -= most;
#endif
    return met;
}

/// Chance that a tentative collision at `t` is real, and what the field is there.
float collision_chance(Flight flight, float t, out float value) {
    value = field(flight.origin + t * flight.direction);
    return extinction_of(value) / flight.majorant;
}

void count_collision(float chance) {
    ++tentative_collisions;
    if (chance > 1.0 + 1e-4) ++clamped_collisions;
}

/// Transmittance behind a tentative collision. `xi`: uniform in (0, 1).
float ratio_tracked(float transmittance, float chance, float xi) {
    float left = transmittance * (1.0 - min(chance, 1.0));
    if (left >= kRouletteTransmittance) return left;
    return xi * kRouletteTransmittance < left ? kRouletteTransmittance : 0.0;
}

#endif
