#include "server/pool/node/render_node.h"

#include "server/base/clock.h"
#include "server/base/log.h"
#include "server/base/text.h"
#include "server/pool/members.h"
#include "server/pool/wire/subjects.h"
#include "server/pool/wire/tile_bytes.h"

#include <unordered_map>

namespace heliograph {

namespace {

using namespace std::chrono_literals;

/// Heads that a node has not heard for so long (seconds) are forgotten: later than they would forget it.
constexpr double HEAD_SILENCE = 3.0;
constexpr size_t MOST_HEADS = 256;
/// A message with results goes when it has so many bytes, or when something has waited in it for so long (seconds).
constexpr size_t FULL_MESSAGE = 96 * 1024;  // with the last tile below 128 KiB: more is mapped and unmapped for each message
constexpr double LONGEST_WAIT = 0.03;

uint64_t placeOf(const Tile& tile) { return static_cast<uint64_t>(tile.origin.x) << 32 | tile.origin.y; }

/// What the head's choice of devices means here: all that this node has.
FrameRequest forThisNode(FrameRequest request) {
    const Settings usual;
    Settings& settings = request.settings;
    settings.device = usual.device;
    settings.enableEmbree = usual.enableEmbree;
    settings.enableVulkan = usual.enableVulkan;
    settings.hybridBalance = usual.hybridBalance;
    settings.embreeThreads = usual.embreeThreads;
    settings.showPartition = false;
    return request;
}

/// Results on their way out. From several threads.
class Outbox {
public:
    /// `begin`: when the batch began to be in work; what tiles take is counted from there.
    Outbox(Transport& transport, const BatchOrder& order, double begin)
        : transport_(transport), subject_(headSubject(order.head)), writer_(order.id), stamped_(begin) {
        for (uint32_t i = 0; i < order.tiles.size(); i++) indices_[placeOf(order.tiles[i])] = i;
    }
    void add(TileResult& result) {
        const auto found = indices_.find(placeOf(result.tile));
        if (found == indices_.end()) return;
        std::lock_guard lock(mutex_);
        const double now = wallSeconds();
        result.seconds = std::max(now - std::exchange(stamped_, now), 0.0);
        if (writer_.empty()) since_ = now;
        const size_t most = mostTileBytes(result.sums().size());
        if (!writer_.empty() && writer_.size() + most > MOST_MESSAGE_BYTES) send();
        writer_.add(found->second, result);
        if (writer_.size() >= FULL_MESSAGE || now - since_ >= LONGEST_WAIT) send();
    }
    void flush() {
        std::lock_guard lock(mutex_);
        if (!writer_.empty()) send();
    }

private:
    void send() {
        transport_.publish(subject_, writer_.take());
        since_ = wallSeconds();
    }

