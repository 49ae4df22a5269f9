// SPDX-License-Identifier: Apache-2.0
// Which Ockham this is: for --version, picture metadata and statistics.
#pragma once

namespace ockham {

const char* version(); ///< "0.1.0"
const char* commit();  ///< short hash of the sources at configure time, or "unknown"

} // namespace ockham
