#pragma once
// The scalar kernel with every effect compiled in, as the kernel's tests call it.

#include "server/kernel/kernel.h"
#include "tests/support/random.h"

#include <limits>

namespace heliograph::test {

using EveryKernel = scalar_kernel::Kernel<0xffffffffu>;
using glm::dvec3;

constexpr double EXACT_PI = 3.14159265358979323846;
constexpr float INFINITE = std::numeric_limits<float>::infinity();
constexpr float NOT_A_NUMBER = std::numeric_limits<float>::quiet_NaN();

/// A kernel without a scene whose effects are all on.
inline EveryKernel bareKernel() {
    EveryKernel kernel{};
    kernel.frame.effects = 0xffffffffu;
    return kernel;
}

}  // namespace heliograph::test
