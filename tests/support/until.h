#pragma once
// Waiting in tests: for a condition that another thread makes true, but never for ever.

#include <chrono>
#include <thread>

namespace heliograph::test {

/// Looks until `condition` holds; false when it does not within 20 seconds, so that a test fails instead of hanging.
template <class Condition>
bool until(Condition condition) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (!condition()) {
        if (std::chrono::steady_clock::now() > end) return false;
        std::this_thread::yield();
    }
    return true;
}

}  // namespace heliograph::test
