#pragma once
// The report of a sweep: one HTML file that needs nothing beside it.

#include "server/lab/accuracy/sweep.h"

#include <string>

namespace heliograph {

/// Error against time, what each step of each knob costs and buys, pictures of three points, machine and command. `command` as
/// typed. Renders the three points once more.
std::string toHtml(AccuracySweep& sweep, const std::string& command);

/// Error against time of all points, both logarithmic, as an SVG element: the front marked, the way of `samples` and its slope
/// drawn, and the slope -1/2 of independent samples. Colours are the classes of the report's style.
std::string plotSvg(const AccuracySweep& sweep);

/// The text in HTML, as content or in an attribute.
std::string escaped(std::string_view text);

}  // namespace heliograph
