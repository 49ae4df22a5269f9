// SPDX-License-Identifier: Apache-2.0
#include "framework/core/file.hpp"

#include "framework/graph/graph.hpp" // wrong
#include "error.hpp"                 // wrong
#include <framework/core/error.hpp>  // wrong
#include <spirv_cross/spirv_cross_c.h> // wrong

#include <vector>
