// The report for people.

#include "tests/load/load_report.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>

namespace heliograph::load {

namespace {

constexpr int LINES = 3;       // above 0 in a chart
constexpr size_t FOLDED = 24;  // viewers from which on their table is folded
const char* const STYLE = R"(
:root{color-scheme:light dark;--ground:#fff;--text:#1c1f24;--dim:#5b6470;--line:#d9dde3;--a:#0b66c3;--b:#b45309;--c:#1a7f37;
--met:#1a7f37;--missed:#c4281c}
@media(prefers-color-scheme:dark){:root{--ground:#16181c;--text:#e6e6e6;--dim:#a3abb6;--line:#33383f;--a:#4aa3ff;--b:#ffb14a;
--c:#7bd88f;--met:#7bd88f;--missed:#ff7a6b}}
*{box-sizing:border-box}
body{background:var(--ground);color:var(--text);font:15px/1.4 system-ui,sans-serif;max-width:860px;margin:24px auto;padding:0 16px}
h1{font-size:22px;overflow-wrap:anywhere}h2{font-size:17px;margin:32px 0 8px}
table{border-collapse:collapse;width:100%}
td,th{padding:4px 12px 4px 0;text-align:right;vertical-align:top;font-variant-numeric:tabular-nums}
td:last-child,th:last-child{padding-right:0}tr+tr>*{border-top:1px solid var(--line)}
td:first-child,th:first-child{text-align:left}td:last-child{white-space:nowrap}.words{text-align:left;color:var(--dim)}
.met{color:var(--met)}.missed{color:var(--missed)}
figure{margin:0 0 0 72px}.plot{position:relative;height:160px;margin-top:24px;border-bottom:1px solid var(--line)}
.plot svg{position:absolute;inset:0;width:100%;height:100%;overflow:visible}
polyline{fill:none;stroke-width:2;vector-effect:non-scaling-stroke}
.mark{position:absolute;left:0;right:0;border-top:1px solid var(--line);color:var(--dim);font-size:12px}
.mark span{position:absolute;right:100%;padding-right:8px;transform:translateY(-50%);white-space:nowrap}
figcaption{display:flex;flex-wrap:wrap;gap:4px 16px;color:var(--dim);font-size:13px;margin-top:4px}
.key::before{content:"";display:inline-block;width:10px;height:10px;margin-right:6px;background:var(--colour)}
.ends{flex-basis:100%;display:flex;justify-content:space-between}
summary{cursor:pointer}
)";

struct Words {
    const char* figure;
    const char* unit;
    const char* words;
};
constexpr Words WORDS[] = {
    {"admitted", "", "viewers that were let in"},
    {"refused", "", "viewers that were not"},
    {"fps_mean", "/s", "pictures of a viewer, on average"},
    {"fps_min", "/s", "pictures of the slowest viewer"},
    {"frames", "", "pictures of all viewers"},
    {"p50_ms", "ms", "from motion to photon, half of all"},
    {"p95_ms", "ms", "from motion to photon, 95 of 100"},
    {"p99_ms", "ms", "from motion to photon, 99 of 100"},
    {"last_input_ms", "ms", "until the last input was shown, the slowest viewer"},
    {"not_rested", "", "viewers whose last input was not shown in time"},
    {"render_ms", "ms", "in which the server renders, median"},
    {"encode_ms", "ms", "in which it encodes, median"},
    {"queue_ms", "ms", "in which a picture waits for the line, median"},
    {"bytes_per_frame", "bytes", "of a picture, on average"},
    {"dropped", "", "pictures that newer ones replaced"},
    {"errors", "", "broken promises of the protocol"},
    {"reconnects", "", "connections made again"},
};

/// Whole numbers as such.
std::string shownNumber(double value) {
    if (value == std::round(value)) return fmt::format("{:.0f}", value);
    return fmt::format("{:.{}f}", value, value >= 100.0 ? 0 : value >= 10.0 ? 1 : 2);
}

struct Curve {
    const char* name;
    const char* colour;  // a variable of STYLE
    std::vector<double> values;
};

/// One value a second; the plot is 100 x 100, y down.
std::string polyline(const Curve& curve, double top) {
    std::string points;
    const double last = std::max<double>(1.0, static_cast<double>(curve.values.size()) - 1.0);
    for (size_t i = 0; i < curve.values.size(); i++)
        points += fmt::format("{:.2f},{:.2f} ", 100.0 * static_cast<double>(i) / last, 100.0 - 100.0 * curve.values[i] / top);
    return fmt::format("<polyline points=\"{}\" style=\"stroke:var({})\"/>", points, curve.colour);
}

std::string chart(const std::string& title, const std::string& unit, double seconds, const std::vector<Curve>& curves) {
    double highest = 0.0;
    for (const Curve& curve : curves)
        for (const double value : curve.values) highest = std::max(highest, value);
    const double step = axisStep(highest, LINES);
    std::string marks, lines, keys;
    for (int i = 1; i <= LINES; i++)
        marks += fmt::format("<div class=\"mark\" style=\"bottom:{:.2f}%\"><span>{} {}</span></div>", 100.0 * i / LINES,
                             shownNumber(step * i), unit);
    for (const Curve& curve : curves) {
        lines += polyline(curve, step * LINES);
        keys += fmt::format("<span class=\"key\" style=\"--colour:var({})\">{}</span>", curve.colour, curve.name);
    }
    return fmt::format(
        "<h2>{0}</h2><figure><div class=\"plot\">{1}<svg viewBox=\"0 0 100 100\" preserveAspectRatio=\"none\" role=\"img\" "
        "aria-label=\"{0}\">{2}</svg></div><figcaption><span class=\"ends\"><span>0 s</span><span>{3:.0f} s</span></span>{4}"
        "</figcaption></figure>",
        title, marks, lines, seconds, keys);
}

struct Second {
    std::vector<float> delays, renders, encodes, queues;
    size_t frames = 0;
};

std::vector<Second> secondsOf(const LoadResult& result) {
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
    return seconds;
}

std::string charts(const LoadResult& result) {
    const std::vector<Second> seconds = secondsOf(result);
    const auto over = [&](auto value) {
        std::vector<double> values;
        for (const Second& second : seconds) values.push_back(value(second));
        return values;
    };
    const auto at = [&](std::vector<float> Second::*of, double share) {
        return over([of, share](const Second& s) { return percentile(s.*of, share); });
    };
    const double length = result.seconds;
    return chart("Pictures a second, all viewers", "/s", length,
                 {{"pictures", "--a", over([](const Second& s) { return static_cast<double>(s.frames); })}}) +
           chart("Motion to photon", "ms", length,
                 {{"median", "--a", at(&Second::delays, 0.5)}, {"95th percentile", "--b", at(&Second::delays, 0.95)}}) +
           chart("The server's stages, median", "ms", length,
                 {{"render", "--a", at(&Second::renders, 0.5)},
                  {"encode", "--c", at(&Second::encodes, 0.5)},
                  {"queue", "--b", at(&Second::queues, 0.5)}});
}

std::string viewersTable(const LoadResult& result) {
    std::string table =
        "<table><tr><th>viewer</th><th>script</th><th>pictures/s</th><th>last input, ms</th><th>faults</th></tr>";
    for (size_t i = 0; i < result.viewers.size(); i++) {
        const ViewerResult& viewer = result.viewers[i];
        table += fmt::format("<tr><td>{}</td><td>{}</td><td>{:.1f}</td><td>{}</td><td>{}</td></tr>", i + 1,
                             wordOf(viewer.viewer->script()), rateOf(result, viewer),
                             viewer.viewer->lastInputMs() ? fmt::format("{:.0f}", *viewer.viewer->lastInputMs()) : "–",
                             viewer.admitted ? std::to_string(viewer.viewer->faultCount()) : "refused");
        for (const std::string& fault : viewer.viewer->faults())
            table += "<tr><td></td><td colspan=\"4\" class=\"missed\">" + escaped(fault) + "</td></tr>";
    }
    table += "</table>";
    if (result.viewers.size() < FOLDED) return table;
    return fmt::format("<details><summary>{} viewers</summary>{}</details>", result.viewers.size(), table);
}

}  // namespace

double axisStep(double value, int lines) {
    const double least = value / lines;
    if (!(least > 0.0)) return 1.0;
    const double power = std::pow(10.0, std::floor(std::log10(least)));
    for (const double digit : {1.0, 2.0, 5.0})
        if (digit * power >= least) return digit * power;
    return 10.0 * power;
}

std::string reportHtml(const LoadPlan& plan, const LoadResult& result, const std::vector<Verdict>& verdicts) {
    std::string page = fmt::format(
        "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><meta name=\"viewport\" "
        "content=\"width=device-width,initial-scale=1\"><title>Load test of {0}</title><style>{1}</style><h1>Load test of "
        "{0}</h1><p>{2} viewers ({3}, {4}x{5}, line: {6}) for {7:.0f} s</p>",
        escaped(plan.url), STYLE, plan.viewers, wordOf(plan.script), plan.width, plan.height, plan.network.name,
        result.seconds);
    if (!verdicts.empty()) {
        page += "<h2>Requirements</h2><table>";
        for (const Verdict& v : verdicts)
            page += fmt::format("<tr><td>{}</td><td>{}</td><td class=\"{}\">{}</td></tr>", escaped(v.requirement.text),
                                shownNumber(v.value), v.met ? "met" : "missed", v.met ? "met" : "missed");
        page += "</table>";
    }
    const std::map<std::string, double> figures = figuresOf(result);
    page += "<h2>Figures</h2><table>";
    for (const Words& row : WORDS)
        page += fmt::format("<tr><td>{}</td><td class=\"words\">{}</td><td>{} {}</td></tr>", row.figure, row.words,
                            shownNumber(figures.at(row.figure)), row.unit);
    return page + "</table>" + charts(result) + "<h2>Viewers</h2>" + viewersTable(result) + "</html>\n";
}

}  // namespace heliograph::load
