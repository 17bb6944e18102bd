#pragma once
// When many workers of different rates would be done with a given amount of work that each can start on at a time of
// its own. The exact answer sorts the workers by those times; here they are kept in slots of time, so that a change
// costs nothing and a question the number of slots, whatever the number of workers.

#include <array>
#include <cstddef>

namespace heliograph {

class ReadyTable {
public:
    /// Empties the table for times from `begin` on; finest around [begin, begin + span].
    void reset(double begin, double span);
    /// A worker that can start at `ready` and then does `rate` a second.
    void add(double rate, double ready) { change(rate, rate * ready, ready); }
    /// Takes out what was added with the same figures.
    void remove(double rate, double ready) { change(-rate, -rate * ready, ready); }
    /// The smallest T with sum of rate * max(0, T - max(ready, now)) >= work; infinite without workers. Workers in the
    /// slot where T falls count in full.
    double end(double work, double now) const;
    /// Whether times that matter lie beyond the slots.
    bool tooShort(double end) const { return end > begin_ + span_; }

private:
    static constexpr size_t SLOTS = 64;
    struct Slot {
        double rate = 0.0, weighted = 0.0;
    };

    size_t slotOf(double time) const;
    void change(double rate, double weighted, double ready);

    double begin_ = 0.0, span_ = 1.0;
    std::array<Slot, SLOTS + 1> slots_{};  // the last: everything later
};

}  // namespace heliograph
