#pragma once
// What an admin may ask for over HTTP (docs/reference/protocol.md): the words. Pure.

#include <cstdint>
#include <string>
#include <string_view>

namespace heliograph {

struct AdminRequest {
    enum class Kind { listViewers, disconnect, listScenes, openScene, drain, admit, unknown, otherMethod };
    Kind kind = Kind::unknown;
    uint32_t viewer = 0;  // of disconnect
    std::string scene;    // of openScene
    std::string methods;  // of otherMethod: those that the path has
};

/// `path` without query, its escapes resolved.
AdminRequest parseAdminRequest(std::string_view method, std::string_view path);

}  // namespace heliograph
