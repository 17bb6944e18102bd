#include "server/base/machine.h"

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace heliograph {

namespace {

/// The rest of the first line of `file` that begins with `key`, without colon and blanks; empty if there is none.
std::string valueOf(const char* file, const std::string& key) {
    std::ifstream in(file);
    for (std::string line; std::getline(in, line);) {
        if (line.compare(0, key.size(), key) != 0) continue;
        size_t begin = line.find_first_not_of(" \t:", key.size());
        return begin == std::string::npos ? "" : line.substr(begin);
    }
    return {};
}

uint64_t kilobytesOf(const std::string& key) {
    std::istringstream text(valueOf("/proc/self/status", key));
    uint64_t kilobytes = 0;
    text >> kilobytes;
    return kilobytes * 1024;
}

/// Processors that the control group grants (cgroup v2 cpu.max: quota and period in microseconds); 0 = no limit.
double grantedProcessors() {
    std::ifstream in("/sys/fs/cgroup/cpu.max");
    double quota = 0.0, period = 0.0;
    // The quota reads "max" where there is none; then the extraction fails.
    if (!(in >> quota >> period) || period <= 0.0) return 0.0;
    return quota / period;
}

/// Limits of the control group `path` below `root` and of all above it, in the file of that name; 0 = none.
uint64_t groupLimit(const std::filesystem::path& root, const std::string& path, const std::string& file) {
    uint64_t least = 0;
    for (std::filesystem::path group = root / std::filesystem::path(path).relative_path();; group = group.parent_path()) {
        std::ifstream in(group / file);
        std::string text;
        std::getline(in, text);
        if (const uint64_t limit = memoryLimitIn(text); limit > 0) least = least == 0 ? limit : std::min(least, limit);
        if (group == root || group.string().size() <= root.string().size()) return least;
    }
}

}  // namespace

uint64_t memoryLimitIn(const std::string& text) {
    constexpr uint64_t NO_LIMIT = 1ull << 60;
    uint64_t bytes = 0;
    std::istringstream in(text);
    return in >> bytes && bytes < NO_LIMIT ? bytes : 0;
}

uint64_t usableMemory() {
    uint64_t least = static_cast<uint64_t>(std::max(sysconf(_SC_PHYS_PAGES), 0L)) *
                     static_cast<uint64_t>(std::max(sysconf(_SC_PAGESIZE), 0L));
    auto take = [&](uint64_t limit) {
        if (limit > 0) least = least == 0 ? limit : std::min(least, limit);
    };
    // A line is "number:controllers:path"; version 2 has no controllers.
    std::ifstream groups("/proc/self/cgroup");
    for (std::string line; std::getline(groups, line);) {
        const size_t first = line.find(':'), second = line.find(':', first + 1);
        if (second == std::string::npos) continue;
        const std::string controllers = line.substr(first + 1, second - first - 1), path = line.substr(second + 1);
        if (controllers.empty()) take(groupLimit("/sys/fs/cgroup", path, "memory.max"));
        if (controllers.find("memory") != std::string::npos)
            take(groupLimit("/sys/fs/cgroup/memory", path, "memory.limit_in_bytes"));
    }
    return least;
}

std::string processorName() {
    std::string name = valueOf("/proc/cpuinfo", "model name");
    return name.empty() ? "unknown processor" : name;
}

uint32_t usableProcessors() {
    cpu_set_t set;
    CPU_ZERO(&set);
    int count = sched_getaffinity(0, sizeof(set), &set) == 0 ? CPU_COUNT(&set) : 1;
    double granted = grantedProcessors();
    if (granted > 0.0) count = std::min(count, static_cast<int>(std::ceil(granted)));
    return static_cast<uint32_t>(std::max(count, 1));
}

uint64_t residentBytes() { return kilobytesOf("VmRSS"); }
uint64_t peakResidentBytes() { return kilobytesOf("VmHWM"); }

bool areAddressesLeft(uint64_t bytes) {
    void* place = mmap(nullptr, bytes, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (place == MAP_FAILED) return false;
    munmap(place, bytes);
    return true;
}

namespace {

void moveTo(const std::vector<int>& cores) {
    cpu_set_t set;
    CPU_ZERO(&set);
    for (int core : cores) CPU_SET(core, &set);
    pthread_setaffinity_np(pthread_self(), sizeof set, &set);
}

}  // namespace

CoreLimit::CoreLimit(Cores cores) {
    cpu_set_t set;
    if (cores == Cores::all || pthread_getaffinity_np(pthread_self(), sizeof set, &set) != 0 || CPU_COUNT(&set) < 2) return;
    for (int core = 0; core < CPU_SETSIZE; core++) {
        if (CPU_ISSET(core, &set)) before_.push_back(core);
    }
    std::vector<int> rest(before_.begin(), before_.end() - 1);
    moveTo(cores == Cores::last ? std::vector<int>{before_.back()} : rest);
}

void CoreLimit::restore() {
    if (!before_.empty()) moveTo(before_);
    before_.clear();
}

}  // namespace heliograph
