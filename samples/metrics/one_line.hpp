// SPDX-License-Identifier: Apache-2.0
// What other programs say, as part of one line of an error.
#pragma once

#include <string>
#include <string_view>

namespace ockham {

/// The last `most` characters, line breaks turned to spaces.
inline std::string one_line(std::string_view text, std::size_t most = 300) {
    while (!text.empty() && text.back() == '\n') text.remove_suffix(1);
    std::string line(text.size() > most ? text.substr(text.size() - most) : text);
    for (char& c : line)
        if (c == '\n' || c == '\r') c = ' ';
    return line;
}

} // namespace ockham
