#pragma once
// The scenes of a node: fetched from heads or from its folder, each with the devices that hold it. One thread gets them ready, one
// after the other.

#include "server/pool/node/part_store.h"
#include "server/pool/parts_fetch.h"
#include "server/pool/wire/messages.h"
#include "server/pool/transport.h"
#include "server/render/renderer.h"

#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <set>
#include <thread>

namespace heliograph {

/// Makes what renders a scene on this node.
using MakeRenderer = std::function<std::unique_ptr<Renderer>()>;

/// Safe from all threads.
class NodeScenes {
public:
    struct Options {
        PeerId node = 0;
        MakeRenderer make;
        std::filesystem::path folder;                // of kept scenes; empty: none are kept
        uint64_t folderBytes = 8ull << 30;           // at most
        uint64_t sceneBytes = 0;                     // the largest scene that is taken; 0: any
        size_t mostScenes = 4;                       // ready at once; those that were used longest ago go
        std::function<void(const Digest&)> changed;  // a scene is ready or has failed; called from the thread
    };
    NodeScenes(std::shared_ptr<Transport> transport, Options options);
    ~NodeScenes();
    NodeScenes(const NodeScenes&) = delete;

    /// Gets the scene ready, unless it is; the head is told how far it is.
    void order(const LoadOrder& order);
    /// A part has come.
    void take(const Chunk& chunk);
    bool isReady(const Digest& scene) const;
    /// Why it is not and will not be; empty otherwise.
    std::string failure(const Digest& scene) const;
    /// Null where the scene is not ready.
    std::shared_ptr<Renderer> use(const Digest& scene);
    /// A head has gone.
    void forgetHead(PeerId head);

private:
    struct Entry {
        LoadState::State state = LoadState::State::loading;
        std::string text = "waiting";
        float share = 0.0f;
        std::set<PeerId> heads;  // that want to know
        Settings settings;
        std::shared_ptr<Renderer> renderer;
        uint64_t used = 0;
    };

    void serve(std::stop_token stop);
    void getReady(const Digest& scene, std::stop_token stop);
    std::vector<uint8_t> bytesOfScene(const Digest& scene, std::stop_token stop);
    std::vector<uint8_t> fetchList(const Digest& scene, std::stop_token stop);
    std::vector<Chunk> waitForChunks(std::stop_token stop);
    void ask(const Digest& scene, uint32_t index);
    void tell(const Digest& scene, LoadState::State state, float share, const std::string& text);
    void makeRoom();

    const std::shared_ptr<Transport> transport_;
    const Options options_;
    const PartStore store_;
    mutable std::mutex mutex_;  // of all below
    std::condition_variable_any called_;
    std::map<Digest, Entry> entries_;
    std::deque<Digest> wanted_;
    std::optional<Digest> fetching_;
    std::vector<Chunk> chunks_;  // that have come for it
    uint64_t uses_ = 0;
    double toldAt_ = 0.0;
    std::jthread thread_;
};

}  // namespace heliograph
