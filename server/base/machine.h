#pragma once
// The machine that this process runs on.

#include <cstdint>
#include <string>
#include <vector>

namespace heliograph {

/// Name of the processor as the system tells it; "unknown processor" where it does not.
std::string processorName();
/// Processors that this process may use, at least 1: the smaller of its affinity and of its control group's quota.
uint32_t usableProcessors();
/// Bytes of memory that this process may use: the least of the machine's memory and of its control groups' limits; 0 where
/// the system does not say.
uint64_t usableMemory();
/// The limit in bytes that the text of a control group's file names: 0 for "max", for what is no number, and for the huge
/// number that stands for no limit in version 1.
uint64_t memoryLimitIn(const std::string& text);
/// Bytes of this process that are in memory; 0 where the system does not say.
uint64_t residentBytes();
/// The largest that residentBytes has been.
uint64_t peakResidentBytes();

/// Bytes of addresses that are left to drivers which end the process where an allocation of theirs fails (lavapipe).
constexpr uint64_t ROOM_FOR_DRIVERS = 256ull << 20;
/// Whether so many bytes of addresses could be had: a limit on them (ulimit -v) makes allocations fail. None are taken.
bool areAddressesLeft(uint64_t bytes);

/// Keeps the calling thread, and threads that it starts meanwhile, on some of the cores that it may use. For benchmarks that
/// must not have two things on one core. Does nothing where there is only one.
class CoreLimit {
public:
    enum class Cores { all, last, allButLast };
    explicit CoreLimit(Cores cores);
    ~CoreLimit() { restore(); }
    CoreLimit(const CoreLimit&) = delete;
    CoreLimit& operator=(const CoreLimit&) = delete;
    void restore();

private:
    std::vector<int> before_;  // cores; empty: nothing to restore
};

}  // namespace heliograph
