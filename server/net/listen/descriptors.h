#pragma once
// The file descriptors of the process.

#include <cstddef>

namespace heliograph {

/// Raises the soft limit to `wanted`, as far as the hard one lets it. Returns what is allowed now.
size_t raiseDescriptorLimit(size_t wanted);

}  // namespace heliograph
