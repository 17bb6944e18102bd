#include "server/pool/wire/request_bytes.h"

#include <cmath>

namespace heliograph {

namespace {

void write(ByteWriter& writer, vec3 value) {
    for (int i = 0; i < 3; i++) writer.put(value[i]);
}

float finite(ByteReader& reader) {
    const auto value = reader.get<float>();
    if (!std::isfinite(value)) throw PoolMessageError("has a number that is none");
    return value;
}

vec3 readVec3(ByteReader& reader) {
    vec3 value;
    for (int i = 0; i < 3; i++) value[i] = finite(reader);
    return value;
}

void write(ByteWriter& writer, const Camera& camera) {
    write(writer, camera.position);
    write(writer, camera.forward);
    write(writer, camera.up);
    writer.put(camera.fieldOfView);
}

/// As it was: not made orthonormal anew, which would turn it by a bit.
Camera readCamera(ByteReader& reader) {
    Camera camera;
    camera.position = readVec3(reader);
    camera.forward = readVec3(reader);
    camera.up = readVec3(reader);
    camera.fieldOfView = finite(reader);
    try {
        checkedCamera(camera);
    } catch (const InputError& error) {
        throw PoolMessageError(error.what());
    }
    return camera;
}

void readValue(ByteReader& reader, bool& value) {
    const auto byte = reader.get<uint8_t>();
    if (byte > 1) throw PoolMessageError("has a switch that is neither on nor off");
    value = byte == 1;
}

void readValue(ByteReader& reader, uint32_t& value, uint32_t low, uint32_t high) {
    value = reader.get<uint32_t>();
    if (value < low || value > high) throw PoolMessageError("has a setting out of its range");
}

void readValue(ByteReader& reader, float& value, float low, float high) {
    value = finite(reader);
    if (value < low || value > high) throw PoolMessageError("has a setting out of its range");
}

void readChoice(ByteReader& reader, uint32_t& value, std::string_view words) {
    readValue(reader, value, 0u, static_cast<uint32_t>(std::ranges::count(words, '|')));
}

/// That a picture may have.
uint64_t knownEffects() {
    uint64_t bits = 0;
    for (const EffectRow& row : effectRows()) bits |= row.bit;
    return bits;
}

}  // namespace

void writeSettings(ByteWriter& writer, const Settings& settings) {
#define SETTING_BOOL(name, group, acts, def, label, effect, price, help) writer.put(static_cast<uint8_t>(settings.name));
#define SETTING(name, group, acts) writer.put(settings.name);
#include "shaders/kernel/settings_table.glsl"
}

Settings readSettings(ByteReader& reader) {
    Settings settings;
#define SETTING_BOOL(name, group, acts, def, label, effect, price, help) readValue(reader, settings.name);
#define SETTING_INT(name, group, acts, def, low, high, unit, label, effect, price, help) \
    readValue(reader, settings.name, low, high);
#define SETTING_FLOAT(name, group, acts, def, low, high, unit, label, effect, price, help) \
    readValue(reader, settings.name, low, high);
#define SETTING_CHOICE(name, group, acts, def, choices, label, effect, price, help) readChoice(reader, settings.name, choices);
#include "shaders/kernel/settings_table.glsl"
    return settings;
}

void writeRequest(ByteWriter& writer, const FrameRequest& request) {
    write(writer, request.camera);
    writer.put(static_cast<uint8_t>(request.previousCamera.has_value()));
    if (request.previousCamera) write(writer, *request.previousCamera);
    writer.put(request.effects.bits);
    writer.put(request.resolution.x);
    writer.put(request.resolution.y);
    writer.put(request.generation);
    writer.put(request.seed);
    writeSettings(writer, request.settings);
}

FrameRequest readRequest(ByteReader& reader) {
    FrameRequest request;
    request.camera = readCamera(reader);
    bool moves = false;
    readValue(reader, moves);
    if (moves) request.previousCamera = readCamera(reader);
    request.effects.bits = reader.get<uint64_t>();
    const bool guides = request.effects.has(EFFECT_GUIDES);
    if ((request.effects.bits & ~(guides ? GUIDE_EFFECTS : knownEffects())) != 0)
        throw PoolMessageError("asks for an effect that there is not");
    readValue(reader, request.resolution.x, 1u, MOST_SIDE);
    readValue(reader, request.resolution.y, 1u, MOST_SIDE);
    request.generation = reader.get<uint32_t>();
    request.seed = reader.get<uint32_t>();
    request.settings = readSettings(reader);
    return request;
}

void writeTiles(ByteWriter& writer, std::span<const Tile> tiles) {
    writer.put(static_cast<uint32_t>(tiles.size()));
    for (const Tile& tile : tiles) {
        for (uint32_t side : {tile.origin.x, tile.origin.y, tile.size.x, tile.size.y}) writer.put(static_cast<uint16_t>(side));
        writer.put(tile.firstSample);
        writer.put(tile.sampleCount);
    }
}

std::vector<Tile> readTiles(ByteReader& reader, const FrameRequest& request, size_t most) {
    const uint32_t number = reader.count(4 * sizeof(uint16_t) + 2 * sizeof(uint32_t));
    if (number == 0 || number > most) throw PoolMessageError("has too many tiles, or none");
    std::vector<Tile> tiles(number);
    for (Tile& tile : tiles) {
        for (uint32_t* side : {&tile.origin.x, &tile.origin.y, &tile.size.x, &tile.size.y}) *side = reader.get<uint16_t>();
        readValue(reader, tile.firstSample, 0u, UINT32_MAX / 2);
        readValue(reader, tile.sampleCount, 1u, UINT32_MAX / 2);
        tile.generation = request.generation;
        const uvec2 end = tile.origin + tile.size;
        if (tile.size.x == 0 || tile.size.y == 0 || end.x > request.resolution.x || end.y > request.resolution.y)
            throw PoolMessageError("has a tile that is not within its picture");
    }
    return tiles;
}

}  // namespace heliograph
