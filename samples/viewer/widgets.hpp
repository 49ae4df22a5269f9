// SPDX-License-Identifier: Apache-2.0
// Dear ImGui's context and look, and a widget for any declared parameter: combos, check boxes and
// sliders follow from name, range, choices and unit. Knows no technique. Called by the viewer.
#pragma once

#include "framework/core/params.hpp"

#include <string>

namespace ockham::viewer {

/// One at a time, alive while widgets are drawn.
class Gui {
public:
    Gui();
    ~Gui();
    Gui(const Gui&) = delete;
    Gui& operator=(const Gui&) = delete;
};

/// A part of the window without frame or title, to be ended as Dear ImGui's.
void begin_fixed(const char* name, bool scrolls = true);

/// A widget that edits `param`; true where a person has given it another value, which obeys the
/// declaration. A right click brings the default back. Help, unit, range and flag show as a
/// tooltip.
bool edit(Param& param);

/// The values a slider goes through: the declared range, or a part of it that can be dragged in
/// where that is wide or infinite. Others can be typed.
struct SliderRange {
    double low = 0, high = 1;
    bool logarithmic = false;
};
SliderRange slider_range(const Param& param);

/// "Label            value", value to the right.
void show_fact(const char* label, const std::string& value);
/// Text that explains what the cursor is on.
void tooltip(const std::string& text);

} // namespace ockham::viewer
