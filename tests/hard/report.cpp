#include "tests/hard/report.h"

#include <nlohmann/json.hpp>

#include <cmath>
#include <cstdio>
#include <sstream>

namespace heliograph::hard {

namespace {

std::string formatted(const char* format, double value) {
    char text[64];
    std::snprintf(text, sizeof text, format, value);
    return text;
}

std::string grouped(uint64_t value) {
    std::string digits = std::to_string(value);
    for (int at = static_cast<int>(digits.size()) - 3; at > 0; at -= 3) digits.insert(static_cast<size_t>(at), ",");
    return digits;
}

/// The figure that tells most: the worst kind, then what is nearest its bound.
const Figure& telling(const Cell& cell) {
    const Figure* best = &cell.figures.front();
    for (const Figure& f : cell.figures) {
        const auto rank = [](const Figure& g) { return g.status() == Status::fail ? 2 : g.status() == Status::limit ? 1 : 0; };
        if (rank(f) > rank(*best)) best = &f;
    }
    return *best;
}

/// Lines of at most 100 columns behind `lead`, the next ones indented as far.
std::string wrapped(const std::string& lead, const std::string& words) {
    std::string text = lead, word;
    size_t column = lead.size();
    bool first = true;
    std::istringstream in(words);
    while (in >> word) {
        if (!first && column + 1 + word.size() > 100) {
            text += "\n" + std::string(lead.size(), ' ');
            column = lead.size();
        } else if (!first) {
            text += " ";
            column++;
        }
        text += word;
        column += word.size();
        first = false;
    }
    return text + "\n";
}

}  // namespace

std::string Totals::line() const {
    return std::to_string(limits) + " known limits, " + std::to_string(beaten) + " cases fail on the naive baseline, " +
           std::to_string(tooWeak) + " too weak for it, " + std::to_string(notBuilt) + " not built";
}

Totals totals(const std::vector<CaseResult>& results) {
    Totals t;
    for (const CaseResult& r : results) {
        t.notBuilt += !r.notBuilt.empty();
        for (const Cell& cell : r.cells) {
            const Status status = cell.status();
            if (cell.column == column::NAIVE) (status == Status::tooWeak ? t.tooWeak : t.beaten)++;
            if (!cell.judged()) continue;
            if (status == Status::pass) t.passed++;
            else if (status == Status::limit) t.limits++;
            else t.failed++;
        }
    }
    return t;
}

std::string valueText(const Figure& f) {
    if (!f.rate) return formatted("%.3g", f.value) + " (bound " + formatted("%.3g", f.bound) + ")";
    return grouped(f.events) + " of " + grouped(f.n) + " (< " + formatted("%.2g", f.upper95()) + ", bound " +
           formatted("%.2g", f.bound) + ")";
}

std::string statusText(const Cell& cell) {
    switch (cell.status()) {
        case Status::pass: return "passes";
        case Status::limit: return "known limit";
        case Status::tooWeak: return "too weak";
        case Status::fail: break;
    }
    return cell.judged() ? "FAILS" : "fails";
}

std::string caseText(const CaseResult& result) {
    std::string text =
        (result.number < 10 ? " " : "") + std::to_string(result.number) + " " + result.name + ": " + result.title;
    if (!result.notBuilt.empty()) return text + "\n      not built: " + result.notBuilt + "\n";
    text += formatted("  (%.1f s)\n", result.seconds);
    for (const Cell& cell : result.cells) {
        std::string status = statusText(cell);
        std::string column = cell.column;
        column.resize(std::max<size_t>(column.size(), 14), ' ');
        status.resize(std::max<size_t>(status.size(), 11), ' ');
        bool first = true;
        for (const Figure& f : cell.figures) {
            const bool bad = f.status() != Status::pass;
            if (!bad && &f != &telling(cell)) continue;
            text +=
                "      " + (first ? column + " " + status : std::string(26, ' ')) + " " + f.metric + ": " + valueText(f) + "\n";
            if (f.status() == Status::fail && cell.judged() && !f.replay.empty()) text += "          " + f.replay + "\n";
            if (f.status() == Status::limit) text += "          " + f.why + "\n";
            first = false;
        }
    }
    for (const std::string& note : result.notes) text += "      " + note + "\n";
    return text;
}

std::string markdown(const std::vector<CaseResult>& results, const Plan& plan) {
    const Totals sums = totals(results);
    std::string text = "# Hard cases\n\n";
    text += wrapped("",
                    "Written by `hard_cases --markdown`. What the columns, bounds and words mean: [stability]"
                    "(../reference/stability.md#the-catalogue).");
    text += "\n" +
            wrapped("", std::string("Sizes: ") + (plan.nightly ? "nightly" : "usual") + ". Vulkan device: " +
                            (plan.device.empty() ? "none" : plan.device) + ". " + std::to_string(sums.passed) + " passed, " +
                            std::to_string(sums.failed) + " failed, " + sums.line() + ".") +
            "\n";
    for (const CaseResult& r : results) {
        text += wrapped("", std::to_string(r.number) + ". `" + r.name + "`: " + r.title);
        if (!r.notBuilt.empty()) text += wrapped("   - ", "not built: " + r.notBuilt);
        for (const Cell& cell : r.cells) {
            const Figure& f = telling(cell);
            text += wrapped("   - ", cell.column + " " + statusText(cell) + ": " + f.metric + " " + valueText(f) +
                                         (f.status() == Status::limit ? "; " + f.why : ""));
        }
        for (const std::string& note : r.notes) text += wrapped("   - ", note);
    }
    return text;
}

std::string json(const std::vector<CaseResult>& results, const Plan& plan) {
    nlohmann::ordered_json all;
    all["nightly"] = plan.nightly;
    all["device"] = plan.device;
    const Totals sums = totals(results);
    all["passed"] = sums.passed, all["failed"] = sums.failed, all["known_limits"] = sums.limits;
    all["fail_on_naive"] = sums.beaten, all["too_weak"] = sums.tooWeak, all["not_built"] = sums.notBuilt;
    for (const CaseResult& r : results) {
        nlohmann::ordered_json row{{"number", r.number}, {"name", r.name}, {"title", r.title}, {"seconds", r.seconds}};
        if (!r.notBuilt.empty()) row["not_built"] = r.notBuilt;
        row["cells"] = nlohmann::ordered_json::array();
        for (const Cell& cell : r.cells) {
            nlohmann::ordered_json c{{"column", cell.column}, {"status", statusText(cell)}};
            for (const Figure& f : cell.figures) {
                nlohmann::ordered_json figure{{"metric", f.metric}, {"bound", f.bound}, {"n", f.n}};
                if (std::isfinite(f.value)) figure["value"] = f.value;
                else figure["value"] = std::isnan(f.value) ? "nan" : "inf";
                if (f.rate) figure["events"] = f.events, figure["upper95"] = f.upper95();
                if (!f.why.empty()) figure["known_limit"] = f.why, figure["ceiling"] = f.ceiling;
                if (!f.replay.empty()) figure["replay"] = f.replay;
                c["figures"].push_back(figure);
            }
            row["cells"].push_back(c);
        }
        if (!r.notes.empty()) row["notes"] = r.notes;
        all["cases"].push_back(row);
    }
    return all.dump(1) + "\n";
}

}  // namespace heliograph::hard
