#pragma once
// Who may use the processors next. Every viewer renders from a thread of its own; before each slice of a pass it takes a
// turn here. The turn goes to whoever has used the least time so far, so viewers of equal cost go round robin and a viewer
// with dear settings gets no more time than one with cheap ones. An input that no picture shows yet goes before what only
// makes a picture finer, within a head start.
//
// Start-time fair queueing: P. Goyal, H. Vin, H. Cheng, "Start-time Fair Queueing: A Scheduling Algorithm for Integrated
// Services Packet Switching Networks", 1996.

#include "server/base/clock.h"

#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <stop_token>
#include <vector>

namespace heliograph {

/// What a turn is for.
enum class Urgency {
    finer,    // more samples, a picture that is saved, a measurement
    awaited,  // the first picture that shows an input
};

/// Seconds of use by which awaited turns may get ahead of the others. So nobody's samples wait for ever beside someone who
/// never rests.
constexpr double HEAD_START = 0.25;

/// The lowest is next. `start`: virtual time at which the turn would begin (start-time fair queueing).
inline double placeInLine(double start, Urgency urgency) { return urgency == Urgency::awaited ? start - HEAD_START : start; }

class Turns {
public:
    /// What one user has had. Belongs to its user; changed by Turns alone.
    class Account {
        friend class Turns;
        double used_ = 0.0;    // seconds of all turns
        double finish_ = 0.0;  // virtual time at which its last turn ended
    };

    /// The right to use the processors, given back when it goes out of scope.
    class Turn {
    public:
        Turn(Turn&& other) noexcept;
        Turn& operator=(Turn&&) = delete;
        ~Turn();

    private:
        friend class Turns;
        Turn(Turns& turns, Account& account);
        Turns* turns_;
        Account* account_;
        double begin_;  // seconds
    };

    /// `clock` in seconds; tests bring their own.
    explicit Turns(std::function<double()> clock = wallSeconds) : clock_(std::move(clock)) {}

    /// Waits for a turn. Nothing when `stop` is asked for first.
    std::optional<Turn> take(Account& account, std::stop_token stop, Urgency urgency = Urgency::finer);
    /// How many wait.
    size_t waiting() const;
    /// How often a waiting thread looked whether it is next: once when it comes, once when it is called.
    uint64_t wakeUps() const;
    bool contended() const { return waiting() > 0; }
    /// Whether others wait or have had a turn in the last half second: slices stay short then, so that a viewer who returns
    /// with every frame waits for one slice at most.
    bool shared(const Account& account) const;
    /// Seconds used by the account and by everybody.
    struct Used {
        double own = 0.0;
        double all = 0.0;
    };
    Used used(const Account& account) const;
    /// Seconds for which the account has had the turn in progress; nothing where it has none.
    std::optional<double> held(const Account& account) const;

private:
    struct Waiter {
        Account* account;
        double start;
        double place;
        std::condition_variable_any* called;
    };
    struct Past {
        const Account* account = nullptr;
        double end = 0.0;
    };  // end of its last turn; seconds

    void release(Account& account, double seconds);
    void callNext();
    const Waiter* next() const;

    const std::function<double()> clock_;
    mutable std::mutex mutex_;
    std::vector<Waiter> waiting_;      // in order of arrival
    Past latest_, before_;             // of two accounts; only compared, never followed
    const Account* holder_ = nullptr;  // of the turn in progress
    double heldSince_ = 0.0;
    uint64_t wakeUps_ = 0;
    double now_ = 0.0;  // virtual time: the start of the turn in progress
    double all_ = 0.0;  // seconds
};

}  // namespace heliograph
