#pragma once
// Whether the next viewer would see something, and if not, why: what /readyz says. Pure.

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace heliograph {

/// What is known of the service.
struct ReadinessFacts {
    bool ending = false;
    bool closed = false;       // by an admin: nobody else is let in
    std::string scene;         // where viewers start
    bool sceneThere = false;   // in memory, ready to be rendered
    std::string sceneFailure;  // why it is not, where it failed
    size_t viewers = 0, mostViewers = 0;
    std::string crowded;             // why nobody else may enter, where that is so
    std::vector<std::string> stuck;  // parts that have not moved for long
};

/// A word for programs and a line for people.
struct NotReady {
    std::string reason;  // draining, stuck, loading, scene, full
    std::string message;
};

/// The gravest reason; nothing when all is well.
std::optional<NotReady> notReady(const ReadinessFacts& facts);
/// {"ready": true} or {"ready": false, "reason", "message"}
std::string readinessJson(const std::optional<NotReady>& state);

}  // namespace heliograph
