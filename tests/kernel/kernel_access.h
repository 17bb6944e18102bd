#pragma once
// The scalar kernel with every effect compiled in, as the kernel's tests call it.

#include "server/kernel/kernel.h"
#include "server/scene/kernel_tables.h"
#include "tests/support/random.h"

#include <limits>

namespace heliograph::test {

using EveryKernel = scalar_kernel::Kernel<~uint64_t(0)>;
using glm::dvec3;

constexpr float INFINITE = std::numeric_limits<float>::infinity();
constexpr float NOT_A_NUMBER = std::numeric_limits<float>::quiet_NaN();

/// A kernel without a scene. All effects are on but those that need tables of one, and the path integrator.
inline EveryKernel bareKernel() {
    EveryKernel kernel{};
    kernel.scene.sobol = kernelTable().data();
    kernel.frame.effects = ~uint32_t(EFFECT_FILTERED_ENVIRONMENT | EFFECT_ENVIRONMENT_LIGHT | EFFECT_SURFACE_LIGHTS |
                                     EFFECT_PATH | EFFECT_NESTED_MEDIA | EFFECT_MANY_LIGHTS | EFFECT_DISPERSION);
    return kernel;
}

}  // namespace heliograph::test
