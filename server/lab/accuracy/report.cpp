#include "server/lab/accuracy/report.h"

#include "server/base/machine.h"
#include "server/base/text.h"
#include "server/base/version.h"
#include "server/encode/png_encoder.h"
#include "server/lab/accuracy/flip.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace heliograph {

namespace {

constexpr const char* STYLE = R"(<style>
:root{color-scheme:light dark;--ink:#1c1e21;--soft:#5c636b;--back:#fbfbfa;--line:#dcdedf;--accent:#0b62c4;--warm:#c2410c}
@media (prefers-color-scheme:dark){:root{--ink:#e7e9ea;--soft:#a0a7ae;--back:#16181b;--line:#33373c;--accent:#6cb0ff;--warm:#ff9a5c}}
body{font:15px/1.5 system-ui,sans-serif;color:var(--ink);background:var(--back);max-width:960px;margin:0 auto;padding:24px 16px}
h1{font-size:24px;margin:0 0 8px}h2{font-size:18px;margin:32px 0 8px}p,li{margin:4px 0}ul{padding-left:20px}
.soft,figcaption{color:var(--soft)}code{font-size:13px;overflow-wrap:anywhere}
svg{width:100%;min-width:560px;height:auto;font-size:12px}svg text{fill:var(--soft)}.mid{text-anchor:middle}.end{text-anchor:end}
.grid{stroke:var(--line)}polyline{fill:none}.front{stroke:var(--accent);stroke-width:2}.samples{stroke:var(--warm);stroke-width:1.5}
.half{stroke:var(--soft);stroke-dasharray:6 4}.bound{stroke:var(--soft);stroke-dasharray:2 3}
circle.one{fill:var(--soft)}circle.tried{fill:none;stroke:var(--soft)}circle.best{fill:var(--accent)}
circle.given{fill:none;stroke:var(--warm);stroke-width:2.5}
.scroll{overflow-x:auto}table{border-collapse:collapse;font-variant-numeric:tabular-nums;font-size:13px}
th,td{padding:3px 10px 3px 0;text-align:right;border-bottom:1px solid var(--line);white-space:nowrap}
th{font-weight:600}th:nth-child(-n+2),td:nth-child(-n+2),td:last-child{text-align:left}
.three{display:grid;grid-template-columns:repeat(auto-fit,minmax(240px,1fr));gap:12px}figure{margin:0}
figure{max-width:480px}figure img{width:100%;height:auto;display:block}figcaption{font-size:13px;margin-top:4px}
</style>)";

std::string percent(double share) { return formatted(share < 0.1 ? "%.2g %%" : "%.0f %%", 100.0 * share); }

std::string moreMs(double ms) { return formatted(std::abs(ms) < 100.0 ? "%+.2g ms" : "%+.0f ms", ms); }

std::string base64(std::span<const uint8_t> bytes) {
    static constexpr char LETTERS[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (size_t i = 0; i < bytes.size(); i += 3) {
        uint32_t three = 0;
        for (size_t k = 0; k < 3; k++) three = three << 8 | (i + k < bytes.size() ? bytes[i + k] : 0u);
        for (size_t k = 0; k < 4; k++) text += i + k <= bytes.size() ? LETTERS[three >> (18 - 6 * k) & 63u] : '=';
    }
    return text;
}

std::string figure(const DisplayImage& image, const std::string& caption) {
    std::vector<uint8_t> png;
    makePngEncoder()->encode(image, 0, png);
    return "<figure><img alt='" + escaped(caption) + "' src='data:image/png;base64," + base64(png) + "'><figcaption>" +
           escaped(caption) + "</figcaption></figure>\n";
}

/// Eight times the difference of the codes.
DisplayImage difference(const DisplayImage& a, const DisplayImage& b) {
    constexpr int TIMES = 8;
    DisplayImage image = a;
    for (size_t i = 0; i < image.rgba.size(); i++) {
        const int apart = std::abs(static_cast<int>(a.rgba[i]) - b.rgba[i]) * TIMES;
        image.rgba[i] = i % 4 == 3 ? 255 : static_cast<uint8_t>(std::min(apart, 255));
    }
    return image;
}

/// Black over red and yellow to white.
DisplayImage heat(const std::vector<float>& map, uint32_t width, uint32_t height) {
    DisplayImage image{width, height, {}};
    for (float value : map) {
        for (int channel = 0; channel < 3; channel++) {
            const float part = std::clamp(3.0f * value - static_cast<float>(channel), 0.0f, 1.0f);
            image.rgba.push_back(static_cast<uint8_t>(std::lround(255.0f * part)));
        }
        image.rgba.push_back(255);
    }
    return image;
}

std::string pictures(AccuracySweep& sweep) {
    const std::vector<size_t> front = sweep.front();
    std::vector<std::pair<std::string, size_t>> chosen;
    if (!front.empty()) chosen.emplace_back("Fastest of the front", sweep.rows()[front.front()].point);
    chosen.emplace_back("As given", 0);
    if (!front.empty()) chosen.emplace_back("Most exact of the front", sweep.rows()[front.back()].point);
    const DisplayImage reference = sweep.shown(sweep.reference(0, false).picture());
    std::string html = "<h2>Three points beside the reference</h2>\n<div class='three'>" +
                       figure(reference, formatted("Reference: %u samples", sweep.reference(0, false).samples())) + "</div>\n";
    for (const auto& [name, index] : chosen) {
        const AccuracyPoint& point = sweep.points()[index];
        const DisplayImage image = resized(sweep.shown(sweep.picture(point)), sweep.options().resolution);
        const std::vector<float> map = flipMap(reference, image);
        const std::string set = point.set.empty() ? "settings as given" : joined(point.set, " ");
        html +=
            "<h3>" + escaped(name) + "</h3><p class='soft'>" + escaped(set) + "</p><div class='three'>" +
            figure(image, "Picture: error " + percent(point.error.own.rmse) + formatted(", %.4g ms", sweep.timeOf(point).ms)) +
            figure(difference(image, reference), formatted("Difference, 8 times: PSNR %.1f dB", point.error.display.psnrDb)) +
            figure(heat(map, image.width, image.height), formatted("FLIP: mean %.4f", meanFlip(map))) + "</div>\n";
    }
    return html;
}

/// What each step of a knob costs and buys.
std::string prices(const AccuracySweep& sweep) {
    std::string html = "<h2>Price list</h2>\n<p class='soft'>Each knob by itself, all others as given.</p>\n<ul>\n";
    const nlohmann::json schema = settingsSchema();
    for (size_t i = 1; i < sweep.rows().size(); i++) {
        const AccuracyRow &before = sweep.rows()[i - 1], &row = sweep.rows()[i];
        if (before.knob != row.knob || row.knob == "combination") continue;
        const AccuracyPoint &from = sweep.points()[before.point], &to = sweep.points()[row.point];
        const auto entry = std::ranges::find_if(schema, [&](const auto& s) { return s["name"] == row.knob; });
        const std::string label = entry == schema.end() ? row.knob : (*entry)["label"].get<std::string>();
        const double more = sweep.timeOf(to).ms - sweep.timeOf(from).ms;
        std::string line = "<li>" + escaped(label) + " " + escaped(before.value) + " → " + escaped(row.value) + ": ";
        if (to.coding) {
            const auto bytes = static_cast<long long>(to.bytes) - static_cast<long long>(from.bytes);
            line += formatted("PSNR %.1f → %.1f dB, ", from.error.display.psnrDb, to.error.display.psnrDb) + moreMs(more) +
                    formatted(", %+lld bytes", bytes);
        } else {
            const bool light = from.byLight || to.byLight;
            const LinearError &a = light ? from.error.light : from.error.own, &b = light ? to.error.light : to.error.own;
            line += "error " + percent(a.rmse) + " → " + percent(b.rmse) + ", " + moreMs(more) +
                    (light ? " (against all light)" : "");
        }
        html += line + "</li>\n";
    }
    return html + "</ul>\n";
}

std::string table(const AccuracySweep& sweep) {
    std::string html =
        "<h2>All that was measured</h2>\n<div "
        "class='scroll'><table><tr><th>setting</th><th>value</th><th>ms</th><th>quartiles</th>"
        "<th>error</th><th>bias</th><th>PSNR dB</th><th>p99</th><th>FLIP</th><th>rays</th><th></th></tr>\n";
    for (const AccuracyRow& row : sweep.rows()) {
        const AccuracyPoint& point = sweep.points()[row.point];
        const PointTime time = sweep.timeOf(point);
        html += "<tr><td>" + escaped(row.knob) + "</td><td>" + escaped(row.value) + "</td>" +
                formatted("<td>%.4g</td><td>%.4g–%.4g</td>", time.ms, time.low, time.high);
        html += point.coding
                    ? "<td></td><td></td>"
                    : formatted("<td>%.3g %%</td><td>%+.2g %%</td>", 100.0 * point.judged().rmse, 100.0 * point.judged().bias);
        html += formatted("<td>%.1f</td><td>%.0f</td><td>%.4f</td>", point.error.display.psnrDb, point.error.display.p99,
                          point.error.display.flip);
        html += point.coding ? "<td></td>"
                             : formatted("<td>%llu</td>", static_cast<unsigned long long>(point.time.first.rays.total()));
        html += std::string("<td>") + (row.given ? "as given" : "") + (point.byLight ? "against all light" : "") +
                (point.coding ? "coding alone" : "") + "</td></tr>\n";
    }
    return html + "</table></div>\n";
}

std::string head(const AccuracySweep& sweep, const std::string& command) {
    const LinearError model = sweep.modelError();
    std::string views;
    for (const AccuracyView& view : sweep.options().views) views += (views.empty() ? "" : ", ") + view.name;
    return "<h1>What accuracy costs: " + escaped(sweep.scene().name) + "</h1>\n<p>" + escaped(views) +
           formatted(", %ux%u, %u samples as given</p>\n", sweep.options().resolution.x, sweep.options().resolution.y,
                     sweep.options().settings.samples) +
           "<p class='soft'>" + escaped(sweep.device()) + " on " + escaped(processorName()) +
           formatted(", %u cores; heliograph ", usableProcessors()) + programVersion() + "</p>\n<p><code>" + escaped(command) +
           "</code></p>\n<p>The reference has " +
           formatted("%u samples of other noise and an error of its own of ", sweep.reference(0, false).samples()) +
           percent(sweep.referenceError(false)) +
           formatted("; that of all light has %u and ", sweep.reference(0, true).samples()) +
           percent(sweep.referenceError(true)) + ". Without any limit this view is " + percent(model.rmse) +
           " from all light, its mean " + formatted("%+.2g %%", 100.0 * model.bias) + ".</p>\n";
}

}  // namespace

std::string escaped(std::string_view text) {
    std::string html;
    for (char c : oneLine(text)) {
        switch (c) {
            case '&': html += "&amp;"; break;
            case '<': html += "&lt;"; break;
            case '>': html += "&gt;"; break;
            case '"': html += "&quot;"; break;
            case '\'': html += "&#39;"; break;
            default: html += c;
        }
    }
    return html;
}

std::string toHtml(AccuracySweep& sweep, const std::string& command) {
    std::string html =
        "<!doctype html>\n<html lang='en'><head><meta charset='utf-8'>"
        "<meta name='viewport' content='width=device-width, initial-scale=1'><title>Accuracy: " +
        escaped(sweep.scene().name) + "</title>" + STYLE + "</head><body>\n";
    html += head(sweep, command);
    html += "<h2>Error against time</h2>\n<div class='scroll'>" + plotSvg(sweep) + "</div>\n";
    html += prices(sweep) + pictures(sweep) + table(sweep);
    html += "<h2>Not turned</h2>\n<ul>\n";
    for (const NotTurned& knob : sweep.notTurned()) html += "<li>" + escaped(knob.knob) + ": " + escaped(knob.why) + "</li>\n";
    return html + "</ul>\n</body></html>\n";
}

}  // namespace heliograph
