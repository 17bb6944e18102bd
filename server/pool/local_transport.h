#pragma once
// A pool within one process: every message is copied and handed on by threads of the hub's, in order.

#include "server/pool/transport.h"

namespace heliograph {

/// Between all that share it.
class LocalHub {
public:
    LocalHub();
    ~LocalHub();
    LocalHub(const LocalHub&) = delete;

    /// Another one on the line; lives at most as long as the hub.
    std::shared_ptr<Transport> join();
    /// From now on the hub loses all messages, or none any more; as a network that is cut.
    void cut(bool isCut);

    struct Shared;
    class Line;

private:
    const std::shared_ptr<Shared> shared_;
};

}  // namespace heliograph
