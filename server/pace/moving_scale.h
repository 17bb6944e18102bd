#pragma once
// How many pixels are rendered while the viewer moves, so that pictures follow the hand. The scale goes by whole steps, and is
// changed by what passes of this view have cost on these devices, between these other viewers. Pure: time comes from outside.

#include <array>
#include <cstddef>
#include <cstdint>

namespace heliograph {

/// What a choice may take of its budget: at most after a way down, and at most before a step up.
constexpr double AFTER_DOWN = 0.85;
constexpr double BEFORE_UP = 0.67;
/// How long there must have been room for a step up, seconds.
constexpr double ROOM_FOR = 0.5;

/// Each step has two thirds of the pixels of the one before.
constexpr uint32_t SCALE_STEPS = 11;
/// Width of the picture at that step, as a share of its width at step 0.
double scaleOf(uint32_t step);

/// Share of the time between two pictures that a pass may take. The rest is for what is done beside passes on the same
/// processors, for the line and for the wait until the screen's next refresh.
constexpr double PASS_SHARE = 0.6;
/// Seconds that a pass may take.
inline double passBudget(double framesPerSecond) { return PASS_SHARE / framesPerSecond; }

/// How the scale stands.
struct ScaleChoice {
    uint32_t step = 0;
    double room = 0.0;  // seconds for which a step up would have fitted
    bool operator==(const ScaleChoice&) const = default;
};

/// The choice for the next picture, `seconds` after the one before. `whole`: predicted seconds of a pass at step 0. Down at
/// once and as far as it takes when a pass is longer than `budget`; up by one step when the pass would have left a third
/// of it free for half a second. Between the two it stays: the costs may differ by a factor of two before the picture changes.
ScaleChoice nextScale(const ScaleChoice& before, double whole, double budget, double seconds);
/// The choice for the first picture of a motion: the largest that fits with some room.
ScaleChoice firstScale(double whole, double budget);

/// What passes of one view cost, by the pixel.
class PixelCost {
public:
    /// A pass of so many pixels took so long, the wait for other views' turns included.
    void add(double pixels, double seconds);
    /// Other settings, another scene: what was measured says nothing any more.
    void forget() { count_ = 0; }
    /// Seconds: the median of the last passes, so that one that was held up counts for nothing. 0 while none was measured.
    double perPixel() const;

private:
    static constexpr size_t KEPT = 7;
    std::array<double, KEPT> values_{};  // the oldest is replaced
    size_t count_ = 0;                   // that were added
};

}  // namespace heliograph
