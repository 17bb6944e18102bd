#pragma once
// A bucket that fills at a steady rate: short bursts pass, lasting floods do not.

#include <algorithm>

namespace heliograph {

class RateLimit {
public:
    /// `perSecond` on average, `burst` at once.
    RateLimit(double perSecond, double burst) : perSecond_(perSecond), burst_(burst), left_(burst) {}

    /// Takes `amount` at time `now` (seconds); false if the bucket does not hold it.
    bool take(double amount, double now) {
        left_ = std::min(burst_, left_ + (now - before_) * perSecond_);
        before_ = now;
        if (amount > left_) return false;
        left_ -= amount;
        return true;
    }

private:
    double perSecond_, burst_, left_;
    double before_ = 0.0;
};

}  // namespace heliograph
