#include "tests/hard/report.h"

#include <algorithm>

namespace heliograph::hard {

namespace {

constexpr const char* HEAD = R"(<!doctype html><html lang="en"><meta charset="utf-8">
<meta name="viewport" content="width=device-width,initial-scale=1"><title>Hard cases</title><style>
:root{color-scheme:light dark;--ink:#1a1c1f;--back:#fff;--line:#d5d8dd;--dim:#5c636e;--pass:#d9f2dd;--fail:#ffd6d2;--limit:#fdeebf;--other:#f0f1f3}
@media(prefers-color-scheme:dark){:root{--ink:#e6e8eb;--back:#15171a;--line:#363b42;--dim:#a0a8b3;--pass:#153d20;--fail:#56201c;--limit:#4a3a0c;--other:#22262b}}
body{margin:24px;font:14px/1.4 system-ui,sans-serif;color:var(--ink);background:var(--back)}
h1{font-size:20px;margin:0 0 8px}p{max-width:72ch;color:var(--dim)}
.wide{overflow-x:auto}table{border-collapse:collapse;font-variant-numeric:tabular-nums}
th,td{border:1px solid var(--line);padding:6px 8px;text-align:left;vertical-align:top;min-width:11em}
th:first-child,td:first-child{min-width:2em;text-align:right}thead th{position:sticky;top:0;background:var(--back)}
td b{display:block}small{color:var(--dim);overflow-wrap:anywhere}.passes{background:var(--pass)}.FAILS{background:var(--fail)}
.limit{background:var(--limit)}.fails{background:var(--other)}.weak{background:var(--limit)}
</style>)";

std::string escaped(const std::string& text) {
    std::string out;
    for (char c : text) out += c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : std::string(1, c);
    return out;
}

const char* classOf(const Cell& cell) {
    const Status status = cell.status();
    if (status == Status::pass) return "passes";
    if (status == Status::limit) return "limit";
    if (status == Status::tooWeak) return "weak";
    return cell.judged() ? "FAILS" : "fails";
}

std::string cellHtml(const Cell* cell) {
    if (!cell) return "<td><small>-</small></td>";
    std::string text = std::string("<td class=\"") + classOf(*cell) + "\"><b>" + statusText(*cell) + "</b>";
    for (const Figure& f : cell->figures) {
        const bool bad = f.status() != Status::pass;
        text +=
            (bad ? "<div>" : "<div><small>") + escaped(f.metric + ": " + valueText(f)) + (bad ? "</div>" : "</small></div>");
        if (f.status() == Status::limit) text += "<small>" + escaped(f.why) + "</small>";
        if (bad && cell->judged() && !f.replay.empty()) text += "<small>" + escaped(f.replay) + "</small>";
    }
    return text + "</td>";
}

}  // namespace

std::string html(const std::vector<CaseResult>& results, const Plan& plan) {
    const Totals sums = totals(results);
    std::string text = HEAD;
    text += "<h1>Hard cases</h1><p>" + std::to_string(sums.passed) + " passed, " + std::to_string(sums.failed) + " failed; " +
            sums.line() + ". Sizes: " + (plan.nightly ? "nightly" : "usual") +
            ". Vulkan device: " + escaped(plan.device.empty() ? "none" : plan.device) +
            ". A rate stands with its upper 95 % bound. The naive column has to fail; bare Embree stands beside and is not "
            "judged.</p>" +
            "<div class=\"wide\"><table><thead><tr><th>#</th><th>case</th>";
    for (const char* name : column::ALL) text += std::string("<th>") + name + "</th>";
    text += "</tr></thead>";
    for (const CaseResult& r : results) {
        text += "<tr><td>" + std::to_string(r.number) + "</td><td><b>" + escaped(r.title) + "</b><small>" + escaped(r.name);
        for (const std::string& note : r.notes) text += "<br>" + escaped(note);
        text += "</small></td>";
        if (!r.notBuilt.empty())
            text += "<td class=\"fails\" colspan=\"6\"><b>not built</b><small>" + escaped(r.notBuilt) + "</small></td>";
        else
            for (const char* name : column::ALL) text += cellHtml(r.find(name));
        text += "</tr>";
    }
    return text + "</table></div></html>\n";
}

}  // namespace heliograph::hard
