// SPDX-License-Identifier: Apache-2.0
// Specialisation constants of include/random.glsl.
#ifndef OCKHAM_SHADERS_INCLUDE_RANDOM_H
#define OCKHAM_SHADERS_INCLUDE_RANDOM_H

#define SPEC_SOBOL 0 // bool: the samples of a stream are Sobol points; else they are independent

#endif
