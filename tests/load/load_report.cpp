#include "tests/load/load_report.h"

#include "server/base/error.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <numeric>

namespace heliograph::load {

bool steady(const LoadResult& result, const Shown& shown) {
    return shown.at >= result.begun && shown.at <= result.begun + result.seconds;
}

double percentile(std::vector<float> values, double share) {
    if (values.empty()) return 0.0;
    const size_t rank = std::min(values.size() - 1, static_cast<size_t>(share * static_cast<double>(values.size())));
    std::nth_element(values.begin(), values.begin() + static_cast<ptrdiff_t>(rank), values.end());
    return values[rank];
}

double rateOf(const LoadResult& result, const ViewerResult& viewer) {
    const auto& shown = viewer.viewer->shown();
    const auto count = std::count_if(shown.begin(), shown.end(), [&](const Shown& s) { return steady(result, s); });
    return result.seconds > 0.0 ? static_cast<double>(count) / result.seconds : 0.0;
}

std::string escaped(const std::string& text) {
    std::string out;
    for (const char c : text) {
        switch (c) {
            case '&': out += "&amp;"; break;
            case '<': out += "&lt;"; break;
            case '>': out += "&gt;"; break;
            case '"': out += "&quot;"; break;
            default: out += c;
        }
    }
    return out;
}

namespace {

template <class Value>
std::vector<float> gathered(const LoadResult& result, Value value) {
    std::vector<float> all;
    for (const ViewerResult& viewer : result.viewers) {
        for (const Shown& shown : viewer.viewer->shown()) {
            if (steady(result, shown) && value(shown) >= 0.0f) all.push_back(value(shown));
        }
    }
    return all;
}

std::vector<float> delaysOf(const LoadResult& result) {
    return gathered(result, [](const Shown& shown) { return shown.motionToPhoton; });
}

double rounded(double value) { return std::round(value * 100.0) / 100.0; }

}  // namespace

std::map<std::string, double> figuresOf(const LoadResult& result) {
    std::map<std::string, double> figures;
    const std::vector<float> delays = delaysOf(result);
    const auto median = [&](auto value) { return percentile(gathered(result, value), 0.5); };
    figures["p50_ms"] = percentile(delays, 0.5);
    figures["p95_ms"] = percentile(delays, 0.95);
    figures["p99_ms"] = percentile(delays, 0.99);
    figures["render_ms"] = median([](const Shown& s) { return s.render; });
    figures["encode_ms"] = median([](const Shown& s) { return s.encode; });
    figures["queue_ms"] = median([](const Shown& s) { return s.queue; });
    const std::vector<float> bytes = gathered(result, [](const Shown& s) { return static_cast<float>(s.bytes); });
    figures["frames"] = static_cast<double>(bytes.size());
    figures["bytes_per_frame"] =
        bytes.empty() ? 0.0 : std::accumulate(bytes.begin(), bytes.end(), 0.0) / static_cast<double>(bytes.size());
    for (const char* name :
         {"dropped", "errors", "reconnects", "refused", "admitted", "not_rested", "last_input_ms", "fps_mean", "fps_min"})
        figures[name] = 0.0;
    double slowest = 1e30, sum = 0.0;
    for (const ViewerResult& viewer : result.viewers) {
        figures["dropped"] += static_cast<double>(viewer.viewer->dropped());
        figures["errors"] += static_cast<double>(viewer.viewer->faultCount());
        figures["reconnects"] += static_cast<double>(viewer.viewer->reconnects());
        figures["refused"] += viewer.admitted ? 0.0 : 1.0;
        figures["admitted"] += viewer.admitted ? 1.0 : 0.0;
        if (!viewer.admitted) continue;
        if (!viewer.restedInTime && viewer.viewer->script() != Script::attacker) figures["not_rested"] += 1.0;
        figures["last_input_ms"] = std::max(figures["last_input_ms"], viewer.viewer->lastInputMs().value_or(0.0));
        const double rate = rateOf(result, viewer);
        slowest = std::min(slowest, rate);
        sum += rate;
    }
    if (figures["admitted"] > 0.0) {
        figures["fps_min"] = slowest;
        figures["fps_mean"] = sum / figures["admitted"];
    }
    return figures;
}

std::vector<Verdict> judge(const std::vector<Requirement>& requirements, const std::map<std::string, double>& figures) {
    std::vector<Verdict> verdicts;
    for (const Requirement& requirement : requirements) {
        const auto found = figures.find(requirement.figure);
        if (found == figures.end()) {
            std::string known;
            for (const auto& [name, value] : figures) known += (known.empty() ? "" : ", ") + name;
            throw InputError("--require", "'" + requirement.figure + "' is no figure", known);
        }
        verdicts.push_back({requirement, found->second, requirement.holds(found->second)});
    }
    return verdicts;
}

nlohmann::json reportJson(const LoadPlan& plan, const LoadResult& result, const std::vector<Verdict>& verdicts) {
    const std::map<std::string, double> f = figuresOf(result);
    nlohmann::json rows = nlohmann::json::array(), requirements = nlohmann::json::array(), faults = nlohmann::json::array();
    for (const ViewerResult& viewer : result.viewers) {
        rows.push_back({{"script", wordOf(viewer.viewer->script())},
                        {"fps", rounded(rateOf(result, viewer))},
                        {"last_input_ms", viewer.viewer->lastInputMs() ? nlohmann::json(rounded(*viewer.viewer->lastInputMs()))
                                                                       : nlohmann::json(nullptr)},
                        {"errors", viewer.viewer->faultCount()},
                        {"admitted", viewer.admitted}});
        for (const std::string& fault : viewer.viewer->faults()) {
            if (std::find(faults.begin(), faults.end(), fault) == faults.end()) faults.push_back(fault);
        }
    }
    for (const Verdict& v : verdicts)
        requirements.push_back({{"requirement", v.requirement.text}, {"value", rounded(v.value)}, {"met", v.met}});
    return {{"url", plan.url},
            {"viewers", plan.viewers},
            {"script", wordOf(plan.script)},
            {"network", plan.network.name},
            {"width", plan.width},
            {"height", plan.height},
            {"seconds", rounded(result.seconds)},
            {"frames", f.at("frames")},
            {"fps_per_viewer", {{"mean", rounded(f.at("fps_mean"))}, {"min", rounded(f.at("fps_min"))}}},
            {"motion_to_photon_ms",
             {{"p50", rounded(f.at("p50_ms"))}, {"p95", rounded(f.at("p95_ms"))}, {"p99", rounded(f.at("p99_ms"))}}},
            {"server_ms",
             {{"render", rounded(f.at("render_ms"))},
              {"encode", rounded(f.at("encode_ms"))},
              {"queue", rounded(f.at("queue_ms"))}}},
            {"last_input_ms", rounded(f.at("last_input_ms"))},
            {"not_rested", f.at("not_rested")},
            {"bytes_per_frame", std::round(f.at("bytes_per_frame"))},
            {"dropped", f.at("dropped")},
            {"errors", f.at("errors")},
            {"reconnects", f.at("reconnects")},
            {"refused", f.at("refused")},
            {"admitted", f.at("admitted")},
            {"faults", faults},
            {"requirements", requirements},
            {"rows", rows}};
}

std::string reportCsv(const LoadPlan&, const LoadResult& result) {
    std::string text = "viewer,script,admitted,frames,fps,p50_ms,p95_ms,last_input_ms,dropped,errors,reconnects\n";
    for (size_t i = 0; i < result.viewers.size(); i++) {
        const ViewerResult& viewer = result.viewers[i];
        std::vector<float> delays;
        size_t frames = 0;
        for (const Shown& shown : viewer.viewer->shown()) {
            if (!steady(result, shown)) continue;
            frames++;
            if (shown.motionToPhoton >= 0.0f) delays.push_back(shown.motionToPhoton);
        }
        text += fmt::format("{},{},{},{},{:.2f},{:.2f},{:.2f},{},{},{},{}\n", i + 1, wordOf(viewer.viewer->script()),
                            viewer.admitted ? 1 : 0, frames, rateOf(result, viewer), percentile(delays, 0.5),
                            percentile(delays, 0.95),
                            viewer.viewer->lastInputMs() ? fmt::format("{:.2f}", *viewer.viewer->lastInputMs()) : "",
                            viewer.viewer->dropped(), viewer.viewer->faultCount(), viewer.viewer->reconnects());
    }
    return text;
}

std::string reportJunit(const LoadPlan& plan, const LoadResult& result, const std::vector<Verdict>& verdicts) {
    const auto missed = std::count_if(verdicts.begin(), verdicts.end(), [](const Verdict& v) { return !v.met; });
    std::string text = fmt::format(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuite name=\"heliograph-load {}\" tests=\"{}\" failures=\"{}\" "
        "time=\"{:.2f}\">\n",
        escaped(plan.url), verdicts.size(), missed, result.seconds);
    for (const Verdict& v : verdicts) {
        text += fmt::format("  <testcase classname=\"load\" name=\"{}\">", escaped(v.requirement.text));
        if (!v.met) text += fmt::format("<failure message=\"{} is {:.2f}\"/>", escaped(v.requirement.figure), v.value);
        text += "</testcase>\n";
    }
    return text + "</testsuite>\n";
}

}  // namespace heliograph::load
