#include "server/pool/node/pace.h"

#include "server/base/clock.h"

#include <chrono>

namespace heliograph {

void Pace::hold(uint64_t rays, double begin, std::stop_token stop) {
    if (!isOn_) return;
    std::unique_lock lock(mutex_);
    const std::chrono::duration<double> left(device_.done(rays, begin) - wallSeconds());
    if (left.count() <= 0.0) return;
    std::mutex alone;  // the other one stays locked: results are told one after the other
    std::unique_lock waiting(alone);
    never_.wait_for(waiting, stop, left, [] { return false; });
}

}  // namespace heliograph
