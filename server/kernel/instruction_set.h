#pragma once
// Which of the compilations of hot loops this process runs: the highest level of the x86-64 ABI (psABI, "Micro-Architecture
// Levels") that the processor has.

#include <cstdint>
#include <cstdlib>
#include <string_view>

namespace heliograph {

/// Whether this processor runs what is compiled for a level: "v2", which all that start the program do, "v3" or "v4".
inline bool processorRuns(std::string_view isa) {
#ifdef __clang__  // 14 has no names for the levels
    const bool v3 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2") &&
                    __builtin_cpu_supports("fma");
    const bool v4 = v3 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
                    __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
                    __builtin_cpu_supports("avx512vl");
    return isa == "v4" ? v4 : isa != "v3" || v3;
#else
    if (isa == "v4") return __builtin_cpu_supports("x86-64-v4");
    return isa != "v3" || __builtin_cpu_supports("x86-64-v3");
#endif
}

/// The choice among three compilations of the same: HELIOGRAPH_ISA=v2|v3|v4 asks for another one that the processor can run.
template <typename T>
const T& ofInstructionSet(const T& v2, const T& v3, const T& v4) {
    const char* set = std::getenv("HELIOGRAPH_ISA");
    const std::string_view asked = set ? set : "v4";
    if (asked == "v4" && processorRuns("v4")) return v4;
    if (asked != "v2" && processorRuns("v3")) return v3;
    return v2;
}

}  // namespace heliograph
