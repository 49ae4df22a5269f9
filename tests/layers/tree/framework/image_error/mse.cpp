// SPDX-License-Identifier: Apache-2.0
#include "framework/core/image.hpp"
#include "framework/io/exr.hpp" // wrong
