#pragma once
// What a sweep found, as JSON and as a table. Fields: docs/reference/benchmarks.md.

#include "server/lab/accuracy/sweep.h"

namespace heliograph {

/// {scene, device, width, height, views, samples, reference:{...}, model:{...}, rows:[...], pareto:[row indices], slopes,
/// not_turned:[...]}.
nlohmann::ordered_json toJson(const AccuracySweep& sweep);
/// One line a row.
std::string toCsv(const AccuracySweep& sweep);
/// For a terminal: the price list.
std::string toTable(const AccuracySweep& sweep);
/// Slope of error against samples: logSlope over the rows of the knob `samples` whose error is at least three times that of
/// the reference; NaN where fewer than two are.
double samplesSlope(const AccuracySweep& sweep);

}  // namespace heliograph
