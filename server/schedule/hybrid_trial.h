#pragma once
// Whether several devices together are really faster than the best one alone. What the balance predicts leaves out how
// they slow each other down (memory, shared processors, results that have to be added to the film), so it is measured: now
// and then some frames are made the other way. Pure; time is an argument.

#include <array>
#include <cstdint>

namespace heliograph {

class HybridTrial {
public:
    /// How the next frame should be made. `now` in seconds.
    bool together(double now);
    /// A frame of that cost took that long, made as `together` had said last. It ended at `now`.
    void note(double cost, double seconds, double now);
    /// Gain of all together over the best one alone, as measured: 0.1 = ten per cent. 0 until both were measured.
    double gain() const;
    bool measured() const { return sides_[0].rate > 0.0 && sides_[1].rate > 0.0; }

private:
    static constexpr int ALONE = 0, TOGETHER = 1;
    static constexpr uint32_t COUNTED = 3;

    struct Side {
        double rate = 0.0;  // cost a second: the median of a trial, then smoothed
        std::array<double, COUNTED> trial{};
        uint32_t frames = 0;  // of this turn
        double measuredAt = 0.0;
    };
    bool tried(const Side& side) const;
    void turn(int side);

    Side sides_[2];
    int side_ = TOGETHER;
    int winner_ = TOGETHER;
    double lastEnd_ = 0.0;
    uint32_t pausesInRow_ = 0;  // frames that began after one
    double patience_ = 0.0;     // seconds until the loser is tried again
};

}  // namespace heliograph
