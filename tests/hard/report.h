#pragma once
// The catalogue's results as text, Markdown, JSON and one HTML page. Pure.

#include "tests/hard/catalogue.h"

namespace heliograph::hard {

struct Totals {
    uint64_t passed = 0, failed = 0;  // cells of the product
    uint64_t limits = 0;              // cells of the product that miss a bound for a known reason
    uint64_t beaten = 0;              // cases that the naive baseline fails
    uint64_t tooWeak = 0;             // cases that it passes
    uint64_t notBuilt = 0;
    std::string line() const;  // all but passed and failed
};

Totals totals(const std::vector<CaseResult>& results);

/// `3 of 2,000,000 (< 3.9e-6)`, or the value.
std::string valueText(const Figure& figure);
/// "passes", "FAILS", "known limit", "too weak", "fails".
std::string statusText(const Cell& cell);

/// One case, a line for each column.
std::string caseText(const CaseResult& result);
std::string markdown(const std::vector<CaseResult>& results, const Plan& plan);
std::string json(const std::vector<CaseResult>& results, const Plan& plan);
std::string html(const std::vector<CaseResult>& results, const Plan& plan);

}  // namespace heliograph::hard
