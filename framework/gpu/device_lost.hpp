// SPDX-License-Identifier: Apache-2.0
// The failure after which everything on a device is gone, and a new device may go on: whoever keeps
// a saved state catches it. All else treats it as any other Error.
#pragma once

#include "framework/core/error.hpp"

#include <utility>

namespace ockham::gpu {

class DeviceLost : public Error {
public:
    explicit DeviceLost(std::string text) : Error(ErrorKind::device, std::move(text)) {}
};

} // namespace ockham::gpu
