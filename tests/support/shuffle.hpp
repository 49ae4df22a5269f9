// SPDX-License-Identifier: Apache-2.0
// Pictures must not depend on the order in which passes were declared: switches the shuffling of
// plans on for a while, and tells what order came of it. For tests of whole pictures.
#pragma once

#include "framework/runtime/executor.hpp"

#include <cstdlib>
#include <string>
#include <vector>

namespace ockham::test {

/// While it lives, plans are made as of passes declared in the seed's random order.
class Shuffle {
public:
    explicit Shuffle(unsigned seed) { ::setenv("OCKHAM_SHUFFLE", std::to_string(seed).c_str(), 1); }
    ~Shuffle() { ::unsetenv("OCKHAM_SHUFFLE"); }
    Shuffle(const Shuffle&) = delete;
    Shuffle& operator=(const Shuffle&) = delete;
};

/// Names of the passes in the order in which they run.
inline std::vector<std::string> order_of(const Executor& executor) {
    std::vector<std::string> names;
    for (const Step& step : executor.plan().steps)
        names.push_back(executor.graph().declaration().passes[step.pass].name);
    return names;
}

} // namespace ockham::test
