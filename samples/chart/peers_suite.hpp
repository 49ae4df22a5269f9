// SPDX-License-Identifier: Apache-2.0
// Other programs on the same machine: Blender's Cycles on the same media, VTK's flying edges on the
// same isosurface, error and time side by side. Optional: needs packages that nothing else does.
// Called by chart.
#pragma once

#include "samples/chart/suite.hpp"

namespace ockham::chart {

std::unique_ptr<Suite> make_peers_suite(Context& context);

} // namespace ockham::chart
