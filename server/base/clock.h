#pragma once
// Time that has passed, as seconds. Only differences mean something.

namespace heliograph {

/// Wall clock that never goes back.
double wallSeconds();
/// Processor time that the calling thread has used.
double threadCpuSeconds();
/// Processor time that all threads of the process have used together ("core seconds").
double processCpuSeconds();

/// Wall time since it was made or restarted.
class StopWatch {
public:
    StopWatch() : start_(wallSeconds()) {}
    void restart() { start_ = wallSeconds(); }
    double seconds() const { return wallSeconds() - start_; }
    double milliseconds() const { return 1e3 * seconds(); }

private:
    double start_;
};

}  // namespace heliograph
