#include "tests/hard/catalogue.h"

#include "server/base/clock.h"
#include "tests/hard/cases.h"

#include <algorithm>
#include <cmath>
#include <exception>

namespace heliograph::hard {

Status Figure::status() const {
    if (value <= bound) return Status::pass;
    return !why.empty() && value <= ceiling ? Status::limit : Status::fail;
}

double Figure::upper95() const {
    if (n == 0) return 1.0;
    const double k = static_cast<double>(events) + 1.0;
    const double root = 1.0 - 1.0 / (9.0 * k) + 1.645 / (3.0 * std::sqrt(k));
    return k * root * root * root / static_cast<double>(n);
}

Status Cell::status() const {
    Status worst = Status::pass;
    for (const Figure& f : figures) {
        if (f.status() == Status::fail) worst = Status::fail;
        if (f.status() == Status::limit && worst == Status::pass) worst = Status::limit;
    }
    if (column == column::NAIVE && worst == Status::pass) return Status::tooWeak;
    return worst;
}

bool Cell::judged() const { return column == column::OWN || column == column::EMBREE || column == column::VULKAN; }

const Cell* CaseResult::find(const std::string& column) const {
    for (const Cell& cell : cells)
        if (cell.column == column) return &cell;
    return nullptr;
}

Figure& Run::figure(const std::string& column, const std::string& metric) {
    Cell* found = nullptr;
    for (Cell& cell : result_.cells)
        if (cell.column == column) found = &cell;
    if (!found) found = &result_.cells.emplace_back(Cell{column, {}});
    for (Figure& f : found->figures)
        if (f.metric == metric) return f;
    Figure& made = found->figures.emplace_back();
    made.metric = metric;
    return made;
}

void Run::rate(const std::string& column, const std::string& metric, uint64_t events, uint64_t n, double bound,
               const std::string& replay) {
    Figure& f = figure(column, metric);
    f.rate = true;
    f.bound = bound;
    f.events += events;
    f.n += n;
    f.value = f.n > 0 ? static_cast<double>(f.events) / static_cast<double>(f.n) : NAN;
    if (events > 0 && f.replay.empty()) f.replay = replay;
}

void Run::most(const std::string& column, const std::string& metric, double value, double bound, uint64_t n,
               const std::string& replay) {
    Figure& f = figure(column, metric);
    f.bound = bound;
    if (f.n == 0 || value > f.value || std::isnan(value)) {
        if (!std::isnan(f.value)) f.value = value;
        if (!(value <= bound)) f.replay = replay;
    }
    f.n += n;
}

void Run::known(const std::string& column, const std::string& metric, double ceiling, const std::string& why) {
    Figure& f = figure(column, metric);
    f.ceiling = ceiling;
    f.why = why;
}

CaseResult runCase(const Case& row, const Plan& plan) {
    CaseResult result;
    result.number = row.number;
    result.name = row.name;
    result.title = row.title;
    if (!row.run) {
        result.notBuilt = row.notBuilt;
        return result;
    }
    const double begin = wallSeconds();
    Run run(plan, result);
    try {
        row.run(run);
    } catch (const std::exception& e) {
        run.most(column::OWN, std::string("ended early: ") + e.what(), 1.0, 0.0, 1);
    }
    result.seconds = wallSeconds() - begin;
    const auto place = [](const Cell& cell) {
        return std::find(std::begin(column::ALL), std::end(column::ALL), cell.column) - std::begin(column::ALL);
    };
    std::sort(result.cells.begin(), result.cells.end(), [&](const Cell& a, const Cell& b) { return place(a) < place(b); });
    return result;
}

}  // namespace heliograph::hard
