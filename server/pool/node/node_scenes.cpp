#include "server/pool/node/node_scenes.h"

#include "server/base/clock.h"
#include "server/base/log.h"
#include "server/pool/wire/subjects.h"

#include <algorithm>

namespace heliograph {

namespace {

using namespace std::chrono_literals;

constexpr auto CHUNK_WAIT = 100ms;
constexpr double TELL_EVERY = 0.1;  // seconds between words on the same step
/// Chunks that wait to be looked at: what was asked for, twice.
constexpr size_t MOST_CHUNKS = 2 * PartsFetch::MOST_ASKED;

}  // namespace

NodeScenes::NodeScenes(std::shared_ptr<Transport> transport, Options options)
    : transport_(std::move(transport)),
      options_(std::move(options)),
      store_(options_.folder, options_.folderBytes),
      thread_([this](std::stop_token stop) { serve(stop); }) {}

NodeScenes::~NodeScenes() {
    thread_.request_stop();
    thread_.join();
}

void NodeScenes::order(const LoadOrder& order) {
    std::lock_guard lock(mutex_);
    auto [found, isNew] = entries_.try_emplace(order.scene);
    Entry& entry = found->second;
    entry.heads.insert(order.head);
    if (isNew || entry.state == LoadState::State::failed) {  // another try
        entry.state = LoadState::State::loading;
        entry.settings = order.settings;
        wanted_.push_back(order.scene);
        called_.notify_all();
    }
    const LoadState state{options_.node, order.scene, entry.state, entry.share, entry.text};
    transport_->publish(headSubject(order.head), bytesOf(state));
}

void NodeScenes::take(const Chunk& chunk) {
    std::lock_guard lock(mutex_);
    if (fetching_ != chunk.scene || chunks_.size() >= MOST_CHUNKS) return;
    chunks_.push_back(chunk);
    called_.notify_all();
}

bool NodeScenes::isReady(const Digest& scene) const {
    std::lock_guard lock(mutex_);
    const auto found = entries_.find(scene);
    return found != entries_.end() && found->second.state == LoadState::State::ready;
}

std::string NodeScenes::failure(const Digest& scene) const {
    std::lock_guard lock(mutex_);
    const auto found = entries_.find(scene);
    if (found == entries_.end() || found->second.state != LoadState::State::failed) return {};
    return found->second.text;
}

std::shared_ptr<Renderer> NodeScenes::use(const Digest& scene) {
    std::lock_guard lock(mutex_);
    const auto found = entries_.find(scene);
    if (found == entries_.end()) return nullptr;
    found->second.used = ++uses_;
    return found->second.renderer;
}

void NodeScenes::forgetHead(PeerId head) {
    std::lock_guard lock(mutex_);
    for (auto& [scene, entry] : entries_) entry.heads.erase(head);
}

void NodeScenes::serve(std::stop_token stop) {
    while (!stop.stop_requested()) {
        Digest scene{};
        {
            std::unique_lock lock(mutex_);
            if (!called_.wait(lock, stop, [&] { return !wanted_.empty(); })) return;
            scene = wanted_.front();
            wanted_.pop_front();
        }
        try {
            getReady(scene, stop);
        } catch (const std::bad_alloc&) {
            tell(scene, LoadState::State::failed, 0.0f, "no memory for the scene");
        } catch (const std::exception& error) {
            tell(scene, LoadState::State::failed, 0.0f, error.what());
        }
        if (options_.changed) options_.changed(scene);
    }
}

void NodeScenes::getReady(const Digest& scene, std::stop_token stop) {
    const StopWatch watch;
    makeRoom();
    std::shared_ptr<const Scene> built;
    {
        const std::vector<uint8_t> bytes = bytesOfScene(scene, stop);
        built = std::make_shared<const Scene>(sceneOf(bytes));
    }
    Settings settings;
    {
        std::lock_guard lock(mutex_);
        settings = entries_[scene].settings;
    }
    std::shared_ptr<Renderer> renderer = options_.make();
    renderer->load(built, settings, [&](const std::string& what, double share) {
        if (stop.stop_requested()) throw std::runtime_error("the node ends");
        tell(scene, LoadState::State::loading, static_cast<float>(std::clamp(share, 0.0, 1.0)), what);
    });
    {
        std::lock_guard lock(mutex_);
        entries_[scene].renderer = std::move(renderer);
        entries_[scene].used = ++uses_;
    }
    log().info("scene {} ({}) is ready after {:.2f} s", hexOf(scene, 6), built->name, watch.seconds());
    tell(scene, LoadState::State::ready, 1.0f, "ready");
}

/// From the folder, or from a head. Throws std::runtime_error.
std::vector<uint8_t> NodeScenes::bytesOfScene(const Digest& scene, std::stop_token stop) {
    if (std::optional<std::vector<uint8_t>> kept = store_.find(scene)) return std::move(*kept);
    {
        std::lock_guard lock(mutex_);
        fetching_ = scene;
        chunks_.clear();
    }
    const std::vector<uint8_t> listText = fetchList(scene, stop);
    PartList list = readPartList(listText, scene);
    if (options_.sceneBytes > 0 && list.bytes > options_.sceneBytes)
        throw std::runtime_error("the scene has " + std::to_string(list.bytes >> 20) + " MiB; this node takes " +
                                 std::to_string(options_.sceneBytes >> 20));
    PartsFetch fetch(std::move(list));
    while (!fetch.done()) {
        for (uint32_t index : fetch.ask(wallSeconds())) ask(scene, index);
        for (const Chunk& chunk : waitForChunks(stop)) {
            if (!fetch.take(chunk.index, chunk.bytes)) log().warn("part {} of a scene came damaged", chunk.index);
        }
        if (stop.stop_requested()) throw std::runtime_error("the node ends");
        if (fetch.hopeless(wallSeconds())) throw std::runtime_error("a part of the scene did not come, or came damaged");
        tell(scene, LoadState::State::loading, fetch.share(), "fetching the scene");
    }
    std::string why;
    store_.keep(scene, listText, fetch.bytes(), why);
    if (!why.empty()) log().warn("the scene is not kept: {}", why);
    return {fetch.bytes().begin(), fetch.bytes().end()};
}

std::vector<uint8_t> NodeScenes::fetchList(const Digest& scene, std::stop_token stop) {
    bool damaged = false;
    for (uint32_t tries = 0; tries < PartsFetch::MOST_TRIES; tries++) {
        ask(scene, ChunkAsk::LIST);
        const double until = wallSeconds() + PartsFetch::PATIENCE;
        while (wallSeconds() < until && !stop.stop_requested()) {
            for (Chunk& chunk : waitForChunks(stop)) {
                if (chunk.index != ChunkAsk::LIST) continue;
                if (digestOf(chunk.bytes) == scene) return std::move(chunk.bytes);
                damaged = true;
            }
        }
    }
    throw std::runtime_error(damaged ? "the list of the scene's parts came damaged" : "no head hands out the scene");
}

std::vector<Chunk> NodeScenes::waitForChunks(std::stop_token stop) {
    std::unique_lock lock(mutex_);
    called_.wait_for(lock, stop, CHUNK_WAIT, [&] { return !chunks_.empty(); });
    return std::exchange(chunks_, {});
}

/// Of all heads that want the scene any one has it: one after the other, so that one that hangs costs a try.
void NodeScenes::ask(const Digest& scene, uint32_t index) {
    PeerId head = 0;
    {
        std::lock_guard lock(mutex_);
        const std::set<PeerId>& heads = entries_[scene].heads;
        if (heads.empty()) return;
        head = *std::next(heads.begin(), static_cast<ptrdiff_t>(++uses_ % heads.size()));
    }
    transport_->publish(sceneSubject(head), bytesOf(ChunkAsk{options_.node, scene, index}));
}

void NodeScenes::tell(const Digest& scene, LoadState::State state, float share, const std::string& text) {
    if (state == LoadState::State::failed) log().error("scene {}: {}", hexOf(scene, 6), text);
    std::set<PeerId> heads;
    {
        std::lock_guard lock(mutex_);
        Entry& entry = entries_[scene];
        const bool same = entry.state == state && entry.text == text;
        entry.state = state;
        entry.share = share;
        entry.text = text;
        const double now = wallSeconds();
        if (same && now - toldAt_ < TELL_EVERY) return;
        toldAt_ = now;
        heads = entry.heads;
    }
    const std::vector<uint8_t> bytes = bytesOf(LoadState{options_.node, scene, state, share, text});
    for (PeerId head : heads) transport_->publish(headSubject(head), bytes);
}

/// For one more scene. Batches in work hold what they render with.
void NodeScenes::makeRoom() {
    std::vector<std::shared_ptr<Renderer>> gone;  // end without the lock
    std::lock_guard lock(mutex_);
    while (true) {
        auto oldest = entries_.end();
        size_t ready = 0;
        for (auto entry = entries_.begin(); entry != entries_.end(); ++entry) {
            if (!entry->second.renderer) continue;
            ready++;
            if (oldest == entries_.end() || entry->second.used < oldest->second.used) oldest = entry;
        }
        if (ready < options_.mostScenes) return;
        gone.push_back(std::move(oldest->second.renderer));
        entries_.erase(oldest);
    }
}

}  // namespace heliograph
