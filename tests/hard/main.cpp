// The catalogue of hard cases: hard_cases [--case NAME|NUMBER]... [--nightly] [--device vulkan:N|none] [--json] [--markdown]
// [--report FILE.html] [--ray 'OX OY OZ DX DY DZ'] [--list]; --mutations FIRST reads one block of case 40
// The last line is `N passed, N failed`: cells of the product (own, embree, vulkan). Exit code 1 if one failed, 2 for bad input.

#include "tests/hard/cases.h"
#include "tests/hard/report.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <string>

namespace heliograph::hard {
namespace {

struct Options {
    Plan plan;
    std::vector<std::string> only;
    bool json = false, markdown = false, list = false;
    std::string report;
};

bool parse(int count, char** words, Options& options) {
    for (int i = 1; i < count; i++) {
        const std::string word = words[i];
        const auto next = [&] { return i + 1 < count ? std::string(words[++i]) : std::string(); };
        if (word == "--case") options.only.push_back(next());
        else if (word == "--nightly") options.plan.nightly = true;
        else if (word == "--json") options.json = true;
        else if (word == "--markdown") options.markdown = true;
        else if (word == "--list") options.list = true;
        else if (word == "--report") options.report = next();
        else if (word == "--ray") options.plan.ray = next();
        else if (word == "--device") options.plan.device = next();
        else {
            std::fprintf(stderr, "hard_cases: %s: unknown; see tests/hard/main.cpp\n", word.c_str());
            return false;
        }
    }
    if (options.plan.device == "none") options.plan.device.clear();
    for (const std::string& name : options.only) {
        const auto& rows = catalogue();
        const bool there = std::any_of(rows.begin(), rows.end(),
                                       [&](const Case& row) { return name == row.name || name == std::to_string(row.number); });
        if (!there) std::fprintf(stderr, "hard_cases: --case %s: no such case; --list names them\n", name.c_str());
        if (!there) return false;
    }
    return true;
}

bool wanted(const Options& options, const Case& row) {
    if (options.only.empty()) return true;
    for (const std::string& name : options.only)
        if (name == row.name || name == std::to_string(row.number)) return true;
    return false;
}

int run(const Options& options) {
    std::vector<CaseResult> results;
    const bool quiet = options.json || options.markdown;
    for (const Case& row : catalogue()) {
        if (!wanted(options, row)) continue;
        if (options.list) {
            std::printf("%2d %s: %s\n", row.number, row.name, row.title);
            continue;
        }
        results.push_back(runCase(row, options.plan));
        if (!quiet) std::fputs(caseText(results.back()).c_str(), stdout);
        std::fflush(stdout);
    }
    if (options.list) return 0;
    if (options.json) std::fputs(json(results, options.plan).c_str(), stdout);
    if (options.markdown) std::fputs(markdown(results, options.plan).c_str(), stdout);
    if (!options.report.empty()) {
        std::ofstream file(options.report);
        if (!(file << html(results, options.plan)).flush()) {
            std::fprintf(stderr, "hard_cases: --report %s cannot be written\n", options.report.c_str());
            return 2;
        }
    }
    const Totals sums = totals(results);
    if (!quiet)
        std::printf("%s\n%llu passed, %llu failed\n", sums.line().c_str(), static_cast<unsigned long long>(sums.passed),
                    static_cast<unsigned long long>(sums.failed));
    return sums.failed > 0 ? 1 : 0;
}

}  // namespace
}  // namespace heliograph::hard

int main(int count, char** words) {
    if (count == 3 && std::string(words[1]) == "--mutations")
        return heliograph::hard::readMutations(std::strtoull(words[2], nullptr, 10));
    heliograph::hard::Options options;
    if (!heliograph::hard::parse(count, words, options)) return 2;
    try {
        return heliograph::hard::run(options);
    } catch (const std::exception& e) {
        std::fprintf(stderr, "hard_cases: %s\n", e.what());
        return 2;
    }
}
