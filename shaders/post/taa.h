// SPDX-License-Identifier: Apache-2.0
// What temporal anti-aliasing keeps of each frame beside its picture: the camera.
#ifndef OCKHAM_SHADERS_POST_TAA_H
#define OCKHAM_SHADERS_POST_TAA_H

#include "shared/types.h"

OCKHAM_SHARED_BEGIN

#define TAA_MOVING_FRAMES 10u // that weigh in a history while the camera moves

/// As in FrameData, without jitter.
struct TaaView {
    vec3 position;
    vec3 right;
    vec3 up;
    vec3 forward;
    uint frames; ///< in the history after this one; 0: there was none
};

OCKHAM_SHARED_END

#endif
