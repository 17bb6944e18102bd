#pragma once
// The subjects on which a pool's messages travel.

#include "server/pool/wire/messages.h"

namespace heliograph {

/// Beats of nodes, heard by all heads; beats of heads, heard by all nodes.
inline const std::string NODE_BEATS = "heliograph.pool.nodes";
inline const std::string HEAD_BEATS = "heliograph.pool.heads";

inline std::string peerText(PeerId id) {
    char text[17];
    std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(id));
    return text;
}
/// What is for that node, for that head, and what that head is asked of its scenes.
inline std::string nodeSubject(PeerId id) { return "heliograph.pool.node." + peerText(id); }
inline std::string headSubject(PeerId id) { return "heliograph.pool.head." + peerText(id); }
inline std::string sceneSubject(PeerId id) { return "heliograph.pool.scene." + peerText(id); }

}  // namespace heliograph
