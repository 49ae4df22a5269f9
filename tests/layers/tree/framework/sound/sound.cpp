// SPDX-License-Identifier: Apache-2.0
#include "framework/core/error.hpp" // wrong
