#pragma once
// How threads that trace count denormal numbers.

#include <pmmintrin.h>

namespace heliograph {

/// Denormal numbers count as 0 while it lives, as Embree recommends; the thread's own mode comes back afterwards.
class FlushDenormals {
public:
    FlushDenormals() { _mm_setcsr(before_ | _MM_FLUSH_ZERO_ON | _MM_DENORMALS_ZERO_ON); }
    ~FlushDenormals() { _mm_setcsr(before_); }
    FlushDenormals(const FlushDenormals&) = delete;
    FlushDenormals& operator=(const FlushDenormals&) = delete;

private:
    const unsigned before_ = _mm_getcsr();
};

}  // namespace heliograph
