#pragma once
// Requests, settings and tiles as bytes. Both ends are the same build (digest.h), so the layout follows from the tables.

#include "server/film/tile.h"
#include "server/pool/wire/bytes.h"
#include "server/request/frame_request.h"

namespace heliograph {

void writeSettings(ByteWriter& writer, const Settings& settings);
/// Throws PoolMessageError for a value out of its row's range.
Settings readSettings(ByteReader& reader);

void writeRequest(ByteWriter& writer, const FrameRequest& request);
/// Throws PoolMessageError for what no head asks for: bad settings, cameras that are none, pictures without pixels or with more
/// than MOST_SIDE a side, effects that no row has.
FrameRequest readRequest(ByteReader& reader);
constexpr uint32_t MOST_SIDE = 16384;

void writeTiles(ByteWriter& writer, std::span<const Tile> tiles);
/// Of this request: throws PoolMessageError for a tile that is not within the picture or has no samples.
std::vector<Tile> readTiles(ByteReader& reader, const FrameRequest& request, size_t most);

}  // namespace heliograph
