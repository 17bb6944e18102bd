#include "tests/load/load_report.h"

#include "server/base/error.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <numeric>

namespace heliograph::load {

namespace {

bool steady(const LoadResult& result, const Shown& shown) {
    return shown.at >= result.begun && shown.at <= result.begun + result.seconds;
}

/// Nearest rank; 0 of nothing.
double percentile(std::vector<float> values, double share) {
    if (values.empty()) return 0.0;
    const size_t rank = std::min(values.size() - 1, static_cast<size_t>(share * static_cast<double>(values.size())));
    std::nth_element(values.begin(), values.begin() + static_cast<ptrdiff_t>(rank), values.end());
    return values[rank];
}

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

namespace {

struct Second {
    std::vector<float> delays, renders, encodes, queues;
    size_t frames = 0;
};

/// Polyline through one value a second; `top` is the value at the upper edge.
std::string curve(const std::vector<double>& values, double top, const char* colour) {
    std::string points;
    for (size_t i = 0; i < values.size(); i++)
        points +=
            fmt::format("{:.1f},{:.1f} ",
                        50.0 + 730.0 * static_cast<double>(i) / std::max<double>(1.0, static_cast<double>(values.size()) - 1.0),
                        170.0 - 150.0 * std::min(1.0, values[i] / top));
    return fmt::format("<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"2\"/>", points, colour);
}

std::string chart(const std::string& title, const std::string& unit,
                  const std::vector<std::tuple<std::string, const char*, std::vector<double>>>& curves) {
    double top = 1e-9;
    for (const auto& [name, colour, values] : curves)
        for (const double value : values) top = std::max(top, value);
    top *= 1.1;
    std::string svg = fmt::format("<h2>{}</h2><svg viewBox=\"0 0 800 200\" role=\"img\" aria-label=\"{}\">", title, title);
    for (int i = 0; i <= 3; i++)
        svg += fmt::format(
            "<line x1=\"50\" x2=\"780\" y1=\"{0}\" y2=\"{0}\" stroke=\"#333\"/><text x=\"44\" y=\"{1}\" "
            "text-anchor=\"end\">{2:.3g}</text>",
            170 - 50 * i, 174 - 50 * i, top * i / 3.0);
    double x = 60.0;
    for (const auto& [name, colour, values] : curves) {
        svg += curve(values, top, colour);
        svg += fmt::format(
            "<rect x=\"{0}\" y=\"184\" width=\"10\" height=\"10\" fill=\"{1}\"/><text x=\"{2}\" y=\"193\">{3}</text>", x,
            colour, x + 14.0, name);
        x += 24.0 + 7.5 * static_cast<double>(name.size());
    }
    return svg + fmt::format("<text x=\"780\" y=\"193\" text-anchor=\"end\">{}, by seconds</text></svg>", unit);
}

std::string charts(const LoadResult& result) {
    std::vector<Second> seconds(std::max<size_t>(1, static_cast<size_t>(std::lround(result.seconds))));
    for (const ViewerResult& viewer : result.viewers) {
        for (const Shown& shown : viewer.viewer->shown()) {
            if (!steady(result, shown)) continue;
            Second& second = seconds[std::min(seconds.size() - 1, static_cast<size_t>(shown.at - result.begun))];
            second.frames++;
            if (shown.motionToPhoton >= 0.0f) second.delays.push_back(shown.motionToPhoton);
            second.renders.push_back(shown.render);
            second.encodes.push_back(shown.encode);
            second.queues.push_back(shown.queue);
        }
    }
    const auto over = [&](auto value) {
        std::vector<double> values;
        for (const Second& second : seconds) values.push_back(value(second));
        return values;
    };
    return chart("Pictures a second, all viewers", "1/s",
                 {{"pictures", "#4aa3ff", over([](const Second& s) { return static_cast<double>(s.frames); })}}) +
           chart("Motion to photon", "ms",
                 {{"median", "#4aa3ff", over([](const Second& s) { return percentile(s.delays, 0.5); })},
                  {"95th percentile", "#ffb14a", over([](const Second& s) { return percentile(s.delays, 0.95); })}}) +
           chart("The server's stages, median", "ms",
                 {{"render", "#4aa3ff", over([](const Second& s) { return percentile(s.renders, 0.5); })},
                  {"encode", "#7bd88f", over([](const Second& s) { return percentile(s.encodes, 0.5); })},
                  {"queue", "#ffb14a", over([](const Second& s) { return percentile(s.queues, 0.5); })}});
}

}  // namespace

std::string reportHtml(const LoadPlan& plan, const LoadResult& result, const std::vector<Verdict>& verdicts) {
    std::string page = fmt::format(
        "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><title>Load test of {0}</title><style>"
        "body{{background:#16181c;color:#e6e6e6;font:15px system-ui;max-width:860px;margin:32px auto;padding:0 16px}}"
        "table{{border-collapse:collapse;width:100%}}td,th{{padding:4px 12px 4px "
        "0;text-align:right;font-variant-numeric:tabular-nums}}"
        "td:first-child,th:first-child{{text-align:left}}h1{{font-size:22px}}h2{{font-size:17px;margin-top:32px}}svg "
        "text{{fill:#bbb;font-size:11px}}"
        ".met{{color:#7bd88f}}.missed{{color:#ff7a6b}}</style><h1>Load test of {0}</h1><p>{1} viewers ({2}, {3}x{4}, line: "
        "{5}) for {6:.1f} s</p>",
        escaped(plan.url), plan.viewers, wordOf(plan.script), plan.width, plan.height, plan.network.name, result.seconds);
    if (!verdicts.empty()) {
        page += "<h2>Requirements</h2><table>";
        for (const Verdict& v : verdicts)
            page += fmt::format("<tr><td>{}</td><td>{:.2f}</td><td class=\"{}\">{}</td></tr>", escaped(v.requirement.text),
                                v.value, v.met ? "met" : "missed", v.met ? "met" : "missed");
        page += "</table>";
    }
    page += "<h2>Figures</h2><table>";
    for (const auto& [name, value] : figuresOf(result)) page += fmt::format("<tr><td>{}</td><td>{:.2f}</td></tr>", name, value);
    page += "</table>" + charts(result) +
            "<h2>Viewers</h2><table><tr><th>viewer</th><th>script</th><th>pictures/s</th><th>last input, "
            "ms</th><th>faults</th></tr>";
    for (size_t i = 0; i < result.viewers.size(); i++) {
        const ViewerResult& viewer = result.viewers[i];
        page += fmt::format("<tr><td>{}</td><td>{}</td><td>{:.1f}</td><td>{}</td><td>{}</td></tr>", i + 1,
                            wordOf(viewer.viewer->script()), rateOf(result, viewer),
                            viewer.viewer->lastInputMs() ? fmt::format("{:.1f}", *viewer.viewer->lastInputMs()) : "–",
                            viewer.admitted ? std::to_string(viewer.viewer->faultCount()) : "refused");
        for (const std::string& fault : viewer.viewer->faults())
            page += "<tr><td></td><td colspan=\"4\" class=\"missed\">" + escaped(fault) + "</td></tr>";
    }
    return page + "</table></html>\n";
}

}  // namespace heliograph::load
