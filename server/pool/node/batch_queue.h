#pragma once
// The batches that wait at a node. Heads take turns, so that one with many does not starve another; those of one head go in
// their order. Pure.

#include "server/pool/wire/messages.h"

#include <deque>
#include <functional>
#include <map>
#include <optional>

namespace heliograph {

struct WaitingBatch {
    BatchOrder order;
    double arrived = 0.0;  // seconds
};

class BatchQueue {
public:
    /// Of one head.
    static constexpr size_t MOST_WAITING = 64;

    /// False where the head has too many already.
    bool add(WaitingBatch batch);
    /// The next one whose scene is there: of the head that has waited longest for a turn.
    std::optional<WaitingBatch> next(const std::function<bool(const Digest& scene)>& isReady);
    /// False where it does not wait here.
    bool remove(PeerId head, uint64_t id);
    /// All of a head's batches go, or those of a scene; they are returned.
    std::vector<WaitingBatch> removeHead(PeerId head);
    std::vector<WaitingBatch> removeScene(const Digest& scene);
    size_t size() const;

private:
    struct Line {
        std::deque<WaitingBatch> batches;
        uint64_t turn = 0;  // when it had its last
    };
    std::map<PeerId, Line> lines_;
    uint64_t turns_ = 0;
};

}  // namespace heliograph
