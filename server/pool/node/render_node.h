#pragma once
// A node of a pool: renders what heads ask for on its own devices, one batch at a time, and answers tile by tile.

#include "server/pool/node/batch_queue.h"
#include "server/pool/node/node_scenes.h"
#include "server/pool/node/pace.h"

#include <atomic>

namespace heliograph {

struct RenderNodeOptions {
    std::string name;      // shown to people
    std::string hardware;  // the same
    uint32_t workers = 1;
    Digest build{};  // as buildDigest
    MakeRenderer make;
    std::filesystem::path folder;  // of kept scenes; empty: none
    uint64_t sceneBytes = 0;       // the largest that is taken; 0: any
    double raysPerSecond = 0.0;    // no faster than that (pace.h); 0: as fast as it can
};

/// Joins when it is made and leaves when it ends. Heads that fall silent are forgotten with their batches; it then waits for
/// the next.
class RenderNode {
public:
    RenderNode(std::shared_ptr<Transport> transport, RenderNodeOptions options);
    ~RenderNode();
    RenderNode(const RenderNode&) = delete;

    PeerId id() const { return id_; }
    /// Tiles made since it began.
    uint64_t tiles() const { return tiles_; }
    /// Heads that are there.
    size_t heads() const;

private:
    /// The batch in work.
    struct InWork {
        PeerId head = 0;
        uint64_t id = 0;
        std::stop_source stop;
    };

    void heard(std::span<const uint8_t> bytes);
    void heardHead(std::span<const uint8_t> bytes);
    void guarded(std::span<const uint8_t> bytes, void (RenderNode::*handler)(std::span<const uint8_t>));
    void take(BatchOrder order);
    void cancel(const Cancel& cancel);
    void beat(std::stop_token stop);
    void forgetSilentHeads(double now);
    void work(std::stop_token stop);
    void render(const WaitingBatch& batch, std::stop_token stop);
    BatchEnd renderTiles(const BatchOrder& order, Renderer& renderer, double begin, std::stop_token stop);
    void sceneChanged(const Digest& scene);
    void end(PeerId head, BatchEnd end);

    const std::shared_ptr<Transport> transport_;
    const RenderNodeOptions options_;
    const PeerId id_;
    std::atomic<uint64_t> tiles_{0}, unsound_{0};
    Pace pace_;
    mutable std::mutex mutex_;  // of all below
    std::condition_variable_any called_;
    BatchQueue queue_;
    std::optional<InWork> inWork_;
    std::map<PeerId, double> headsHeard_;
    std::map<PeerId, double> lastEnd_;  // of each head's last batch
    std::string refusal_;
    std::unique_ptr<NodeScenes> scenes_;
    std::shared_ptr<void> inbox_, headBeats_;
    std::jthread beater_, worker_;
};

}  // namespace heliograph
