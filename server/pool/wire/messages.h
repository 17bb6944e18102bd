#pragma once
// What heads and nodes of a pool say to each other. Each message begins with the same words: magic, version, kind, and a sum of
// all that follows, which is checked where a message comes in. Readers take bytes of strangers: they throw PoolMessageError and
// never look past the end.

#include "server/film/tile.h"
#include "server/pool/wire/bytes.h"
#include "server/pool/wire/digest.h"
#include "server/request/frame_request.h"

namespace heliograph {

/// Grows with every change of a layout; others are not understood.
constexpr uint16_t POOL_VERSION = 2;

enum class PoolKind : uint16_t {
    nodeBeat = 1,   // node to all heads, every BEAT_SECONDS
    headBeat = 2,   // head to all nodes, the same
    refusal = 3,    // head to a node: it is not taken, and why
    load = 4,       // head to a node: get this scene ready
    loadState = 5,  // node to the head: how far that is
    chunkAsk = 6,   // node to the head: a part of a scene, please
    chunk = 7,      // head to the node
    batch = 8,      // head to a node: render these tiles
    cancel = 9,     // head to a node: that batch is not wanted any more
    tiles = 10,     // node to the head: some of a batch's results
    batchEnd = 11,  // node to the head: nothing more comes of that batch
};

constexpr double BEAT_SECONDS = 0.25;
/// A peer that has not been heard for so long is gone: three beats.
constexpr double SILENCE_SECONDS = 0.75;

/// Names a head or a node for as long as it runs; random.
using PeerId = uint64_t;

/// A new peer's name.
PeerId newPeerId();

struct NodeBeat {
    PeerId id = 0;
    Digest build{};
    std::string name;      // of its host, or what its user calls it
    std::string hardware;  // for people: processor, GPU
    uint32_t workers = 1;  // of its devices together
    uint32_t waiting = 0;  // batches of all heads
    uint64_t tiles = 0;    // made since it began
};

struct HeadBeat {
    PeerId id = 0;
    Digest build{};
};

struct Refusal {
    PeerId head = 0;
    std::string why;
};

struct LoadOrder {
    PeerId head = 0;
    Digest scene{};  // of its list of parts (scene_parts.h)
    Settings settings;
};

struct LoadState {
    enum class State : uint8_t { loading, ready, failed };
    PeerId node = 0;
    Digest scene{};
    State state = State::loading;
    float share = 0.0f;  // of what `text` names
    std::string text;    // what is being done, or why it failed
};

struct ChunkAsk {
    /// The list of parts itself.
    static constexpr uint32_t LIST = UINT32_MAX;
    PeerId node = 0;
    Digest scene{};
    uint32_t index = LIST;
};

struct Chunk {
    Digest scene{};
    uint32_t index = 0;
    std::vector<uint8_t> bytes;
};

struct BatchOrder {
    PeerId head = 0;
    uint64_t id = 0;  // the head's own
    Digest scene{};
    FrameRequest request;
    std::vector<Tile> tiles;
};

struct Cancel {
    PeerId head = 0;
    uint64_t id = 0;
};

struct BatchEnd {
    enum class Outcome : uint8_t { done, failed, noMemory, stopped };
    uint64_t id = 0;
    Outcome outcome = Outcome::done;
    double nodeSeconds = 0.0;     // from its arrival to this message
    double serviceSeconds = 0.0;  // the part of it in which no other batch of this head was in work
    std::string why;
};

/// Most tiles of one batch: so that it fits into a message.
constexpr size_t MOST_BATCH_TILES = 16384;

std::vector<uint8_t> bytesOf(const NodeBeat& message);
std::vector<uint8_t> bytesOf(const HeadBeat& message);
std::vector<uint8_t> bytesOf(const Refusal& message);
std::vector<uint8_t> bytesOf(const LoadOrder& message);
std::vector<uint8_t> bytesOf(const LoadState& message);
std::vector<uint8_t> bytesOf(const ChunkAsk& message);
std::vector<uint8_t> bytesOf(const Chunk& message);
/// All tiles have the request's generation.
std::vector<uint8_t> bytesOf(const BatchOrder& message);
std::vector<uint8_t> bytesOf(const Cancel& message);
std::vector<uint8_t> bytesOf(const BatchEnd& message);

/// What the bytes are. Throws PoolMessageError for another protocol or version.
PoolKind kindOf(std::span<const uint8_t> bytes);
/// Reads a message of that type; throws PoolMessageError if it is another one or unsound: values that no peer of this build
/// sends.
template <typename Message>
Message read(std::span<const uint8_t> bytes);
template <>
NodeBeat read(std::span<const uint8_t> bytes);
template <>
HeadBeat read(std::span<const uint8_t> bytes);
template <>
Refusal read(std::span<const uint8_t> bytes);
template <>
LoadOrder read(std::span<const uint8_t> bytes);
template <>
LoadState read(std::span<const uint8_t> bytes);
template <>
ChunkAsk read(std::span<const uint8_t> bytes);
template <>
Chunk read(std::span<const uint8_t> bytes);
template <>
BatchOrder read(std::span<const uint8_t> bytes);
template <>
Cancel read(std::span<const uint8_t> bytes);
template <>
BatchEnd read(std::span<const uint8_t> bytes);

/// Begins a message; the same words that `kindOf` reads.
ByteWriter beginMessage(PoolKind kind);
/// A message that was begun so, with its sum.
std::vector<uint8_t> sealed(ByteWriter&& writer);
/// Throws PoolMessageError for what has not the sum that it says.
void checkSealed(std::span<const uint8_t> bytes);
/// A reader behind those words; throws if the message is of another kind.
ByteReader openMessage(std::span<const uint8_t> bytes, PoolKind kind);

}  // namespace heliograph
