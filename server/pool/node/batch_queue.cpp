#include "server/pool/node/batch_queue.h"

#include <algorithm>

namespace heliograph {

bool BatchQueue::add(WaitingBatch batch) {
    Line& line = lines_[batch.order.head];
    if (line.batches.size() >= MOST_WAITING) return false;
    line.batches.push_back(std::move(batch));
    return true;
}

std::optional<WaitingBatch> BatchQueue::next(const std::function<bool(const Digest& scene)>& isReady) {
    Line* best = nullptr;
    std::deque<WaitingBatch>::iterator bestBatch;
    for (auto& [head, line] : lines_) {
        if (best && best->turn <= line.turn) continue;
        const auto batch = std::ranges::find_if(line.batches, [&](const WaitingBatch& b) { return isReady(b.order.scene); });
        if (batch == line.batches.end()) continue;
        best = &line;
        bestBatch = batch;
    }
    if (!best) return std::nullopt;
    WaitingBatch taken = std::move(*bestBatch);
    best->batches.erase(bestBatch);
    best->turn = ++turns_;
    return taken;
}

bool BatchQueue::remove(PeerId head, uint64_t id) {
    const auto line = lines_.find(head);
    return line != lines_.end() &&
           std::erase_if(line->second.batches, [&](const WaitingBatch& b) { return b.order.id == id; }) > 0;
}

std::vector<WaitingBatch> BatchQueue::removeHead(PeerId head) {
    std::vector<WaitingBatch> gone;
    const auto line = lines_.find(head);
    if (line == lines_.end()) return gone;
    for (WaitingBatch& batch : line->second.batches) gone.push_back(std::move(batch));
    lines_.erase(line);
    return gone;
}

std::vector<WaitingBatch> BatchQueue::removeScene(const Digest& scene) {
    std::vector<WaitingBatch> gone;
    for (auto& [head, line] : lines_) {
        std::erase_if(line.batches, [&](WaitingBatch& batch) {
            if (batch.order.scene != scene) return false;
            gone.push_back(std::move(batch));
            return true;
        });
    }
    return gone;
}

size_t BatchQueue::size() const {
    size_t number = 0;
    for (const auto& [head, line] : lines_) number += line.batches.size();
    return number;
}

}  // namespace heliograph
