// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/compile/checks.hpp"
#include "framework/graph/compile/phases.hpp"

namespace ockham {

Pieces validate(const Declaration& declaration, const Capabilities& capabilities) {
    for (const Misuse& misuse : declaration.misuses)
        fail_input("[{}] {}", misuse.code, misuse.text);
    check_structure(declaration);
    check_resources(declaration, capabilities);
    check_passes(declaration, capabilities);
    Pieces pieces(declaration);
    check_content(declaration, pieces);
    return pieces;
}

} // namespace ockham
