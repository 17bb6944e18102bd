#pragma once
// Long work that may wait: what others are waiting for goes first on the same processors.

#include <functional>

namespace heliograph {

/// By how much such work is nicer than the thread that asks for it (man 7 sched). It gets a tenth of a contended core.
constexpr int BACKGROUND_NICE = 10;

/// Does `work` on a thread of lower priority and waits for it; where no thread is to be had, on this one. Throws what it throws.
void inBackground(const std::function<void()>& work);

}  // namespace heliograph
