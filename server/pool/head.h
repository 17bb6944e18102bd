#pragma once
// The head's side of a pool: who is there, what each is asked for, what comes back. Devices of nodes (device/remote) render
// through it.

#include "server/base/progress.h"
#include "server/pool/members.h"
#include "server/pool/scene_parts.h"
#include "server/pool/transport.h"

#include <atomic>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <new>
#include <stop_token>
#include <thread>

namespace heliograph {

/// A node has no memory for what was asked; it is well.
class PoolMemoryError : public std::bad_alloc {
public:
    explicit PoolMemoryError(const std::string& what) : what_(std::make_shared<const std::string>(what)) {}
    const char* what() const noexcept override { return what_->c_str(); }

private:
    std::shared_ptr<const std::string> what_;
};

/// What a head knows of a node; for the scheduler and for people.
struct PoolNode {
    uint32_t number = 0;
    std::string name, hardware;
    uint32_t workers = 1;
    std::string refused;     // why it may not render
    double roundTrip = 0.0;  // seconds on the wire, there and back
    uint32_t waiting = 0;    // batches of all heads, as it said last
    uint64_t tiles = 0;      // that it made for this head
    uint64_t rays = 0;       // the same
    double seconds = 0.0;    // that it worked for that
    std::string state;       // "ready", "loading 43 %", ...
};

/// Since the head began.
struct PoolCounts {
    std::atomic<uint64_t> unsound{0};            // messages that are none, or damaged
    std::atomic<uint64_t> late{0};               // for batches that are over
    std::atomic<uint64_t> received{0}, sent{0};  // bytes
    std::atomic<uint64_t> tiles{0}, batches{0};  // that nodes made, that they were asked for
    std::atomic<uint64_t> lost{0};               // batches that a node left undone
};

/// Safe from all threads.
class PoolHead {
public:
    /// `build`: as buildDigest; other nodes are refused.
    PoolHead(std::shared_ptr<Transport> transport, const Digest& build);
    ~PoolHead();
    PoolHead(const PoolHead&) = delete;

    /// Numbers of the nodes that may render now.
    std::vector<uint32_t> nodes() const;
    /// All that are heard, those that are refused too.
    std::vector<PoolNode> report() const;
    /// Nothing where it has gone.
    std::optional<PoolNode> node(uint32_t number) const;
    bool connected() const { return transport_->connected(); }
    std::string peer() const { return transport_->peer(); }
    const PoolCounts& counts() const { return counts_; }

    /// The scene to be handed out to nodes for as long as what is returned lives. The first call for a scene reads all of it.
    std::shared_ptr<const SceneParts> offer(std::shared_ptr<const Scene> scene);
    /// Waits until the node can render the scene. Throws std::runtime_error when it cannot or goes, and what `progress` throws.
    void load(uint32_t number, const Digest& scene, const Settings& settings, const Progress& progress);
    /// Device::render on that node. Throws std::runtime_error when it fails or goes, PoolMemoryError when it has no memory
    /// for that, and what the sink throws.
    void render(uint32_t number, const Digest& scene, const FrameRequest& request, std::span<const Tile> tiles,
                const std::string& device, const std::function<void(TileResult&&)>& sink, std::stop_token stop);

private:
    /// A batch that a node works on.
    struct Pending {
        uint32_t number = 0;
        std::vector<Tile> tiles;
        std::string device;
        std::function<void(size_t piece, TileResult&&)> sink;
        std::mutex mutex;  // of all below; held while a result is handed on
        std::condition_variable_any changed;
        std::vector<bool> came;  // by tile
        uint64_t made = 0, rays = 0;
        std::optional<BatchEnd> end;
        double endedAt = 0.0, heard = 0.0;
        std::string lost;            // why nothing more comes
        std::exception_ptr failure;  // of the sink
        bool isOver = false;         // nothing more is handed on

        void take(std::span<const uint8_t> bytes);
    };
    struct Listening;
    /// What is measured of a node.
    struct Figures {
        double roundTrip = 0.0;
        uint64_t tiles = 0, rays = 0;
        double seconds = 0.0;
        std::optional<LoadState> loading;  // its last word on a scene
    };
    using LoadKey = std::pair<PeerId, Digest>;

    void heardBeat(std::span<const uint8_t> bytes);
    void heardNode(std::span<const uint8_t> bytes);
    void heardAsk(std::span<const uint8_t> bytes);
    void guarded(std::span<const uint8_t> bytes, void (PoolHead::*handler)(std::span<const uint8_t>));
    bool publish(const std::string& subject, std::span<const uint8_t> bytes) const;
    void beat(std::stop_token stop);
    void callOn() const;
    std::vector<uint32_t> forgetful(double now) const;
    void drop(uint32_t number, const std::string& why);
    void lose(const std::vector<Member>& gone, const std::string& why);
    PeerId idOf(uint32_t number) const;
    PoolNode described(const Member& member) const;
    void renderPieces(uint32_t number, const BatchOrder& order, const std::string& device,
                      const std::function<void(size_t piece, TileResult&&)>& sink, std::stop_token stop);
    void conclude(uint32_t number, const BatchEnd& end, bool complete);
    void note(uint32_t number, const BatchEnd& end, double elapsed, uint64_t tiles, uint64_t rays);

    const std::shared_ptr<Transport> transport_;
    const Digest build_;
    const PeerId id_;
    mutable PoolCounts counts_;
    mutable std::mutex mutex_;  // of all below up to offering_
    std::condition_variable loadChanged_;
    Members members_;
    std::map<uint32_t, Figures> figures_;  // by number
    std::map<uint64_t, std::shared_ptr<Pending>> pending_;
    std::map<LoadKey, LoadState> loads_;  // the newest word
    std::map<Digest, std::weak_ptr<const SceneParts>> offers_;
    std::atomic<uint64_t> lastBatch_{0};
    std::mutex offering_;  // held while a scene is read
    std::map<const Scene*, std::weak_ptr<const SceneParts>> known_;
    std::shared_ptr<void> beats_, inbox_, asks_, nobody_;  // subscriptions
    std::jthread beater_;
};

}  // namespace heliograph
