// SPDX-License-Identifier: Apache-2.0
// Constants of the metrics.
#ifndef OCKHAM_SHADERS_SURFACE_METRICS_H
#define OCKHAM_SHADERS_SURFACE_METRICS_H

#include "shared/types.h"

OCKHAM_SHARED_BEGIN

struct MetricsPush {
    float depth_weight;   ///< c_d, samples per squared world unit
    float normal_weight;  ///< c_n, samples
    float shading_weight; ///< c_s, samples per unit of luma
    float range_min;      ///< t_min
    float range_edge;     ///< t_edge
};

struct OckhamMetricsPush {
    uint stratified; ///< 1: each surface gets samples and a weight of its own
};

struct PictureSizePush {
    uvec2 size; ///< pixels
};

// What asked for the most samples: a metric of the paper's, or, of the default metric, surfaces
// without a sample or variation within them.
#define WINNER_NONE 0u
#define WINNER_DEPTH 1u
#define WINNER_NORMAL 2u
#define WINNER_SHADING 3u
#define WINNER_SURFACES 4u
#define WINNER_VARIATION 5u

OCKHAM_SHARED_END

#endif
