// SPDX-License-Identifier: Apache-2.0
// The cache of light that arrives in a medium: a grid of cells of `scale` voxels a side, of which
// those that can be seen have a slot, and a working set of slots that are being refined.
#ifndef OCKHAM_SHADERS_VOLUME_CACHE_H
#define OCKHAM_SHADERS_VOLUME_CACHE_H

#include "shared/types.h"
#include "volume/path.h"

OCKHAM_SHARED_BEGIN

#define CACHE_FP32 0u   // 12 bytes: three floats
#define CACHE_FP16 1u   //  8 bytes: three halves, rounded to nearest
#define CACHE_RGB9E5 2u //  4 bytes: mantissas of 9 bits that share an exponent

#define CACHE_RUN 32           // cells that one invocation marks, counts and numbers
#define CACHE_SCAN_WIDTH 256   // one workgroup
#define CACHE_SET_WIDTH 1024u  // of the working set, laid out as an image for add_buckets()
#define CACHE_BUCKETS 5u       // bucket b + 1: 0, 1/8, 1/4, 1/2, 1 of CachePush::paths
#define CACHE_REPLACE_PATHS 8u // a new value replaces an old one from so many paths on
#define CACHE_TRUST_PATHS 32u  // a variance of fewer paths says nothing; a power of two
#define CACHE_TRUST_TIMES 7u   // as many more paths as it has seen may be foreseen by it

// A word of the index: slot in the low 25 bits, the place of the representative point, and whether
// a surface is near; all ones: no slot, no light. At most 2^25 - 1 slots.
#define CACHE_NONE 0xffffffffu
#define CACHE_SLOT_MASK 0x01ffffffu
#define CACHE_PLACE_SHIFT 25  // 6 bits: (z * 4 + y) * 4 + x of 4 x 4 x 4 places in the cell
#define CACHE_NEAR 0x80000000u
// With CACHE_NEAR not set, the 6 bits say instead:
#define CACHE_PLACE_SOLID 1u  // inside the surface: holds a slot, but neither paths nor light
#define CACHE_UNREFINED 0xffffffffu // first word of a stored cell without a value: never a value's

/// First in the index: all that a reader needs to know.
struct CacheHeader {
    uvec3 cells;      ///< along each axis: dims / scale, rounded up
    uint scale;       ///< voxels along a side: 1, 2 or 4
    uint format;      ///< CACHE_FP32, CACHE_FP16, CACHE_RGB9E5
    uint directional; ///< 1: two more words: the light's mean direction, in halves
    uint words;       ///< of a stored cell: 3, 2 or 1, and 2 where directional
    uint slots;       ///< cells that have one; beyond the capacity they do without
    uint solid;       ///< of these, inside the surface
    uint occlusion;   ///< 1: readers ask whether they see a cell near a surface
};
OCKHAM_SHARED_SIZE(CacheHeader, 40);

/// A bit for each cube between eight voxel centres, where the field is one trilinear piece: 32 in a
/// row along x. There are dims + 1 along each axis; piece i lies between voxels i - 1 and i.
struct CachePieces {
    uint visible;  ///< the transfer function shows something of it
    uint open;     ///< not wholly inside the opaque solid
    uint crossing; ///< a surface passes through
};

/// What a slot of the working set has seen so far.
struct CacheSum {
    vec3 radiance;      ///< sum over paths
    float square;       ///< sum of squared luminance
    vec3 flow;          ///< sum of luminance times the direction that it came from
    uint count;         ///< paths that have ended
    uint cell;          ///< CACHE_NONE: gets no paths
    uint word;          ///< of the index
    float contribution; ///< (0, 1]: opacity of the cell
    uint owed;          ///< paths that were ordered and have not ended
    uint least;         ///< paths from which on readers see the mean
    uint due;           ///< 0: the paths judge how many are needed; then so many, and `least` judged
};
OCKHAM_SHARED_SIZE(CacheSum, 56);

/// A path of a cell that the loop budget has interrupted. Few are, so that the cells share some
/// places: whoever finds the place taken forgets the path, and begins it anew in the next execution.
struct CachePath {
    uint owner;    ///< 1 + slot of the working set; 0: free. A slot has one place: modulo their number
    Path path;
    vec3 first;    ///< direction in which it left the cell
    vec3 straight; ///< radiance that came without a scattering from a sampled light ...
    vec3 to_light; ///< ... which is there
    uint tries;    ///< places that were no good for the next path's beginning
};
OCKHAM_SHARED_SIZE(CachePath, 168);

/// Where refinement stands; kept between executions.
struct CacheControl {
    uvec3 enter_groups; ///< indirect: fills the working set where a block begins, else zero
    uint block;         ///< slots block * set ... are in the working set
    uint blocks;
    uint round;         ///< several blocks are gone through again and again, each time finer
    float goal;         ///< relative standard error that this round ends with
    uint suspended;     ///< 1: every cell has reached the target
    uint cells;         ///< that get paths
    uint unsettled;     ///< of the working set, those that the last execution gave paths to
    uint steps;         ///< executions since the last restart
    uint clamped; ///< collisions above the majorant, and paths that were not finite: must be 0
    uint step_paths;    ///< of the running execution; 0 between executions
    uint step_resumed;
    uint step_events;
    uvec2 paths;        ///< that have ended, since the last restart: low and high word
    uvec2 resumed;      ///< dispatches that left a path to the next execution
    uvec2 events;       ///< tentative collisions
};
OCKHAM_SHARED_SIZE(CacheControl, 84);

struct CachePush {
    uint scale;
    uint format;
    uint directional;
    uint set;        ///< slots of the working set
    uint places;     ///< of interrupted paths
    uint capacity;   ///< slots that there is memory for
    uint occlusion;  ///< 1: surfaces keep light out
    uint hold_solid; ///< 1: cells inside the surface get slots too
    uint paths;      ///< of the largest bucket: a power of two, 8 or more
    uint bucket;     ///< that the dispatch works off
    uint cells;      ///< of the grid
    uint iterations; ///< loop budget of an invocation
    float target;    ///< relative standard error
};
OCKHAM_SHARED_SIZE(CachePush, 52);

OCKHAM_SHARED_END

#endif
