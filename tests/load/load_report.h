#pragma once
// What came out of a load test: the figures that a requirement may name, and the reports for programs and people.

#include "tests/load/load_run.h"

#include <map>

namespace heliograph::load {

/// Whether it was shown while the load was steady.
bool steady(const LoadResult& result, const Shown& shown);
/// Nearest rank; 0 of nothing.
double percentile(std::vector<float> values, double share);
/// Pictures a second of steady load.
double rateOf(const LoadResult& result, const ViewerResult& viewer);
/// For HTML and XML.
std::string escaped(const std::string& text);

/// The figures by the names that --require knows: frames, fps_mean, fps_min, p50_ms, p95_ms, p99_ms (motion to photon),
/// last_input_ms (the slowest), not_rested, render_ms, encode_ms, queue_ms (medians), bytes_per_frame, dropped, errors,
/// reconnects, refused, admitted. Of steady load, except the last input's.
std::map<std::string, double> figuresOf(const LoadResult& result);

struct Verdict {
    Requirement requirement;
    double value = 0.0;
    bool met = false;
};
/// Throws InputError for a figure that there is not.
std::vector<Verdict> judge(const std::vector<Requirement>& requirements, const std::map<std::string, double>& figures);

/// {viewers, seconds, frames, fps_per_viewer, motion_to_photon_ms, server_ms, bytes_per_frame, dropped, errors, ...}.
nlohmann::json reportJson(const LoadPlan& plan, const LoadResult& result, const std::vector<Verdict>& verdicts);
/// One line a viewer.
std::string reportCsv(const LoadPlan& plan, const LoadResult& result);
/// A test suite with a case for each requirement, as CI servers read it.
std::string reportJunit(const LoadPlan& plan, const LoadResult& result, const std::vector<Verdict>& verdicts);
/// One page without anything from outside, for windows of any width, light and dark: rate and motion to photon over time,
/// percentiles, the server's stages, viewers.
std::string reportHtml(const LoadPlan& plan, const LoadResult& result, const std::vector<Verdict>& verdicts);

/// A round number (1, 2 or 5 times a power of ten) such that `lines` steps of it reach at least `value`; above 0.
double axisStep(double value, int lines);

}  // namespace heliograph::load
