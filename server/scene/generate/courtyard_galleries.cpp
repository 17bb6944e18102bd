#include "server/scene/generate/courtyard_parts.h"

#include "server/scene/generate/arches.h"

#include <cmath>

namespace heliograph::generate::courtyard {

namespace {

const Arch VAULT = {1.5f, 1.5f};

/// One bay's vault, centred on `x` of the side. The vault's long ends reach into the walls.
void addVaultBay(MeshWriter& writer, const mat4& center) {
    writer.setTransform(center * placed({0.0f, SPRINGING, 0.0f}));
    addGroinVault(writer, VAULT, VAULT_HALF_DEPTH, 8);
}

/// A band across the gallery under the joint of two vaults, from the arcade to the back wall; and the pilaster it lands
/// on.
void addTransverseArch(MeshWriter& writer, const Materials& materials, const mat4& side, float x) {
    const float squeeze = VAULT_HALF_DEPTH / VAULT.halfSpan;
    const mat4 across = side * placed({x, SPRINGING, -VAULT_CENTER}) *
                        glm::rotate(mat4(1.0f), glm::radians(90.0f), vec3(0, 1, 0)) *
                        glm::scale(mat4(1.0f), vec3(squeeze, 1.0f, 1.0f));
    writer.setMaterial(materials.stone);
    writer.setTransform(across);
    addArchMoulding(
        writer, VAULT,
        {{0.12f, -0.20f}, {-0.05f, -0.20f}, {-0.09f, -0.14f}, {-0.09f, 0.14f}, {-0.05f, 0.20f}, {0.12f, 0.20f}}, 6);
    writer.setTransform(side);
    const float wall = -GALLERY;
    addBox(writer, {x - 0.20f, 0.25f, wall - 0.05f}, {x + 0.20f, SPRINGING - 0.08f, wall + 0.12f},
           BOX_ALL & ~(BOX_BACK | BOX_BOTTOM));
    addBox(writer, {x - 0.24f, -0.04f, wall - 0.06f}, {x + 0.24f, 0.30f, wall + 0.16f},
           BOX_ALL & ~(BOX_BACK | BOX_BOTTOM));
    addBeveledBox(writer, {x - 0.25f, SPRINGING - 0.18f, wall - 0.06f}, {x + 0.25f, SPRINGING + 0.04f, wall + 0.20f},
                  0.02f);
}

/// A field of a door: bevelled on four sides, standing out from z = 0.06 to 0.10.
void addRaisedPanel(MeshWriter& writer, vec2 low, vec2 high) {
    const float rise = 0.03f, back = 0.06f, front = 0.10f;
    const vec2 corner[4] = {low, {high.x, low.y}, high, {low.x, high.y}};
    const vec2 inner[4] = {low + rise, {high.x - rise, low.y + rise}, high - rise, {low.x + rise, high.y - rise}};
    auto at = [](vec2 p, float z) { return vec3(p.x, p.y, z); };
    writer.flatQuad(at(inner[0], front), at(inner[1], front), at(inner[2], front), at(inner[3], front), inner[0],
                    inner[1], inner[2], inner[3]);
    for (int i = 0; i < 4; ++i) {
        const int j = (i + 1) % 4;
        writer.flatQuad(at(corner[i], back), at(corner[j], back), at(inner[j], front), at(inner[i], front), corner[i],
                        corner[j], inner[j], inner[i]);
    }
}

/// A round-headed door in the back wall: leaves, panels and a moulded stone surround.
void addDoor(MeshWriter& writer, const Materials& materials, const mat4& side, float x, float floor, float half,
             float height) {
    const mat4 at = side * placed({x, floor, -GALLERY});
    writer.setMaterial(materials.door);
    writer.setTransform(at);
    const float springing = height - half;
    addBox(writer, {-half - 0.03f, -0.03f, -0.03f}, {half + 0.03f, springing, 0.07f}, BOX_FRONT);
    const Polyline line = Arch{half + 0.03f, half + 0.03f}.outline(6);
    const uint32_t middle = writer.vertex({0.0f, springing, 0.07f}, {0, 0, 1}, {0.0f, springing});
    uint32_t previous = 0;
    for (size_t i = 0; i < line.size(); ++i) {
        const vec2 p = line[i] + vec2(0.0f, springing);
        const uint32_t corner = writer.vertex({p.x, p.y, 0.07f}, {0, 0, 1}, p);
        if (i > 0) writer.triangle(middle, corner, previous);
        previous = corner;
    }
    for (float sign : {-1.0f, 1.0f}) {
        for (int row = 0; row < 3; ++row) {
            const float y = 0.15f + float(row) * (springing - 0.25f) / 3.0f, cx = sign * 0.5f * half;
            addRaisedPanel(writer, {cx - 0.36f * half, y}, {cx + 0.36f * half, y + (springing - 0.25f) / 3.0f - 0.1f});
        }
    }
    writer.setMaterial(materials.stone);
    writer.setTransform(at * placed({0.0f, springing, 0.0f}));
    addArchMoulding(writer, {half, half},
                    {{0.0f, -0.02f}, {0.0f, 0.12f}, {0.06f, 0.15f}, {0.17f, 0.15f}, {0.18f, -0.02f}}, 6,
                    springing + 0.02f);
}

void addFloors(MeshWriter& writer, const Materials& materials) {
    writer.setTransform(mat4(1.0f));
    writer.setMaterial(materials.gallery);
    addRectangleSweep(writer, HALF_X, HALF_Z, {{GALLERY + 0.1f, 0.0f}, {0.40f, 0.0f}});
    addRectangleSweep(writer, HALF_X, HALF_Z, {{GALLERY + 0.1f, UPPER_FLOOR}, {0.10f, UPPER_FLOOR}});
    // The stylobate on which the columns stand, and two steps down to the court.
    writer.setMaterial(materials.stone);
    addRectangleSweep(writer, HALF_X, HALF_Z,
                      {{0.40f, 0.0f}, {-0.46f, 0.0f}, {-0.48f, -0.02f}, {-0.48f, -0.16f}, {-0.82f, -0.16f},
                       {-0.84f, -0.18f}, {-0.84f, COURT_FLOOR - 0.05f}});
}

void addBackWalls(MeshWriter& writer, const Materials& materials) {
    writer.setTransform(mat4(1.0f));
    writer.setMaterial(materials.rose);
    addRectangleSweep(writer, HALF_X, HALF_Z, {{GALLERY, UPPER_FLOOR - 0.02f}, {GALLERY, -0.05f}});
    addRectangleSweep(writer, HALF_X, HALF_Z, {{GALLERY, UPPER_TOP}, {GALLERY, UPPER_FLOOR - 0.02f}});
    writer.setMaterial(materials.stone);
    for (float floor : {0.0f, UPPER_FLOOR}) {
        addRectangleSweep(writer, HALF_X, HALF_Z,
                          {{GALLERY + 0.02f, floor + 1.08f}, {GALLERY - 0.05f, floor + 1.05f},
                           {GALLERY - 0.05f, floor + 0.98f}, {GALLERY + 0.02f, floor + 0.95f}});
        addRectangleSweep(
            writer, HALF_X, HALF_Z,
            {{GALLERY + 0.02f, floor + 0.22f}, {GALLERY - 0.04f, floor + 0.18f}, {GALLERY - 0.04f, floor - 0.04f}});
    }
    forEachSide([&](const mat4& side, int bays) {
        for (int i = 0; i < bays; ++i) {
            const float x = (float(i) - 0.5f * float(bays - 1)) * BAY;
            if (i % 2 == 1) addDoor(writer, materials, side, x, 0.0f, 0.70f, 2.75f);
            if (i % 2 == 0) addDoor(writer, materials, side, x, UPPER_FLOOR, 0.55f, 2.35f);
        }
    });
}

/// The upper gallery's timber ceiling.
void addCeiling(MeshWriter& writer, const Materials& materials) {
    const float y = UPPER_TOP - 0.12f;
    writer.setTransform(mat4(1.0f));
    writer.setMaterial(materials.wood);
    addRectangleSweep(writer, HALF_X, HALF_Z, {{-0.05f, y}, {GALLERY + 0.05f, y}});
    forEachSide([&](const mat4& side, int bays) {
        writer.setTransform(side);
        for (int i = 0; i <= bays * 3; ++i) {
            const float x = (float(i) / 3.0f - 0.5f * float(bays)) * BAY;
            addBox(writer, {x - 0.07f, y - 0.20f, -GALLERY - 0.04f}, {x + 0.07f, y + 0.03f, -0.12f},
                   BOX_LEFT | BOX_RIGHT | BOX_BOTTOM);
        }
    });
}

}  // namespace

void addGalleries(MeshWriter& writer, const Materials& materials) {
    addFloors(writer, materials);
    addBackWalls(writer, materials);
    addCeiling(writer, materials);
    forEachSide([&](const mat4& side, int bays) {
        for (int i = 0; i < bays; ++i) {
            writer.setMaterial(materials.brick);
            addVaultBay(writer, side * placed({(float(i) - 0.5f * float(bays - 1)) * BAY, 0.0f, -VAULT_CENTER}));
        }
        for (int i = 0; i <= bays; ++i)
            addTransverseArch(writer, materials, side, (float(i) - 0.5f * float(bays)) * BAY);
    });
    // The four corners: square bays, the same depth both ways.
    const float squeeze = VAULT_HALF_DEPTH / VAULT.halfSpan;
    for (float sx : {-1.0f, 1.0f}) {
        for (float sz : {-1.0f, 1.0f}) {
            writer.setMaterial(materials.brick);
            writer.setTransform(placed({sx * (HALF_X + VAULT_CENTER), SPRINGING, sz * (HALF_Z + VAULT_CENTER)}) *
                                glm::scale(mat4(1.0f), vec3(squeeze, 1.0f, 1.0f)));
            addGroinVault(writer, VAULT, VAULT_HALF_DEPTH, 8);
        }
    }
}

}  // namespace heliograph::generate::courtyard
