#pragma once
// How good the pictures of a moving view may be, by how long they queue on their way: one control variable, a ladder of steps
// in a fixed order. Down: JPEG quality in three steps (and with the first of a quality of 90 or more its full colour
// resolution), then the scale in four. The rate follows by itself: no more pictures are under way than the line holds
// (line_meter.h). Pure: time comes from outside, in seconds.

#include <cstddef>
#include <cstdint>
#include <deque>
#include <utility>

namespace heliograph {

/// Queueing delays in seconds: above the one, less is sent; below the other for a while, more.
constexpr double TOO_LONG = 0.06;
constexpr double SHORT = 0.02;

constexpr uint32_t QUALITY_LEVELS = 8;  // 0 is what was asked for

/// JPEG quality at that level, where `asked` is that of level 0.
uint32_t qualityAt(uint32_t level, uint32_t asked);
/// Steps of the scale (moving_scale.h) that pictures are smaller at that level.
uint32_t scaleStepsAt(uint32_t level);

class QualityLadder {
public:
    /// A picture of a moving view was seen, which queued so long. A step down where the median of the last second is over 60 ms,
    /// so that a stall of the line now and then costs no quality; a step up where it was under 20 ms for a second, and longer each
    /// time that the step before was one too many.
    void seen(double delay, double now);
    uint32_t level() const { return level_; }
    /// What pictures queued for lately: the median that is judged.
    double delay() const { return delay_; }
    /// Back to what was asked for.
    void reset() { *this = QualityLadder(); }

private:
    void change(uint32_t level, double now);

    std::deque<std::pair<double, double>> seen_;  // time and delay, of the last second of motion since the last change
    uint32_t level_ = 0;
    double delay_ = 0.0;
    double roomSince_ = 0.0;
    bool room_ = false;      // since then
    double patience_ = 1.0;  // seconds of room before a step up
    bool raised_ = false;    // the last change was a step up
    double changedAt_ = 0.0;
};

}  // namespace heliograph
