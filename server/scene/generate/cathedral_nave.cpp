#include "server/scene/generate/cathedral_parts.h"

#include <cmath>
#include <numbers>

namespace heliograph::generate::cathedral {

namespace {

constexpr float PI = std::numbers::pi_v<float>;

/// Outline of a round core with `count` shafts on its rim, counter-clockwise.
Polyline clusterSection(int count, float core, float shaft, int arc) {
    Polyline outline;
    for (int i = 0; i < count; ++i) {
        const float direction = 2.0f * PI * float(i) / float(count);
        const vec2 center = core * vec2(std::cos(direction), std::sin(direction));
        for (int j = 0; j <= arc; ++j) {
            const float angle = direction + (float(j) / float(arc) - 0.5f) * glm::radians(200.0f);
            outline.push_back(center + shaft * vec2(std::cos(angle), std::sin(angle)));
        }
        const float between = direction + PI / float(count);
        outline.push_back(0.97f * core * vec2(std::cos(between), std::sin(between)));
    }
    return outline;
}

const Polyline& pierProfile() {
    static const Polyline profile = {{1.42f, -0.03f}, {1.42f, 0.30f}, {1.22f, 0.40f}, {1.22f, 0.50f}, {1.00f, 0.62f},
                                     {1.00f, SPRINGING - 0.80f}, {1.10f, SPRINGING - 0.75f}, {1.00f, SPRINGING - 0.68f},
                                     {1.07f, SPRINGING - 0.42f}, {1.30f, SPRINGING - 0.20f}};
    return profile;
}

/// Abacus: an octagon over the capital.
void addAbacus(MeshWriter& writer, float radius, float y) {
    addLathe(writer,
             {{0.5f * radius, y - 0.22f}, {radius, y - 0.20f}, {1.06f * radius, y - 0.12f}, {1.06f * radius, y + 0.03f},
              {0.2f * radius, y + 0.035f}},
             {.segments = 8, .creaseDegrees = 10.0f, .startDegrees = 22.5f});
}

void addVaultingShaft(MeshWriter& writer, const Materials& materials) {
    writer.setMaterial(materials.shaft);
    const mat4 at = writer.transform();
    // A bundle of three against the wall; its back half is inside the stone.
    writer.setTransform(at * placed({0.0f, 0.0f, WALL + 0.02f}));
    const Polyline section = clusterSection(6, 0.13f, 0.075f, 2);
    const float top = VAULT_SPRINGING;
    addProfiledPrism(writer, section,
                     {{1.45f, SPRINGING - 0.10f}, {1.45f, SPRINGING + 0.16f}, {1.0f, SPRINGING + 0.28f},
                      {1.0f, top - 0.45f}, {1.45f, top - 0.14f}, {1.60f, top - 0.12f}, {1.60f, top + 0.04f},
                      {0.4f, top + 0.05f}},
                     65.0f);
    writer.setTransform(at);
}

/// Three pointed recesses with colonnettes, above the arcade of one bay.
void addTriforium(MeshWriter& writer, const Materials& materials) {
    constexpr float WIDTH = BAY / 3.0f, SILL = TRIFORIUM + 0.28f, SPRING = TRIFORIUM + 0.98f;
    const Arch arch = {0.56f, 0.80f};
    const mat4 at = writer.transform();
    for (int i = -1; i <= 1; ++i) {
        const float x = float(i) * WIDTH;
        writer.setMaterial(materials.ashlar);
        writer.setTransform(at);
        addArchedPanel(writer, {.x0 = x - 0.5f * WIDTH,
                                .x1 = x + 0.5f * WIDTH,
                                .y0 = TRIFORIUM,
                                .y1 = CLERESTORY,
                                .back = -0.06f,
                                .front = WALL,
                                .arch = arch,
                                .center = x,
                                .springing = SPRING,
                                .sill = SILL,
                                .steps = 5,
                                .backFace = false});
        writer.setMaterial(materials.stone);
        writer.setTransform(at * placed({x, SPRING, 0.0f}));
        addArchMoulding(writer, arch,
                        {{-0.05f, WALL - 0.12f}, {-0.05f, WALL + 0.02f}, {0.02f, WALL + 0.05f}, {0.07f, WALL + 0.03f},
                         {0.08f, WALL - 0.02f}},
                        5);
    }
    writer.setMaterial(materials.recess);
    writer.setTransform(at);
    writer.flatQuad({-0.5f * BAY, TRIFORIUM, -0.05f}, {0.5f * BAY, TRIFORIUM, -0.05f}, {0.5f * BAY, CLERESTORY, -0.05f},
                    {-0.5f * BAY, CLERESTORY, -0.05f});
    writer.setMaterial(materials.shaft);
    for (float x : {-WIDTH, 0.0f, WIDTH}) {
        for (float side : {-1.0f, 1.0f}) {
            writer.setTransform(at * placed({x + side * 0.555f, 0.0f, WALL - 0.03f}));
            addLathe(writer,
                     {{0.085f, SILL - 0.02f}, {0.05f, SILL + 0.10f}, {0.05f, SPRING - 0.16f}, {0.10f, SPRING + 0.03f},
                      {0.02f, SPRING + 0.04f}},
                     {.segments = 6, .creaseDegrees = 40.0f, .textureSize = 0.25f});
        }
    }
}

void addNaveBay(MeshWriter& writer, const Materials& materials) {
    const mat4 at = writer.transform();
    writer.setMaterial(materials.ashlar);
    addArchedPanel(writer, {.x0 = -0.5f * BAY,
                            .x1 = 0.5f * BAY,
                            .y0 = SPRINGING,
                            .y1 = TRIFORIUM,
                            .back = -WALL,
                            .front = WALL,
                            .arch = ARCADE,
                            .springing = SPRINGING,
                            .sill = SPRINGING,
                            .steps = 9});
    writer.flatQuad({0.5f * BAY, TRIFORIUM, -WALL}, {-0.5f * BAY, TRIFORIUM, -WALL}, {-0.5f * BAY, CLERESTORY, -WALL},
                    {0.5f * BAY, CLERESTORY, -WALL});
    addWindowPanel(
        writer, materials, -0.5f * BAY, 0.5f * BAY, CLERESTORY, WALL_TOP, WALL,
        {.arch = {1.05f, 1.45f}, .sill = CLERESTORY + 0.65f, .springing = 11.55f, .glass = materials.grisaille});
    writer.setTransform(at);
    addTriforium(writer, materials);
    writer.setMaterial(materials.stone);
    for (int side = 0; side < 2; ++side) {
        writer.setTransform(at * quarterTurned(2 * side) * placed({0.0f, SPRINGING, 0.0f}));
        addArchMoulding(writer, ARCADE,
                        {{-0.16f, 0.0f}, {-0.16f, 0.13f}, {-0.07f, 0.20f}, {0.02f, 0.30f}, {0.05f, WALL + 0.06f},
                         {0.18f, WALL + 0.04f}, {0.19f, WALL - 0.02f}},
                        8);
    }
    writer.setTransform(at);
}

/// String courses along the whole nave at the given height, as a moulding in front of both walls.
void addString(MeshWriter& writer, float x, float half, float y, float size) {
    for (int side = 0; side < 2; ++side) {
        writer.setTransform(quarterTurned(side == 0 ? 1 : 3) * placed({0.0f, 0.0f, -x}));
        const std::vector<SweepFrame> frames = {{{-HALF_LENGTH - 0.2f, y, half}, {0, 0, 1}, {0, 1, 0}, {0, 0, 1}},
                                                {{HALF_LENGTH + 0.2f, y, half}, {0, 0, 1}, {0, 1, 0}, {0, 0, 1}}};
        // right x up must point forward: z x y = -x, so the path runs the other way.
        const std::vector<SweepFrame> reversed = {frames[1], frames[0]};
        addSweep(writer, reversed,
                 {{-0.03f, -size}, {0.35f * size, -0.8f * size}, {0.6f * size, 0.0f}, {size, 0.1f * size},
                  {size, 0.5f * size}, {-0.03f, size}},
                 {.closedSection = false, .creaseDegrees = 25.0f});
    }
}

void addEndWall(MeshWriter& writer, const Materials& materials, const mat4& at, bool altar) {
    writer.setTransform(at);
    const float edge = NAVE, outer = AISLE + OUTER;
    for (int i = -1; i <= 1; ++i) {
        const float x0 = i < 0 ? -edge : (i == 0 ? -1.30f : 1.30f), x1 = i < 0 ? -1.30f : (i == 0 ? 1.30f : edge);
        const bool middle = i == 0;
        addWindowPanel(writer, materials, x0, x1, 0.0f, WALL_TOP, OUTER,
                       {.arch = middle ? Arch{0.95f, 1.40f} : Arch{0.80f, 1.20f},
                        .sill = altar ? 3.2f : 5.2f,
                        .springing = middle ? 10.6f : 9.4f,
                        .center = 2.35f * float(i),
                        .glass = middle ? materials.ruby : materials.azure});
        writer.setTransform(at);
    }
    for (float side : {-1.0f, 1.0f}) {
        addWindowPanel(writer, materials, side < 0 ? -outer : edge, side < 0 ? -edge : outer, 0.0f, CLERESTORY, OUTER,
                       {.arch = {0.95f, 1.35f},
                        .sill = 1.9f,
                        .springing = 4.4f,
                        .center = side * AISLE_CENTER,
                        .glass = materials.azure});
        writer.setTransform(at);
    }
}

}  // namespace

void forEachBay(float x, const std::function<void(const mat4&)>& part) {
    for (int side = 0; side < 2; ++side) {
        for (int i = 0; i < BAYS; ++i)
            part(quarterTurned(side == 0 ? 1 : 3) * placed({(float(i) - 0.5f * float(BAYS - 1)) * BAY, 0.0f, -x}));
    }
}

void forEachBayLine(float x, const std::function<void(const mat4&)>& part) {
    for (int side = 0; side < 2; ++side) {
        for (int i = 0; i <= BAYS; ++i)
            part(quarterTurned(side == 0 ? 1 : 3) * placed({(float(i) - 0.5f * float(BAYS)) * BAY, 0.0f, -x}));
    }
}

void addPiers(MeshWriter& writer, const Materials& materials) {
    const Polyline cluster = clusterSection(8, 0.40f, 0.125f, 4);
    forEachBayLine(NAVE, [&](const mat4& at) {
        writer.setTransform(at);
        writer.setMaterial(materials.shaft);
        addProfiledPrism(writer, cluster, pierProfile(), 65.0f);
        addAbacus(writer, 0.72f, SPRINGING);
        addVaultingShaft(writer, materials);
    });
    const Polyline respond = clusterSection(6, 0.22f, 0.10f, 2);
    forEachBayLine(AISLE, [&](const mat4& at) {
        writer.setTransform(at * placed({0.0f, 0.0f, OUTER + 0.04f}));
        writer.setMaterial(materials.shaft);
        const Polyline profile = {{1.35f, -0.03f}, {1.35f, 0.32f}, {1.15f, 0.42f}, {1.15f, 0.50f}, {1.00f, 0.60f},
                                  {1.00f, SPRINGING - 0.68f}, {1.05f, SPRINGING - 0.42f}, {1.28f, SPRINGING - 0.20f}};
        addProfiledPrism(writer, respond, profile, 65.0f);
        addAbacus(writer, 0.42f, SPRINGING);
    });
}

void addWalls(MeshWriter& writer, const Materials& materials) {
    forEachBay(NAVE, [&](const mat4& at) {
        writer.setTransform(at);
        addNaveBay(writer, materials);
    });
    int count = 0;
    forEachBay(AISLE, [&](const mat4& at) {
        writer.setTransform(at);
        addWindowPanel(writer, materials, -0.5f * BAY, 0.5f * BAY, 0.0f, CLERESTORY - 0.4f, OUTER,
                       {.arch = {1.05f, 1.45f},
                        .sill = 1.9f,
                        .springing = 4.3f,
                        .glass = count++ % 2 == 0 ? materials.azure : materials.ruby});
    });
    addEndWall(writer, materials, placed({0.0f, 0.0f, -HALF_LENGTH - 0.25f}), true);
    addEndWall(writer, materials, quarterTurned(2) * placed({0.0f, 0.0f, -HALF_LENGTH - 0.25f}), false);
    writer.setMaterial(materials.stone);
    addString(writer, NAVE, WALL, TRIFORIUM + 0.10f, 0.12f);
    addString(writer, NAVE, WALL, CLERESTORY + 0.02f, 0.14f);
    addString(writer, AISLE, OUTER, 1.55f, 0.12f);
    writer.setTransform(mat4(1.0f));
    writer.setMaterial(materials.floor);
    const float x = AISLE, z = HALF_LENGTH + 0.25f;
    writer.flatQuad({-x, 0, z}, {x, 0, z}, {x, 0, -z}, {-x, 0, -z}, {-x, -z}, {x, -z}, {x, z}, {-x, z});
}

void addVaults(MeshWriter& writer, const Materials& materials) {
    const float halfBay = 0.5f * BAY;
    const Polyline rib = {{0.10f, -0.16f}, {-0.05f, -0.16f}, {-0.19f, -0.05f},
                          {-0.19f, 0.05f}, {-0.05f, 0.16f},  {0.10f, 0.16f}};
    for (int i = 0; i <= BAYS; ++i) {
        const float z = (float(i) - 0.5f * float(BAYS)) * BAY, shrink = i == 0 ? 0.12f : (i == BAYS ? -0.12f : 0.0f);
        writer.setMaterial(materials.stone);
        writer.setTransform(placed({0.0f, VAULT_SPRINGING, z + shrink}));
        addArchMoulding(writer, NAVE_VAULT, rib, 10);
        for (float side : {-1.0f, 1.0f}) {
            writer.setTransform(placed({side * AISLE_CENTER, SPRINGING, z + shrink}) * scaled(1.0f));
            addArchMoulding(writer, AISLE_VAULT, rib, 8);
        }
    }
    auto bay = [&](vec3 at, const Arch& arch, uint32_t steps, float boss) {
        writer.setTransform(placed(at));
        writer.setMaterial(materials.web);
        addGroinVault(writer, arch, halfBay, steps + 2);
        writer.setMaterial(materials.stone);
        addDiagonalRibs(writer, arch, halfBay, steps, 0.10f, 0.20f);
        writer.setMaterial(materials.gold);
        writer.setTransform(placed(at + vec3(0.0f, arch.rise() - 0.26f, 0.0f)));
        addLathe(writer,
                 {{0.0f, 0.0f}, {0.5f * boss, 0.02f}, {boss, 0.10f}, {1.05f * boss, 0.18f}, {0.9f * boss, 0.30f}},
                 {.segments = 12, .creaseDegrees = 50.0f});
    };
    for (int i = 0; i < BAYS; ++i) {
        const float z = (float(i) - 0.5f * float(BAYS - 1)) * BAY;
        bay({0.0f, VAULT_SPRINGING, z}, NAVE_VAULT, 10, 0.30f);
        for (float side : {-1.0f, 1.0f}) bay({side * AISLE_CENTER, SPRINGING, z}, AISLE_VAULT, 8, 0.22f);
    }
}

}  // namespace heliograph::generate::cathedral
