#include "server/pool/head.h"

#include "server/base/clock.h"
#include "server/base/log.h"
#include "server/pool/cut_tiles.h"
#include "server/pool/wire/subjects.h"
#include "server/pool/wire/tile_bytes.h"

#include <new>

namespace heliograph {

namespace {

using namespace std::chrono_literals;

constexpr auto LOOK_AROUND = 50ms;
constexpr double ORDER_AGAIN = 2.0;  // seconds after which a node is told again to load
/// Without a word, from a node that has nothing to do.
constexpr double LOST_SECONDS = SILENCE_SECONDS;
constexpr double ROUND_TRIP_WEIGHT = 0.2;
/// A piece's result fits into a message with room to spare.
constexpr size_t MOST_PIECE_PIXELS = 48 * 1024;

}  // namespace

PoolHead::PoolHead(std::shared_ptr<Transport> transport, const Digest& build)
    : transport_(std::move(transport)), build_(build), id_(newPeerId()), members_(build) {
    beats_ =
        transport_->subscribe(NODE_BEATS, [this](std::span<const uint8_t> bytes) { guarded(bytes, &PoolHead::heardBeat); });
    inbox_ = transport_->subscribe(headSubject(id_),
                                   [this](std::span<const uint8_t> bytes) { guarded(bytes, &PoolHead::heardNode); });
    asks_ = transport_->subscribe(sceneSubject(id_),
                                  [this](std::span<const uint8_t> bytes) { guarded(bytes, &PoolHead::heardAsk); });
    nobody_ = transport_->whenNobody([this](uint32_t number) { drop(number, "has gone: it listens no more"); });
    beater_ = std::jthread([this](std::stop_token stop) { beat(stop); });
}

PoolHead::~PoolHead() {
    beater_.request_stop();
    beater_.join();
    beats_.reset();
    inbox_.reset();
    asks_.reset();
    nobody_.reset();
}

/// What strangers send ends nothing.
void PoolHead::guarded(std::span<const uint8_t> bytes, void (PoolHead::*handler)(std::span<const uint8_t>)) {
    counts_.received += bytes.size();
    try {
        checkSealed(bytes);
        (this->*handler)(bytes);
    } catch (const std::exception& error) {
        if (counts_.unsound++ == 0) log().warn("pool: a message was dropped: {}", error.what());
    }
}

void PoolHead::heardBeat(std::span<const uint8_t> bytes) {
    const auto beat = read<NodeBeat>(bytes);
    std::string joined;
    std::optional<Refusal> refusal;
    {
        std::lock_guard lock(mutex_);
        const Members::News news = members_.note(beat, wallSeconds());
        if (news.joined) joined = "node:" + std::to_string(news.joined->number);
        if (news.refused) refusal = Refusal{id_, "this node " + news.refused->refused};
    }
    if (!joined.empty()) log().info("pool: {} joined as {} ({})", shownText(beat.name), joined, shownText(beat.hardware));
    if (!refusal) return;
    log().warn("pool: {} is refused: {}", shownText(beat.name), refusal->why);
    publish(nodeSubject(beat.id), bytesOf(*refusal));
}

void PoolHead::heardNode(std::span<const uint8_t> bytes) {
    const PoolKind kind = kindOf(bytes);
    if (kind == PoolKind::loadState) {
        const auto state = read<LoadState>(bytes);
        std::lock_guard lock(mutex_);
        const auto waited = loads_.find({state.node, state.scene});
        if (waited == loads_.end()) return;
        waited->second = state;
        loadChanged_.notify_all();
        return;
    }
    std::optional<BatchEnd> end;
    if (kind == PoolKind::batchEnd) end = read<BatchEnd>(bytes);
    std::shared_ptr<Pending> pending;
    {
        std::lock_guard lock(mutex_);
        const auto found = pending_.find(end ? end->id : batchOf(bytes));
        if (found != pending_.end()) pending = found->second;
    }
    if (!pending) {
        counts_.late++;
        return;
    }
    std::lock_guard lock(pending->mutex);
    pending->heard = wallSeconds();
    if (end) pending->end = std::move(end), pending->endedAt = wallSeconds();
    else pending->take(bytes);
    if (pending->end || pending->failure) pending->changed.notify_all();
}

/// Hands on what came, here and now: whoever waits for the batch is not woken for each message, which would cost more than the
/// message. With the lock held.
void PoolHead::Pending::take(std::span<const uint8_t> bytes) {
    if (isOver) return;
    try {
        readTileResults(bytes, tiles, device, [this](size_t piece, TileResult&& result) {
            if (came[piece]) return;
            came[piece] = true;
            made++;
            rays += result.rays.total();
            sink(piece, std::move(result));
        });
    } catch (const PoolMessageError&) {
        throw;  // what strangers send ends no batch
    } catch (...) {
        failure = std::current_exception();
        isOver = true;
    }
}

void PoolHead::heardAsk(std::span<const uint8_t> bytes) {
    const auto ask = read<ChunkAsk>(bytes);
    std::shared_ptr<const SceneParts> parts;
    {
        std::lock_guard lock(mutex_);
        const auto found = offers_.find(ask.scene);
        if (found != offers_.end()) parts = found->second.lock();
    }
    if (!parts) return;  // the node asks somebody else, or gives up
    Chunk chunk{ask.scene, ask.index, ask.index == ChunkAsk::LIST ? parts->list() : parts->part(ask.index)};
    publish(nodeSubject(ask.node), bytesOf(chunk));
}

bool PoolHead::publish(const std::string& subject, std::span<const uint8_t> bytes) const {
    counts_.sent += bytes.size();
    return transport_->publish(subject, bytes);
}

/// Says that this head is there, and looks who is not.
void PoolHead::beat(std::stop_token stop) {
    const std::vector<uint8_t> bytes = bytesOf(HeadBeat{id_, build_});
    std::mutex mutex;
    std::condition_variable_any never;
    double next = 0.0;
    while (!stop.stop_requested()) {
        const double now = wallSeconds();
        if (now >= next) {
            publish(HEAD_BEATS, bytes);
            next = now + BEAT_SECONDS;
        }
        std::vector<Member> silent, unreachable;
        {
            std::lock_guard lock(mutex_);
            silent = members_.dropSilent(now);
            if (!transport_->connected()) unreachable = members_.dropAll();
        }
        callOn();
        lose(silent, "has not been heard for 750 ms");
        for (uint32_t number : forgetful(now)) drop(number, "has nothing to do and owes a batch");
        lose(unreachable, "cannot be reached: no line to " + transport_->peer());
        std::unique_lock lock(mutex);
        never.wait_for(lock, stop, LOOK_AROUND, [] { return false; });
    }
}

/// Says something to each node that has a batch, so that the transport tells at once when nobody listens there any more.
void PoolHead::callOn() const {
    std::map<uint32_t, PeerId> busy;
    {
        std::lock_guard lock(mutex_);
        for (const auto& [id, pending] : pending_) {
            if (const Member* member = members_.renders(pending->number)) busy[pending->number] = member->beat.id;
        }
    }
    const std::vector<uint8_t> nothing = bytesOf(Cancel{id_, 0});  // no batch has this number
    for (const auto& [number, id] : busy) transport_->publishFor(number, nodeSubject(id), nothing);
}

/// Nodes that say they have nothing to do while a batch is out with them: what it was told, or what it said, is lost.
std::vector<uint32_t> PoolHead::forgetful(double now) const {
    std::vector<uint32_t> numbers;
    std::lock_guard lock(mutex_);
    for (const auto& [id, pending] : pending_) {
        const Member* member = members_.renders(pending->number);
        if (!member || member->beat.waiting > 0) continue;
        std::lock_guard inner(pending->mutex);
        if (!pending->end && now - pending->heard > LOST_SECONDS) numbers.push_back(pending->number);
    }
    return numbers;
}

/// The node joins anew with its next beat.
void PoolHead::drop(uint32_t number, const std::string& why) {
    std::vector<Member> gone;
    {
        std::lock_guard lock(mutex_);
        if (std::optional<Member> member = members_.drop(number)) gone.push_back(std::move(*member));
    }
    lose(gone, why);
}

void PoolHead::lose(const std::vector<Member>& gone, const std::string& why) {
    for (const Member& member : gone) {
        if (!member.refused.empty()) continue;
        log().warn("pool: node:{} ({}) {}", member.number, shownText(member.beat.name), why);
        std::lock_guard lock(mutex_);
        figures_.erase(member.number);
        for (const auto& [id, pending] : pending_) {
            if (pending->number != member.number) continue;
            std::lock_guard inner(pending->mutex);
            pending->lost = "node:" + std::to_string(member.number) + " " + why;
            pending->changed.notify_all();
        }
        loadChanged_.notify_all();
    }
}

std::vector<uint32_t> PoolHead::nodes() const {
    std::vector<uint32_t> numbers;
    std::lock_guard lock(mutex_);
    for (const Member& member : members_.all()) {
        if (member.refused.empty()) numbers.push_back(member.number);
    }
    return numbers;
}

PoolNode PoolHead::described(const Member& member) const {
    PoolNode node;
    node.number = member.number;
    node.name = shownText(member.beat.name);
    node.hardware = shownText(member.beat.hardware);
    node.workers = std::max(member.beat.workers, 1u);
    node.waiting = member.beat.waiting;
    node.refused = member.refused;
    node.state = member.refused.empty() ? "here" : "refused";
    const auto found = figures_.find(member.number);
    if (found == figures_.end()) return node;
    const Figures& figures = found->second;
    node.roundTrip = figures.roundTrip;
    node.tiles = figures.tiles;
    node.rays = figures.rays;
    node.seconds = figures.seconds;
    if (figures.loading && figures.loading->state == LoadState::State::loading) node.state = shownText(figures.loading->text);
    if (figures.loading && figures.loading->state == LoadState::State::ready) node.state = "ready";
    return node;
}

std::vector<PoolNode> PoolHead::report() const {
    std::vector<PoolNode> nodes;
    std::lock_guard lock(mutex_);
    for (const Member& member : members_.all()) nodes.push_back(described(member));
    return nodes;
}

std::optional<PoolNode> PoolHead::node(uint32_t number) const {
    std::lock_guard lock(mutex_);
    const Member* member = members_.renders(number);
    if (!member) return std::nullopt;
    return described(*member);
}

/// With the lock held.
PeerId PoolHead::idOf(uint32_t number) const {
    const Member* member = members_.renders(number);
    if (!member) throw std::runtime_error("node:" + std::to_string(number) + " has left the pool");
    return member->beat.id;
}

std::shared_ptr<const SceneParts> PoolHead::offer(std::shared_ptr<const Scene> scene) {
    std::lock_guard one(offering_);
    if (std::shared_ptr<const SceneParts> parts = known_[scene.get()].lock()) return parts;
    std::erase_if(known_, [](const auto& entry) { return entry.second.expired(); });
    auto parts = std::make_shared<const SceneParts>(scene);
    known_[scene.get()] = parts;
    std::lock_guard lock(mutex_);
    std::erase_if(offers_, [](const auto& entry) { return entry.second.expired(); });
    offers_[parts->name()] = parts;
    return parts;
}

void PoolHead::load(uint32_t number, const Digest& scene, const Settings& settings, const Progress& progress) {
    const std::vector<uint8_t> order = bytesOf(LoadOrder{id_, scene, settings});
    std::unique_lock lock(mutex_);
    const PeerId id = idOf(number);
    const LoadKey key{id, scene};
    loads_[key] = {id, scene, LoadState::State::loading, 0.0f, "waiting"};
    double told = -ORDER_AGAIN;
    while (true) {
        if (wallSeconds() - told >= ORDER_AGAIN) {
            told = wallSeconds();
            lock.unlock();
            publish(nodeSubject(id), order);
            lock.lock();
        }
        loadChanged_.wait_for(lock, LOOK_AROUND);
        const LoadState state = loads_[key];
        if (!members_.renders(number)) {
            loads_.erase(key);
            throw std::runtime_error("node:" + std::to_string(number) + " left while it was given the scene");
        }
        figures_[number].loading = state;
        if (state.state == LoadState::State::ready) break;
        if (state.state == LoadState::State::failed) {
            loads_.erase(key);
            throw std::runtime_error("node:" + std::to_string(number) + ": " + shownText(state.text));
        }
        lock.unlock();
        heliograph::report(progress, shownText(state.text), state.share);
        lock.lock();
    }
    loads_.erase(key);
}

void PoolHead::render(uint32_t number, const Digest& scene, const FrameRequest& request, std::span<const Tile> tiles,
                      const std::string& device, const std::function<void(TileResult&&)>& sink, std::stop_token stop) {
    CutTiles cut(tiles, MOST_PIECE_PIXELS);
    for (size_t first = 0; first < cut.pieces().size() && !stop.stop_requested(); first += MOST_BATCH_TILES) {
        const size_t last = std::min(cut.pieces().size(), first + MOST_BATCH_TILES);
        const BatchOrder order{
            id_,
            ++lastBatch_,
            scene,
            request,
            {cut.pieces().begin() + static_cast<ptrdiff_t>(first), cut.pieces().begin() + static_cast<ptrdiff_t>(last)}};
        auto joined = [&](size_t piece, TileResult&& result) {
            if (std::optional<TileResult> whole = cut.join(first + piece, std::move(result))) sink(std::move(*whole));
        };
        renderPieces(number, order, device, joined, stop);
    }
}

/// Listens to a batch for as long as it lives, waiting for a result that is being handed on; one that is not over is called off.
struct PoolHead::Listening {
    PoolHead& head;
    const PeerId node;
    const uint64_t batch;
    const std::shared_ptr<Pending> pending;
    bool over = false;
    ~Listening() {
        {
            std::lock_guard lock(head.mutex_);
            head.pending_.erase(batch);
        }
        {
            std::lock_guard lock(pending->mutex);
            pending->isOver = true;
        }
        head.counts_.tiles += pending->made;
        if (!over) head.publish(nodeSubject(node), bytesOf(Cancel{head.id_, batch}));
    }
};

void PoolHead::renderPieces(uint32_t number, const BatchOrder& order, const std::string& device,
                            const std::function<void(size_t piece, TileResult&&)>& sink, std::stop_token stop) {
    auto pending = std::make_shared<Pending>();
    pending->number = number;
    pending->heard = wallSeconds();
    pending->tiles = order.tiles;
    pending->device = device;
    pending->sink = sink;
    pending->came.resize(order.tiles.size(), false);
    PeerId id = 0;
    {
        std::lock_guard lock(mutex_);
        id = idOf(number);
        pending_[order.id] = pending;
    }
    Listening listening{*this, id, order.id, pending};
    const double begin = wallSeconds();
    counts_.batches++;
    if (!publish(nodeSubject(id), bytesOf(order)))
        throw std::runtime_error("node:" + std::to_string(number) + " cannot be reached: no line to " + transport_->peer());
    std::unique_lock lock(pending->mutex);
    pending->changed.wait(lock, stop, [&] { return pending->end || pending->failure || !pending->lost.empty(); });
    if (pending->failure) std::rethrow_exception(pending->failure);
    const std::optional<BatchEnd> end = pending->end;
    if (!end && !pending->lost.empty()) {
        counts_.lost++;
        throw std::runtime_error(pending->lost);
    }
    if (!end) return;  // stopped
    listening.over = true;
    const uint64_t made = pending->made, rays = pending->rays;
    const double elapsed = pending->endedAt - begin;
    lock.unlock();
    note(number, *end, elapsed, made, rays);
    if (!stop.stop_requested()) conclude(number, *end, made == order.tiles.size());
}

/// Throws what `render` throws for a batch that ended so. Who lost results or left joins anew.
void PoolHead::conclude(uint32_t number, const BatchEnd& end, bool complete) {
    std::string why = shownText(end.why);
    switch (end.outcome) {
        case BatchEnd::Outcome::done:
            if (complete) return;
            why = "made results that did not arrive";
            drop(number, why);
            break;
        case BatchEnd::Outcome::noMemory: throw PoolMemoryError(why);
        case BatchEnd::Outcome::stopped: drop(number, "left a batch"); break;
        case BatchEnd::Outcome::failed: break;
    }
    counts_.lost++;
    throw std::runtime_error("node:" + std::to_string(number) + " " + why);
}

void PoolHead::note(uint32_t number, const BatchEnd& end, double elapsed, uint64_t tiles, uint64_t rays) {
    std::lock_guard lock(mutex_);
    if (!members_.renders(number)) return;
    Figures& figures = figures_[number];
    const double trip = std::max(elapsed - end.nodeSeconds, 0.0);
    figures.roundTrip += (figures.roundTrip > 0.0 ? ROUND_TRIP_WEIGHT : 1.0) * (trip - figures.roundTrip);
    figures.tiles += tiles;
    figures.rays += rays;
    figures.seconds += end.serviceSeconds;
}

}  // namespace heliograph
