#pragma once
// Vulkan calls that fail when told to: the test program has functions of these names itself, which count, fail or hand on to
// the loader's.

#include <cstdint>
#include <map>
#include <string>

namespace heliograph::faults {

/// The call after `succeeding` more that may fail returns VK_ERROR_OUT_OF_HOST_MEMORY, once. Counts what is made from now on.
void failAfter(uint32_t succeeding);
/// The call that failed since; empty where there was none.
std::string failed();
/// From now on all goes to the loader, and nothing is counted.
void end();
/// Objects made since failAfter that are not destroyed yet, by the name of their kind; none of count 0.
std::map<std::string, int> alive();

}  // namespace heliograph::faults
