#include "server/pool/wire/messages.h"

#include "server/pool/wire/check_sum.h"
#include "server/pool/wire/request_bytes.h"

#include <cmath>
#include <random>

namespace heliograph {

namespace {

constexpr uint32_t MAGIC = 0x4c504c48;  // "HLPL"
constexpr size_t SUM_AT = sizeof MAGIC + 2 * sizeof(uint16_t), HEADER_BYTES = SUM_AT + sizeof(uint64_t);

void put(ByteWriter& writer, const Digest& digest) { writer.raw(digest.data(), digest.size()); }

Digest digest(ByteReader& reader) {
    Digest value{};
    std::ranges::copy(reader.raw(value.size()), value.begin());
    return value;
}

double seconds(ByteReader& reader) {
    const auto value = reader.get<double>();
    if (!(value >= 0.0) || !std::isfinite(value)) throw PoolMessageError("has a time that is none");
    return value;
}

/// A word of an enumeration whose last one is given.
template <typename Word>
Word word(ByteReader& reader, Word last) {
    const auto value = reader.get<uint8_t>();
    if (value > static_cast<uint8_t>(last)) throw PoolMessageError("has a word that there is not");
    return static_cast<Word>(value);
}

}  // namespace

PeerId newPeerId() {
    std::random_device random;
    return static_cast<PeerId>(random()) << 32 | random();
}

ByteWriter beginMessage(PoolKind kind) {
    ByteWriter writer;
    writer.put(MAGIC);
    writer.put(POOL_VERSION);
    writer.put(static_cast<uint16_t>(kind));
    writer.put(uint64_t{0});  // the sum (`sealed`)
    return writer;
}

std::vector<uint8_t> sealed(ByteWriter&& writer) {
    writer.set(SUM_AT, checkSum(writer.bytes().subspan(HEADER_BYTES)));
    return writer.take();
}

void checkSealed(std::span<const uint8_t> bytes) {
    if (bytes.size() < HEADER_BYTES) throw PoolMessageError("ends too soon");
    const auto sum = ByteReader(bytes.subspan(SUM_AT)).get<uint64_t>();
    if (sum != checkSum(bytes.subspan(HEADER_BYTES))) throw PoolMessageError("was damaged on its way");
}

PoolKind kindOf(std::span<const uint8_t> bytes) {
    ByteReader reader(bytes);
    if (reader.get<uint32_t>() != MAGIC) throw PoolMessageError("is of another protocol");
    const auto version = reader.get<uint16_t>();
    if (version != POOL_VERSION)
        throw PoolMessageError("has version " + std::to_string(version) + ", not " + std::to_string(POOL_VERSION));
    return static_cast<PoolKind>(reader.get<uint16_t>());
}

ByteReader openMessage(std::span<const uint8_t> bytes, PoolKind kind) {
    if (kindOf(bytes) != kind) throw PoolMessageError("is of another kind than what comes here");
    if (bytes.size() < HEADER_BYTES) throw PoolMessageError("ends too soon");
    return ByteReader(bytes.subspan(HEADER_BYTES));
}

std::vector<uint8_t> bytesOf(const NodeBeat& message) {
    ByteWriter writer = beginMessage(PoolKind::nodeBeat);
    writer.put(message.id);
    put(writer, message.build);
    writer.text(message.name);
    writer.text(message.hardware);
    writer.put(message.workers);
    writer.put(message.waiting);
    writer.put(message.tiles);
    return sealed(std::move(writer));
}

template <>
NodeBeat read(std::span<const uint8_t> bytes) {
    ByteReader reader = openMessage(bytes, PoolKind::nodeBeat);
    NodeBeat message;
    message.id = reader.get<PeerId>();
    message.build = digest(reader);
    message.name = reader.text();
    message.hardware = reader.text();
    message.workers = reader.get<uint32_t>();
    message.waiting = reader.get<uint32_t>();
    message.tiles = reader.get<uint64_t>();
    reader.end();
    return message;
}

std::vector<uint8_t> bytesOf(const HeadBeat& message) {
    ByteWriter writer = beginMessage(PoolKind::headBeat);
    writer.put(message.id);
    put(writer, message.build);
    return sealed(std::move(writer));
}

template <>
HeadBeat read(std::span<const uint8_t> bytes) {
    ByteReader reader = openMessage(bytes, PoolKind::headBeat);
    HeadBeat message;
    message.id = reader.get<PeerId>();
    message.build = digest(reader);
    reader.end();
    return message;
}

std::vector<uint8_t> bytesOf(const Refusal& message) {
    ByteWriter writer = beginMessage(PoolKind::refusal);
    writer.put(message.head);
    writer.text(message.why);
    return sealed(std::move(writer));
}

template <>
Refusal read(std::span<const uint8_t> bytes) {
    ByteReader reader = openMessage(bytes, PoolKind::refusal);
    Refusal message;
    message.head = reader.get<PeerId>();
    message.why = reader.text();
    reader.end();
    return message;
}

std::vector<uint8_t> bytesOf(const LoadOrder& message) {
    ByteWriter writer = beginMessage(PoolKind::load);
    writer.put(message.head);
    put(writer, message.scene);
    writeSettings(writer, message.settings);
    return sealed(std::move(writer));
}

template <>
LoadOrder read(std::span<const uint8_t> bytes) {
    ByteReader reader = openMessage(bytes, PoolKind::load);
    LoadOrder message;
    message.head = reader.get<PeerId>();
    message.scene = digest(reader);
    message.settings = readSettings(reader);
    reader.end();
    return message;
}

std::vector<uint8_t> bytesOf(const LoadState& message) {
    ByteWriter writer = beginMessage(PoolKind::loadState);
    writer.put(message.node);
    put(writer, message.scene);
    writer.put(static_cast<uint8_t>(message.state));
    writer.put(message.share);
    writer.text(message.text);
    return sealed(std::move(writer));
}

template <>
LoadState read(std::span<const uint8_t> bytes) {
    ByteReader reader = openMessage(bytes, PoolKind::loadState);
    LoadState message;
    message.node = reader.get<PeerId>();
    message.scene = digest(reader);
    message.state = word(reader, LoadState::State::failed);
    message.share = reader.get<float>();
    if (!(message.share >= 0.0f && message.share <= 1.0f)) throw PoolMessageError("has a share that is none");
    message.text = reader.text();
    reader.end();
    return message;
}

std::vector<uint8_t> bytesOf(const ChunkAsk& message) {
    ByteWriter writer = beginMessage(PoolKind::chunkAsk);
    writer.put(message.node);
    put(writer, message.scene);
    writer.put(message.index);
    return sealed(std::move(writer));
}

template <>
ChunkAsk read(std::span<const uint8_t> bytes) {
    ByteReader reader = openMessage(bytes, PoolKind::chunkAsk);
    ChunkAsk message;
    message.node = reader.get<PeerId>();
    message.scene = digest(reader);
    message.index = reader.get<uint32_t>();
    reader.end();
    return message;
}

std::vector<uint8_t> bytesOf(const Chunk& message) {
    ByteWriter writer = beginMessage(PoolKind::chunk);
    put(writer, message.scene);
    writer.put(message.index);
    writer.raw(message.bytes.data(), message.bytes.size());
    return sealed(std::move(writer));
}

template <>
Chunk read(std::span<const uint8_t> bytes) {
    ByteReader reader = openMessage(bytes, PoolKind::chunk);
    Chunk message;
    message.scene = digest(reader);
    message.index = reader.get<uint32_t>();
    const std::span<const uint8_t> rest = reader.raw(reader.left());
    message.bytes.assign(rest.begin(), rest.end());
    return message;
}

std::vector<uint8_t> bytesOf(const BatchOrder& message) {
    ByteWriter writer = beginMessage(PoolKind::batch);
    writer.put(message.head);
    writer.put(message.id);
    put(writer, message.scene);
    writeRequest(writer, message.request);
    writeTiles(writer, message.tiles);
    return sealed(std::move(writer));
}

template <>
BatchOrder read(std::span<const uint8_t> bytes) {
    ByteReader reader = openMessage(bytes, PoolKind::batch);
    BatchOrder message;
    message.head = reader.get<PeerId>();
    message.id = reader.get<uint64_t>();
    message.scene = digest(reader);
    message.request = readRequest(reader);
    message.tiles = readTiles(reader, message.request, MOST_BATCH_TILES);
    reader.end();
    return message;
}

std::vector<uint8_t> bytesOf(const Cancel& message) {
    ByteWriter writer = beginMessage(PoolKind::cancel);
    writer.put(message.head);
    writer.put(message.id);
    return sealed(std::move(writer));
}

template <>
Cancel read(std::span<const uint8_t> bytes) {
    ByteReader reader = openMessage(bytes, PoolKind::cancel);
    Cancel message;
    message.head = reader.get<PeerId>();
    message.id = reader.get<uint64_t>();
    reader.end();
    return message;
}

std::vector<uint8_t> bytesOf(const BatchEnd& message) {
    ByteWriter writer = beginMessage(PoolKind::batchEnd);
    writer.put(message.id);
    writer.put(static_cast<uint8_t>(message.outcome));
    writer.put(message.nodeSeconds);
    writer.put(message.serviceSeconds);
    writer.text(message.why);
    return sealed(std::move(writer));
}

template <>
BatchEnd read(std::span<const uint8_t> bytes) {
    ByteReader reader = openMessage(bytes, PoolKind::batchEnd);
    BatchEnd message;
    message.id = reader.get<uint64_t>();
    message.outcome = word(reader, BatchEnd::Outcome::stopped);
    message.nodeSeconds = seconds(reader);
    message.serviceSeconds = seconds(reader);
    message.why = reader.text();
    reader.end();
    return message;
}

}  // namespace heliograph
