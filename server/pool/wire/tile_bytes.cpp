#include "server/pool/wire/tile_bytes.h"

#include <bit>
#include <cmath>

namespace heliograph {

namespace {

/// How a tile's sums are written.
enum class Coding : uint8_t {
    four,   // four floats a pixel
    three,  // all reds, all greens, all blues; the fourth follows: the squared luminance of one sample
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

/// The planes of a tile that was written as `three`.
void joinPlanes(const uint8_t* planes, std::span<vec4> sums) {
    const size_t plane = sums.size() * sizeof(float);
    for (size_t i = 0; i < sums.size(); i++) {
        float rgb[3];
        for (size_t c = 0; c < 3; c++) std::memcpy(&rgb[c], planes + c * plane + i * sizeof(float), sizeof(float));
        sums[i] = vec4(rgb[0], rgb[1], rgb[2], 0.0f);
        sums[i].w = squaredLuminance(sums[i]);
    }
}

void readSums(ByteReader& reader, std::span<vec4> sums) {
    const auto coding = reader.get<uint8_t>();
    if (coding > static_cast<uint8_t>(Coding::three)) throw PoolMessageError("has pixels in an unknown coding");
    if (coding == static_cast<uint8_t>(Coding::four))
        std::memcpy(sums.data(), reader.raw(sums.size_bytes()).data(), sums.size_bytes());
    else joinPlanes(reader.raw(sums.size() * sizeof(vec3)).data(), sums);
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
    for (int c = 0; c < 3; c++) {
        plane_.resize(sums.size());
        std::ranges::transform(sums, plane_.begin(), [c](const vec4& sum) { return sum[c]; });
        writer_.raw(plane_.data(), plane_.size() * sizeof(float));
    }
}

std::vector<uint8_t> TilesWriter::take() {
    std::vector<uint8_t> bytes = sealed(std::move(writer_));
    begin();
    return bytes;
}

size_t mostTileBytes(size_t pixels) { return FIXED_BYTES + pixels * sizeof(vec4); }

uint64_t batchOf(std::span<const uint8_t> bytes) { return openMessage(bytes, PoolKind::tiles).get<uint64_t>(); }

void readTileResults(std::span<const uint8_t> bytes, std::span<const Tile> tiles, const std::string& device,
                     const std::function<void(size_t index, TileResult&&)>& sink) {
    ByteReader reader = openMessage(bytes, PoolKind::tiles);
    reader.get<uint64_t>();
    std::vector<vec4> sums;  // of one tile after the other: they stay in the processor's cache
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
        const size_t pixels = static_cast<size_t>(result.tile.size.x) * result.tile.size.y;
        if (sums.size() < pixels) sums.resize(pixels);
        result.mapped = std::span(sums).first(pixels);
        readSums(reader, std::span(sums).first(pixels));
        sink(index, std::move(result));
    }
}

}  // namespace heliograph