    Transport& transport_;
    const std::string subject_;
    std::unordered_map<uint64_t, uint32_t> indices_;
    std::mutex mutex_;
    TilesWriter writer_;
    double since_ = 0.0;    // something waits
    double stamped_ = 0.0;  // the result before
};

}  // namespace

RenderNode::RenderNode(std::shared_ptr<Transport> transport, RenderNodeOptions options)
    : transport_(std::move(transport)), options_(std::move(options)), id_(newPeerId()), pace_(options_.raysPerSecond) {
    NodeScenes::Options scenes;
    scenes.node = id_;
    scenes.make = options_.make;
    scenes.folder = options_.folder;
    scenes.sceneBytes = options_.sceneBytes;
    scenes.changed = [this](const Digest& scene) { sceneChanged(scene); };
    scenes_ = std::make_unique<NodeScenes>(transport_, std::move(scenes));
    inbox_ =
        transport_->subscribe(nodeSubject(id_), [this](std::span<const uint8_t> bytes) { guarded(bytes, &RenderNode::heard); });
    headBeats_ =
        transport_->subscribe(HEAD_BEATS, [this](std::span<const uint8_t> bytes) { guarded(bytes, &RenderNode::heardHead); });
    worker_ = std::jthread([this](std::stop_token stop) { work(stop); });
    beater_ = std::jthread([this](std::stop_token stop) { beat(stop); });
}

RenderNode::~RenderNode() {
    for (std::jthread* thread : {&beater_, &worker_}) {
        thread->request_stop();
        thread->join();
    }
    inbox_.reset();
    headBeats_.reset();
    scenes_.reset();
}

void RenderNode::guarded(std::span<const uint8_t> bytes, void (RenderNode::*handler)(std::span<const uint8_t>)) {
    try {
        checkSealed(bytes);
        (this->*handler)(bytes);
    } catch (const std::exception& error) {
        if (unsound_++ == 0) log().warn("pool: a message was dropped: {}", error.what());
    }
}

void RenderNode::heard(std::span<const uint8_t> bytes) {
    switch (kindOf(bytes)) {
        case PoolKind::load: return scenes_->order(read<LoadOrder>(bytes));
        case PoolKind::chunk: return scenes_->take(read<Chunk>(bytes));
        case PoolKind::batch: return take(read<BatchOrder>(bytes));
        case PoolKind::cancel: return cancel(read<Cancel>(bytes));
        case PoolKind::refusal: {
            const auto refusal = read<Refusal>(bytes);
            std::lock_guard lock(mutex_);
            if (refusal.why == refusal_) return;
            refusal_ = refusal.why;
            log().error("pool: refused by head {}: {}", peerText(refusal.head), oneLine(refusal.why));
            return;
        }
        default: throw PoolMessageError("is of a kind that no node is sent");
    }
}

void RenderNode::heardHead(std::span<const uint8_t> bytes) {
    const auto beat = read<HeadBeat>(bytes);
    std::lock_guard lock(mutex_);
    if (beat.build != options_.build) return;  // it refuses this node
    if (!headsHeard_.contains(beat.id)) {
        if (headsHeard_.size() >= MOST_HEADS) return;
        log().info("pool: head {} is there", peerText(beat.id));
    }
    headsHeard_[beat.id] = wallSeconds();
}

size_t RenderNode::heads() const {
    std::lock_guard lock(mutex_);
    return headsHeard_.size();
}

void RenderNode::take(BatchOrder order) {
    std::unique_lock lock(mutex_);
    if (!headsHeard_.contains(order.head)) {
        if (headsHeard_.size() >= MOST_HEADS) return;
        headsHeard_[order.head] = wallSeconds();
    }
    const PeerId head = order.head;
    const uint64_t id = order.id;
    const LoadOrder load{head, order.scene, order.request.settings};
    const bool isReady = scenes_->isReady(order.scene);
    if (!queue_.add({std::move(order), wallSeconds()})) {
        lock.unlock();
        return end(head, {id, BatchEnd::Outcome::failed, 0.0, 0.0, "has too many batches of this head"});
    }
    called_.notify_all();
    lock.unlock();
    if (!isReady) scenes_->order(load);  // it had to make room for others
}

void RenderNode::cancel(const Cancel& cancel) {
    std::lock_guard lock(mutex_);
    queue_.remove(cancel.head, cancel.id);
    if (inWork_ && inWork_->head == cancel.head && inWork_->id == cancel.id) inWork_->stop.request_stop();
}

void RenderNode::beat(std::stop_token stop) {
    std::mutex mutex;
    std::condition_variable_any never;
    while (!stop.stop_requested()) {
        NodeBeat beat{id_, options_.build, options_.name, options_.hardware, options_.workers, 0, tiles_};
        {
            std::lock_guard lock(mutex_);
            beat.waiting = static_cast<uint32_t>(queue_.size() + (inWork_ ? 1 : 0));
        }
        transport_->publish(NODE_BEATS, bytesOf(beat));
        forgetSilentHeads(wallSeconds());
        std::unique_lock lock(mutex);
        never.wait_for(lock, stop, std::chrono::duration<double>(BEAT_SECONDS), [] { return false; });
    }
}

void RenderNode::forgetSilentHeads(double now) {
    std::vector<PeerId> gone;
    {
        std::lock_guard lock(mutex_);
        std::erase_if(headsHeard_, [&](const auto& head) {
            if (now - head.second < HEAD_SILENCE) return false;
            gone.push_back(head.first);
            return true;
        });
        for (PeerId head : gone) {
            queue_.removeHead(head);
            lastEnd_.erase(head);
            if (inWork_ && inWork_->head == head) inWork_->stop.request_stop();
        }
    }
    for (PeerId head : gone) {
        scenes_->forgetHead(head);
        log().warn("pool: head {} has not been heard for 3 s", peerText(head));
    }
}

/// Batches of a scene that failed are answered.
void RenderNode::sceneChanged(const Digest& scene) {
    const std::string why = scenes_->failure(scene);
    std::vector<WaitingBatch> gone;
    {
        std::lock_guard lock(mutex_);
        if (!why.empty()) gone = queue_.removeScene(scene);
        called_.notify_all();
    }
    for (const WaitingBatch& batch : gone) end(batch.order.head, {batch.order.id, BatchEnd::Outcome::failed, 0.0, 0.0, why});
}

void RenderNode::work(std::stop_token stop) {
    while (!stop.stop_requested()) {
        std::optional<WaitingBatch> batch;
        std::stop_source ofBatch;
        {
            std::unique_lock lock(mutex_);
            auto ready = [&](const Digest& scene) { return scenes_->isReady(scene); };
            called_.wait(lock, stop, [&] { return (batch = queue_.next(ready)).has_value(); });
            if (!batch) return;
            inWork_ = InWork{batch->order.head, batch->order.id, ofBatch};
        }
        const std::stop_callback both(stop, [&] { ofBatch.request_stop(); });
        render(*batch, ofBatch.get_token());
        std::lock_guard lock(mutex_);
        inWork_.reset();
    }
}

void RenderNode::render(const WaitingBatch& batch, std::stop_token stop) {
    const PeerId head = batch.order.head;
    double begin = wallSeconds();
    {
        std::lock_guard lock(mutex_);
        begin =
            std::min(std::max(batch.arrived, lastEnd_[head]), begin);  // other heads' batches meanwhile slow this one's down
    }
    BatchEnd answer{batch.order.id, BatchEnd::Outcome::failed, 0.0, 0.0, "has no such scene any more"};
    if (const std::shared_ptr<Renderer> renderer = scenes_->use(batch.order.scene))
        answer = renderTiles(batch.order, *renderer, begin, stop);
    const double now = wallSeconds();
    {
        std::lock_guard lock(mutex_);
        lastEnd_[head] = now;
    }
    answer.serviceSeconds = now - begin;
    answer.nodeSeconds = now - batch.arrived;
    end(head, std::move(answer));
}

BatchEnd RenderNode::renderTiles(const BatchOrder& order, Renderer& renderer, double begin, std::stop_token stop) {
    BatchEnd answer{order.id, BatchEnd::Outcome::done, 0.0, 0.0, {}};
    try {
        Outbox outbox(*transport_, order, begin);
        ViewMemory view;
        view.costs.begin(order.request.resolution, uvec2(CELL_SIZE));
        auto sink = [&](TileResult&& result) {
            tiles_++;
            pace_.hold(result.rays.total(), begin, stop);
            outbox.add(result);
        };
        renderer.render(forThisNode(order.request), order.tiles, view, sink, stop);
        outbox.flush();
        if (stop.stop_requested()) answer.outcome = BatchEnd::Outcome::stopped, answer.why = "was stopped";
    } catch (const std::bad_alloc& error) {
        answer.outcome = BatchEnd::Outcome::noMemory;
        answer.why = error.what();
    } catch (const std::exception& error) {
        answer.outcome = BatchEnd::Outcome::failed;
        answer.why = error.what();
    }
    return answer;
}

void RenderNode::end(PeerId head, BatchEnd end) { transport_->publish(headSubject(head), bytesOf(end)); }

}  // namespace heliograph
