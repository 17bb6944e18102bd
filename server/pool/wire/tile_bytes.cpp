#include "server/pool/wire/tile_bytes.h"

#include <bit>
#include <cmath>

namespace heliograph {

namespace {

/// How a tile's sums are written.
enum class Coding : uint8_t {
    four,   // four floats a pixel
    three,  // the fourth follows: the squared luminance of one sample
};

float squaredLuminance(const vec4& sum) {
    const float y = LUMINANCE_RED * sum.x + LUMINANCE_GREEN * sum.y + LUMINANCE_BLUE * sum.z;  // as the kernel adds it up
    return y * y;
}

bool sameBits(float a, float b) { return std::bit_cast<uint32_t>(a) == std::bit_cast<uint32_t>(b); }

bool fourthFollows(std::span<const vec4> sums) {
    return std::ranges::all_of(sums, [](const vec4& sum) { return sameBits(sum.w, squaredLuminance(sum)); });
}

constexpr size_t FIXED_BYTES = sizeof(uint32_t) + sizeof(RayCounts::by) + 4 * sizeof(uint64_t) + sizeof(double) + 1;

void writeRays(ByteWriter& writer, const RayCounts& rays) {
    for (uint64_t number : rays.by) writer.put(number);
    writer.put(rays.untraceable);
    writer.put(rays.mediaUnderflows);
    writer.put(rays.mediaOverflows);
}

RayCounts readRays(ByteReader& reader) {
    RayCounts rays;
    for (uint64_t& number : rays.by) number = reader.get<uint64_t>();
    rays.untraceable = reader.get<uint64_t>();
    rays.mediaUnderflows = reader.get<uint64_t>();
    rays.mediaOverflows = reader.get<uint64_t>();
    return rays;
}

std::vector<vec4> readSums(ByteReader& reader, size_t pixels) {
    const auto coding = reader.get<uint8_t>();
    if (coding > static_cast<uint8_t>(Coding::three)) throw PoolMessageError("has pixels in an unknown coding");
    std::vector<vec4> sums(pixels);
    if (coding == static_cast<uint8_t>(Coding::four)) {
        const std::span<const uint8_t> bytes = reader.raw(pixels * sizeof(vec4));
        std::memcpy(sums.data(), bytes.data(), bytes.size());
        return sums;
    }
    const std::span<const uint8_t> bytes = reader.raw(pixels * sizeof(vec3));
    for (size_t i = 0; i < pixels; i++) {
        std::memcpy(&sums[i], bytes.data() + i * sizeof(vec3), sizeof(vec3));
        sums[i].w = squaredLuminance(sums[i]);
    }
    return sums;
}

}  // namespace

TilesWriter::TilesWriter(uint64_t batch) : batch_(batch) { begin(); }

void TilesWriter::begin() {
    writer_ = beginMessage(PoolKind::tiles);
    writer_.put(batch_);
    count_ = 0;
}

void TilesWriter::add(uint32_t index, const TileResult& result) {
    count_++;
    writer_.put(index);
    writeRays(writer_, result.rays);
    writer_.put(result.nonfiniteSamples);
    writer_.put(result.seconds);
    const std::span<const vec4> sums = result.sums();
    if (!fourthFollows(sums)) {
        writer_.put(static_cast<uint8_t>(Coding::four));
        writer_.raw(sums.data(), sums.size_bytes());
        return;
    }
    writer_.put(static_cast<uint8_t>(Coding::three));
    std::vector<vec3> colours(sums.size());
    std::ranges::transform(sums, colours.begin(), [](const vec4& sum) { return vec3(sum); });
    writer_.raw(colours.data(), colours.size() * sizeof(vec3));
}

std::vector<uint8_t> TilesWriter::take() {
    std::vector<uint8_t> bytes = writer_.take();
    begin();
    return bytes;
}

size_t mostTileBytes(size_t pixels) { return FIXED_BYTES + pixels * sizeof(vec4); }

uint64_t batchOf(std::span<const uint8_t> bytes) { return openMessage(bytes, PoolKind::tiles).get<uint64_t>(); }

void readTileResults(std::span<const uint8_t> bytes, std::span<const Tile> tiles, const std::string& device,
                     const std::function<void(size_t index, TileResult&&)>& sink) {
    ByteReader reader = openMessage(bytes, PoolKind::tiles);
    reader.get<uint64_t>();
    while (reader.left() > 0) {
        const auto index = reader.get<uint32_t>();
        if (index >= tiles.size()) throw PoolMessageError("has a tile that nobody asked for");
        TileResult result;
        result.tile = tiles[index];
        result.device = device;
        result.rays = readRays(reader);
        result.nonfiniteSamples = reader.get<uint64_t>();
        result.seconds = reader.get<double>();
        if (!(result.seconds >= 0.0) || !std::isfinite(result.seconds)) throw PoolMessageError("has a time that is none");
        result.radianceSum = readSums(reader, static_cast<size_t>(result.tile.size.x) * result.tile.size.y);
        sink(index, std::move(result));
    }
}

}  // namespace heliograph
