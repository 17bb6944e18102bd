#pragma once
// Measures and parts of the courtyard. Metres. The axes of the columns form a rectangle of baysX x baysZ bays about the
// origin; the court lies inside, the galleries outside. `Side` coordinates: x along the side, z towards the court,
// origin on the side's middle; distances d of rectangle sweeps are measured outwards from the axes.

#include "server/scene/generate/mesh_writer.h"

#include <functional>

namespace heliograph::generate::courtyard {

constexpr float BAY = 3.0f;
constexpr int BAYS_X = 7, BAYS_Z = 5;
constexpr float HALF_X = 0.5f * BAY * BAYS_X, HALF_Z = 0.5f * BAY * BAYS_Z;
constexpr float COURT_FLOOR = -0.32f;
constexpr float WALL = 0.22f;            // half thickness of the arcade walls
constexpr float GALLERY = 2.98f;         // from the axes to the back wall
constexpr float SPRINGING = 3.10f;       // of the lower arches
constexpr float VAULT_CENTER = 1.60f, VAULT_HALF_DEPTH = 1.43f;  // of the gallery vaults, from the axes
constexpr float UPPER_FLOOR = 4.95f;
constexpr float PEDESTAL = 6.00f;        // where the upper columns stand
constexpr float UPPER_SPRINGING = 7.72f;
constexpr float UPPER_TOP = 9.40f;       // of the upper arcade wall
constexpr float EAVES = 9.78f;

struct Materials {
    uint32_t stone, paleStone, plaster, rose, pavers, gallery, brick, roof, wood, door, glaze, bronze, water,
        terracotta, soil, bark, leaf, crimson, indigo;
};

/// Calls `part` with the transform of each of the four sides (side coordinates to world) and the side's number of bays.
void forEachSide(const std::function<void(const mat4& toWorld, int bays)>& part);

void addArcades(MeshWriter& writer, const Materials& materials);    // columns, arches, balustrades, cornices
void addGalleries(MeshWriter& writer, const Materials& materials);  // floors, vaults, back walls, doors, ceilings
void addRoof(MeshWriter& writer, const Materials& materials);
void addCourt(MeshWriter& writer, const Materials& materials);      // pavement, fountain, pots, benches, banners

}  // namespace heliograph::generate::courtyard
