#pragma once
// Measures and parts of the cathedral. Metres; the nave runs along z, the altar stands at its -z end. Wall coordinates:
// x along the wall, z towards the room, origin on the wall's middle plane.

#include "server/scene/generate/arches.h"

#include <functional>

namespace heliograph::generate::cathedral {

constexpr int BAYS = 6;
constexpr float BAY = 4.6f, HALF_LENGTH = 0.5f * BAY * BAYS;
constexpr float NAVE = 4.0f;             // from the axis to the middle of the nave walls
constexpr float WALL = 0.35f;            // half thickness of the nave walls
constexpr float AISLE = 8.8f;            // to the middle of the outer walls
constexpr float OUTER = 0.40f;           // half thickness of the outer walls
constexpr float SPRINGING = 4.60f;       // arcades and aisle vaults
constexpr float TRIFORIUM = 7.60f, CLERESTORY = 9.50f, WALL_TOP = 15.2f;
constexpr float VAULT_SPRINGING = 9.75f;
const Arch ARCADE = {1.75f, 2.70f};
const Arch NAVE_VAULT = {3.72f, 5.00f};  // across the nave
const Arch AISLE_VAULT = {2.10f, 2.90f};
constexpr float AISLE_CENTER = 6.375f;   // axis of the aisle vaults

struct Materials {
    uint32_t ashlar, stone, shaft, web, floor, recess, oak, gold, wax, flame, iron, linen, ruby, azure, grisaille;
};

/// Calls `part` with the transform of each bay of both walls at distance `x` from the axis (wall coordinates to world).
void forEachBay(float x, const std::function<void(const mat4& toWorld)>& part);
/// The same for the lines between bays, the two ends included.
void forEachBayLine(float x, const std::function<void(const mat4& toWorld)>& part);

/// A window as it stands in a wall: opening, panes and tracery.
struct Window {
    Arch arch;
    float sill = 0.0f, springing = 0.0f, center = 0.0f;
    uint32_t glass = 0;     // material
    bool tracery = true;
};
/// The wall panel, with the window in it. `half`: half thickness of the wall.
void addWindowPanel(MeshWriter& writer, const Materials& materials, float x0, float x1, float y0, float y1, float half,
                    const Window& window);

void addPiers(MeshWriter& writer, const Materials& materials);
void addWalls(MeshWriter& writer, const Materials& materials);
void addVaults(MeshWriter& writer, const Materials& materials);
void addFurniture(MeshWriter& writer, const Materials& materials);
/// Where the chandeliers hang, and the altar's candles: the scene's point lights.
std::vector<vec3> chandelierCenters();

}  // namespace heliograph::generate::cathedral
