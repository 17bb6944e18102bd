#include "server/operations/memory.h"

#include "server/base/machine.h"

#include <malloc.h>

namespace heliograph {

namespace {

using namespace std::chrono_literals;

constexpr auto QUIET = 1s;
constexpr auto AT_LEAST_EVERY = 10s;
constexpr int ARENAS = 4;             // as many threads as allocate at once without waiting for each other
constexpr int KEPT_AT_TOP = 8 << 20;  // bytes at an arena's end that stay for the next allocation

}  // namespace

void setUpAllocator() {
    mallopt(M_ARENA_MAX, ARENAS);
    mallopt(M_TRIM_THRESHOLD, KEPT_AT_TOP);
}

uint64_t returnFreeMemory() {
    const uint64_t before = residentBytes();
    malloc_trim(KEPT_AT_TOP);
    const uint64_t after = residentBytes();
    return before > after ? before - after : 0;
}

bool TrimClock::due(Clock::time_point now, uint64_t left) {
    if (left != last_) {
        if (last_ == trimmed_) since_ = now;
        last_ = left;
        changed_ = now;
    }
    if (left == trimmed_) return false;
    if (now - changed_ < QUIET && now - since_ < AT_LEAST_EVERY) return false;
    trimmed_ = left;
    since_ = now;
    return true;
}

}  // namespace heliograph
