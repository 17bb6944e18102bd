#pragma once
// Signals of the serving process, as events to be waited for.

#include <chrono>
#include <csignal>
#include <optional>
#include <thread>

namespace heliograph {

enum class Event {
    none,       // the time is over
    end,        // SIGTERM, SIGINT, or the terminal has gone
    reload,     // SIGHUP
    sceneDone,  // our own SIGUSR1: the first scene is there or has failed
};

/// Blocks them in this thread and in all that it starts, so it has to be made before those.
class Signals {
public:
    Signals();
    Event wait(std::chrono::milliseconds atMost) const;
    static void sceneDone();

private:
    Event eventOf(int signal) const;

    sigset_t set_;
    bool terminal_;  // stdin was one at the start
};

/// Ends the process when what follows takes too long, or at once with the next signal to end: a scene that is just being
/// read cannot be interrupted everywhere.
class ShutdownLimit {
public:
    ShutdownLimit(const Signals& signals, std::chrono::milliseconds limit, int exitCode);

private:
    std::jthread thread_;
};

}  // namespace heliograph
