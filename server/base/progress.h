#pragma once
// How long work tells its caller where it stands, and how the caller ends it.

#include <functional>
#include <string>

namespace heliograph {

/// Called with what is being done and the finished share in [0, 1]. Throwing from it abandons the work. May be empty.
using Progress = std::function<void(const std::string& what, double share)>;

inline void report(const Progress& progress, const std::string& what, double share) {
    if (progress) progress(what, share);
}

}  // namespace heliograph
