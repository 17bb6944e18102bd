#pragma once
// The stripes of a picture, on one core or on all.

#include <cstdint>
#include <functional>

namespace heliograph {

/// Who works on the stripes of a picture.
enum class StripeThreads {
    own,  // the caller alone
    all,  // the processor's other cores, too, where they have nothing else to do
};

/// Calls `work` once for each stripe below `count`; with `all` for several at once. Returns the processor time, in seconds, that
/// other threads than the caller's spent on it. Throws what `work` throws.
double forEachStripe(uint32_t count, StripeThreads threads, const std::function<void(uint32_t)>& work);

}  // namespace heliograph
