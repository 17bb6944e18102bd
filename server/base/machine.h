#pragma once
// The machine that this process runs on.

#include <cstdint>
#include <string>

namespace heliograph {

/// Name of the processor as the system tells it; "unknown processor" where it does not.
std::string processorName();
/// Processors that this process may use, at least 1: the smaller of its affinity and of its control group's quota.
uint32_t usableProcessors();
/// Bytes of this process that are in memory; 0 where the system does not say.
uint64_t residentBytes();
/// The largest that residentBytes has been.
uint64_t peakResidentBytes();

}  // namespace heliograph
