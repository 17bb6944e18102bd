#pragma once
// What a thread is at and for how long, so that a stage that does not end can be named. One thread enters and leaves stages, others
// look.

#include "server/base/clock.h"

#include <functional>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace heliograph {

/// A stage that runs for a viewer.
struct RunningStage {
    uint32_t viewer = 0;
    std::string name;
    double seconds = 0.0;  // since it began
};

class StageClock {
public:
    /// Leaves the stage when it goes out of scope.
    class Span {
    public:
        explicit Span(StageClock& clock) : clock_(clock) {}
        Span(const Span&) = delete;
        Span& operator=(const Span&) = delete;
        ~Span() { clock_.leave(); }

    private:
        StageClock& clock_;
    };

    /// `clock` in seconds; tests bring their own.
    explicit StageClock(std::function<double()> clock = wallSeconds) : clock_(std::move(clock)) {}

    /// `stage` is the name, a literal.
    [[nodiscard]] Span enter(const char* stage) {
        std::lock_guard lock(mutex_);
        stage_ = stage;
        since_ = clock_();
        return Span(*this);
    }
    /// Nothing between stages.
    std::optional<RunningStage> running(uint32_t viewer) const {
        std::lock_guard lock(mutex_);
        if (!stage_) return std::nullopt;
        return RunningStage{viewer, stage_, clock_() - since_};
    }

private:
    void leave() {
        std::lock_guard lock(mutex_);
        stage_ = nullptr;
    }

    const std::function<double()> clock_;
    mutable std::mutex mutex_;  // of all below
    const char* stage_ = nullptr;
    double since_ = 0.0;
};

/// Names the stages that have run longer than `limit` seconds, with whose they are: "viewer 7, encode". The longest first.
std::vector<std::string> stuckStages(std::span<const RunningStage> stages, double limit);

}  // namespace heliograph
