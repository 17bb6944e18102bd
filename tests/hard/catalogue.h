#pragma once
// What the catalogue of hard cases measures and how it judges: figures, cells (a case on one column) and cases. Pure values;
// what traces is in tracer.h.

#include <cstdint>
#include <string>
#include <vector>

namespace heliograph::hard {

/// Who answers. The first three are what others do and are not judged; the naive one has to fail, or a case proves nothing.
namespace column {
constexpr const char* NAIVE = "naive";           // what a first ray tracer does: naive.h
constexpr const char* FAST = "Embree fast";      // bare Embree, single rays, default flags
constexpr const char* ROBUST = "Embree robust";  // the same with RTC_SCENE_FLAG_ROBUST
constexpr const char* OWN = "own (CPU)";         // the kernel and its traversal, compiled as C++
constexpr const char* EMBREE = "device embree";  // the device, setting `robust` on
constexpr const char* VULKAN = "device vulkan";  // the Vulkan device that was chosen
constexpr const char* ALL[] = {NAIVE, FAST, ROBUST, OWN, EMBREE, VULKAN};
}  // namespace column

enum class Status { pass, fail, limit, tooWeak };

/// One figure that must not exceed its bound.
struct Figure {
    std::string metric;
    double value = 0.0;  // events / n of a rate
    double bound = 0.0;  // passes if value <= bound
    uint64_t n = 0;      // rays, pixels or samples looked at
    bool rate = false;   // value is a share of events
    uint64_t events = 0;
    double ceiling = 0.0;  // of a known limit: above the bound but not above this
    std::string why;       // of a known limit; empty: none
    std::string replay;    // how to see the worst again

    Status status() const;
    /// Of a rate: its upper 95 % bound by Poisson's distribution, 3 / n where nothing happened (Byar's approximation).
    double upper95() const;
};

/// A case on one column.
struct Cell {
    std::string column;
    std::vector<Figure> figures;

    Status status() const;
    bool judged() const;  // counts as passed or failed
};

struct CaseResult {
    int number = 0;
    std::string name;
    std::string title;
    std::string notBuilt;  // why; empty: it is
    std::vector<Cell> cells;
    std::vector<std::string> notes;
    double seconds = 0.0;

    const Cell* find(const std::string& column) const;
};

/// How much is shot, and what for.
struct Plan {
    bool nightly = false;
    std::string device = "vulkan:0";  // the Vulkan device; empty: none
    std::string ray;                  // six numbers to be shot in each world of the case, with what everybody answers
};

/// Where a case puts its figures. The same metric of a column is gathered: events and rays add up, of other figures the greatest
/// counts.
class Run {
public:
    explicit Run(const Plan& plan, CaseResult& result) : plan_(plan), result_(result) {}

    const Plan& plan() const { return plan_; }
    uint64_t count(uint64_t usual, uint64_t nightly) const { return plan_.nightly ? nightly : usual; }
    /// `events` of `n`, a share that may be `bound` at most.
    void rate(const std::string& column, const std::string& metric, uint64_t events, uint64_t n, double bound,
              const std::string& replay = {});
    /// A value that may be `bound` at most, greatest of `n`. What is not a number fails.
    void most(const std::string& column, const std::string& metric, double value, double bound, uint64_t n,
              const std::string& replay = {});
    /// The figure misses its bound for a reason that is known; above `ceiling` it fails all the same.
    void known(const std::string& column, const std::string& metric, double ceiling, const std::string& why);
    void note(const std::string& text) { result_.notes.push_back(text); }

private:
    Figure& figure(const std::string& column, const std::string& metric);

    const Plan& plan_;
    CaseResult& result_;
};

/// A row of the catalogue.
struct Case {
    int number;
    const char* name;  // of --case
    const char* title;
    void (*run)(Run&);     // null: not built
    const char* notBuilt;  // why
};

/// All forty, by number.
const std::vector<Case>& catalogue();

/// Runs one and says how it went; a case that throws fails with what was said.
CaseResult runCase(const Case& row, const Plan& plan);

}  // namespace heliograph::hard
