#include "server/scene/generate/courtyard_parts.h"

#include "server/scene/generate/arches.h"

#include <cmath>

namespace heliograph::generate::courtyard {

namespace {

constexpr float LOWER_ARCH = 1.20f, UPPER_ARCH = 1.25f;  // radii

/// A leaf of the capital: a tapering strip that climbs the bell and bends over at the tip.
void addLeaf(MeshWriter& writer, float degrees, float bottom, float top, float inner, float outer) {
    const float angle = glm::radians(degrees);
    const vec3 out(std::cos(angle), 0.0f, -std::sin(angle)), side(std::sin(angle), 0.0f, std::cos(angle));
    const float height = top - bottom;
    const vec2 spine[3] = {{inner - 0.03f, bottom}, {inner + 0.02f, bottom + 0.60f * height}, {outer + 0.01f, top}};
    const float width[3] = {0.055f, 0.068f, 0.035f};
    std::vector<SweepFrame> frames;
    for (int i = 0; i < 3; ++i) {
        const vec2 along = glm::normalize(spine[std::min(i + 1, 2)] - spine[std::max(i - 1, 0)]);
        const vec3 forward = out * along.x + vec3(0.0f, along.y, 0.0f);
        // The section's x axis is the leaf's width, its y axis the thickness.
        const vec3 up = glm::cross(forward, side);
        frames.push_back(
            {out * spine[i].x + vec3(0.0f, spine[i].y, 0.0f), side * width[i], up * (0.25f + 0.5f * width[i]), side});
    }
    const Polyline section = {{1.0f, 0.0f}, {0.0f, 0.06f}, {-1.0f, 0.0f}, {0.0f, -0.06f}};
    addSweep(writer, frames, section, {.creaseDegrees = 60.0f});
}

void addLowerColumn(MeshWriter& writer) {
    addBox(writer, {-0.31f, -0.03f, -0.31f}, {0.31f, 0.13f, 0.31f}, BOX_ALL & ~BOX_BOTTOM);
    const Polyline profile = {{0.295f, 0.12f},  {0.310f, 0.165f}, {0.290f, 0.210f}, {0.248f, 0.245f}, {0.268f, 0.290f},
                              {0.250f, 0.325f}, {0.212f, 0.36f},  {0.206f, 1.30f},  {0.180f, 2.52f},  {0.205f, 2.545f},
                              {0.205f, 2.585f}, {0.172f, 2.61f},  {0.188f, 2.80f},  {0.240f, 2.95f}};
    addLathe(writer, profile, {.segments = 16, .creaseDegrees = 42.0f, .startDegrees = 45.0f});
    for (int i = 0; i < 8; ++i) {
        const bool corner = i % 2 == 1;
        addLeaf(writer, 45.0f * float(i), 2.59f, corner ? 2.93f : 2.83f, 0.19f, corner ? 0.345f : 0.265f);
    }
    addBeveledBox(writer, {-0.35f, 2.93f, -0.35f}, {0.35f, SPRINGING + 0.03f, 0.35f}, 0.02f);
}

void addUpperColumn(MeshWriter& writer) {
    const float b = PEDESTAL, top = UPPER_SPRINGING;
    addBox(writer, {-0.26f, UPPER_FLOOR - 0.05f, -0.26f}, {0.26f, b, 0.26f}, BOX_ALL & ~BOX_BOTTOM);
    addBeveledBox(writer, {-0.29f, b - 0.09f, -0.29f}, {0.29f, b - 0.02f, 0.29f}, 0.012f);
    const Polyline profile = {{0.205f, b - 0.01f},   {0.210f, b + 0.05f},    {0.178f, b + 0.10f},
                              {0.146f, b + 0.14f},   {0.140f, b + 0.75f},    {0.124f, top - 0.37f},
                              {0.142f, top - 0.35f}, {0.142f, top - 0.325f}, {0.120f, top - 0.30f},
                              {0.150f, top - 0.20f}, {0.220f, top - 0.14f}};
    addLathe(writer, profile, {.segments = 12, .creaseDegrees = 42.0f, .startDegrees = 45.0f});
    addBeveledBox(writer, {-0.28f, top - 0.15f, -0.28f}, {0.28f, top + 0.03f, 0.28f}, 0.02f);
}

/// A glazed medallion in the spandrel above a column.
void addMedallion(MeshWriter& writer, const Materials& materials) {
    const mat4 before = writer.transform();
    // The lathe's axis turned from +Y to +Z.
    writer.setTransform(before * placed({0.0f, 4.16f, WALL}) *
                        glm::rotate(mat4(1.0f), glm::radians(90.0f), vec3(1, 0, 0)));
    writer.setMaterial(materials.paleStone);
    addLathe(writer, {{0.27f, -0.02f}, {0.265f, 0.03f}, {0.235f, 0.05f}, {0.20f, -0.02f}},
             {.segments = 16, .creaseDegrees = 50.0f});
    writer.setMaterial(materials.glaze);
    addLathe(writer, {{0.23f, 0.008f}, {0.14f, 0.022f}, {0.0f, 0.03f}}, {.segments = 16, .creaseDegrees = 60.0f});
    writer.setTransform(before);
}

void addArcadeWall(MeshWriter& writer, const Materials& materials, const mat4& toWorld, int bays) {
    // Moulded band around an arch: soffit edge, two steps, outer edge; its ends are buried in the wall.
    const Polyline band = {{-0.012f, WALL - 0.10f}, {-0.012f, WALL + 0.035f}, {0.10f, WALL + 0.04f},
                           {0.19f, WALL + 0.065f}, {0.21f, WALL - 0.02f}};
    const Polyline upperBand = {
        {-0.012f, WALL - 0.08f}, {-0.012f, WALL + 0.03f}, {0.13f, WALL + 0.045f}, {0.15f, WALL - 0.02f}};
    for (int i = 0; i < bays; ++i) {
        const float x = (float(i) - 0.5f * float(bays - 1)) * BAY;
        const mat4 bay = toWorld * placed({x, 0.0f, 0.0f});
        writer.setMaterial(materials.plaster);
        writer.setTransform(bay);
        ArchedPanel panel{.x0 = -0.5f * BAY,
                          .x1 = 0.5f * BAY,
                          .y0 = SPRINGING,
                          .y1 = UPPER_FLOOR - 0.1f,
                          .back = -WALL,
                          .front = WALL,
                          .arch = {LOWER_ARCH, LOWER_ARCH},
                          .springing = SPRINGING,
                          .sill = SPRINGING,
                          .steps = 8};
        addArchedPanel(writer, panel);
        panel.y0 = panel.springing = panel.sill = UPPER_SPRINGING;
        panel.y1 = UPPER_TOP, panel.arch = {UPPER_ARCH, UPPER_ARCH}, panel.steps = 7;
        addArchedPanel(writer, panel);
        writer.setMaterial(materials.stone);
        writer.setTransform(bay * placed({0.0f, SPRINGING, 0.0f}));
        addArchMoulding(writer, {LOWER_ARCH, LOWER_ARCH}, band, 8);
        writer.setTransform(bay * placed({0.0f, UPPER_SPRINGING, 0.0f}));
        addArchMoulding(writer, {UPPER_ARCH, UPPER_ARCH}, upperBand, 7);
        // Keystone.
        writer.setTransform(bay);
        addBeveledBox(writer, {-0.09f, SPRINGING + LOWER_ARCH - 0.05f, WALL - 0.2f},
                      {0.09f, SPRINGING + LOWER_ARCH + 0.34f, WALL + 0.10f}, 0.02f);
    }
}

void addBalusters(MeshWriter& writer, int bays) {
    const float y = UPPER_FLOOR + 0.12f, top = UPPER_FLOOR + 0.86f;
    const Polyline profile = {
        {0.062f, y}, {0.036f, y + 0.10f}, {0.084f, y + 0.27f}, {0.038f, y + 0.56f}, {0.064f, top}};
    const mat4 side = writer.transform();
    constexpr int COUNT = 6;
    for (int i = 0; i < bays; ++i) {
        for (int j = 0; j < COUNT; ++j) {
            const float x =
                (float(i) - 0.5f * float(bays)) * BAY + BAY * (0.5f + (float(j) - 0.5f * float(COUNT - 1)) * 0.138f);
            writer.setTransform(side * placed({x, 0.0f, 0.0f}));
            addLathe(writer, profile, {.segments = 6, .creaseDegrees = 80.0f, .textureSize = 0.25f});
        }
    }
    writer.setTransform(side);
}

void addCornerPiers(MeshWriter& writer, const Materials& materials) {
    writer.setTransform(mat4(1.0f));
    for (float sx : {-1.0f, 1.0f}) {
        for (float sz : {-1.0f, 1.0f}) {
            auto pier = [&](float half, float y0, float y1, float bevel) {
                const vec3 c(sx * HALF_X, 0.0f, sz * HALF_Z);
                addBeveledBox(writer, c + vec3(-half, y0, -half), c + vec3(half, y1, half), bevel);
            };
            writer.setMaterial(materials.stone);
            pier(0.42f, -0.04f, 0.30f, 0.02f);
            pier(0.34f, 0.20f, SPRINGING - 0.10f, 0.02f);
            pier(0.42f, SPRINGING - 0.16f, SPRINGING + 0.03f, 0.03f);
            pier(0.36f, SPRINGING - 0.05f, UPPER_FLOOR - 0.06f, 0.02f);
            pier(0.40f, UPPER_FLOOR - 0.12f, UPPER_FLOOR + 0.24f, 0.02f);
            pier(0.31f, UPPER_FLOOR + 0.15f, UPPER_SPRINGING - 0.10f, 0.02f);
            pier(0.38f, UPPER_SPRINGING - 0.14f, UPPER_SPRINGING + 0.02f, 0.03f);
            pier(0.33f, UPPER_SPRINGING - 0.05f, UPPER_TOP + 0.05f, 0.02f);
        }
    }
}

/// String course, parapet and cornice run around the whole court.
void addCourses(MeshWriter& writer, const Materials& materials) {
    writer.setTransform(mat4(1.0f));
    writer.setMaterial(materials.stone);
    const float f = UPPER_FLOOR;
    addRectangleSweep(writer, HALF_X, HALF_Z,
                      {{-0.10f, f + 0.09f}, {-0.46f, f + 0.06f}, {-0.48f, f + 0.03f}, {-0.48f, f - 0.04f},
                       {-0.43f, f - 0.09f}, {-0.36f, f - 0.14f}, {-0.33f, f - 0.22f}, {-0.28f, f - 0.24f},
                       {-0.28f, f - 0.32f}, {-0.18f, f - 0.34f}});
    addRectangleSweep(writer, HALF_X, HALF_Z,
                      {{0.17f, f - 0.05f}, {0.17f, f + 0.13f}, {-0.17f, f + 0.13f}, {-0.17f, f - 0.05f}});
    const float rail = f + 0.84f;
    addRectangleSweep(writer, HALF_X, HALF_Z,
                      {{0.13f, rail}, {0.17f, rail + 0.04f}, {0.17f, rail + 0.09f}, {0.13f, rail + 0.13f},
                       {-0.13f, rail + 0.13f}, {-0.17f, rail + 0.09f}, {-0.17f, rail + 0.04f}, {-0.13f, rail},
                       {0.13f, rail}});
    const float t = UPPER_TOP;
    addRectangleSweep(writer, HALF_X, HALF_Z,
                      {{-0.10f, t + 0.22f}, {-0.52f, t + 0.20f}, {-0.54f, t + 0.10f}, {-0.46f, t + 0.04f},
                       {-0.40f, t - 0.02f}, {-0.38f, t - 0.10f}, {-0.30f, t - 0.12f}, {-0.30f, t - 0.24f},
                       {-0.18f, t - 0.26f}});
}

}  // namespace

void forEachSide(const std::function<void(const mat4&, int)>& part) {
    for (int side = 0; side < 4; ++side) {
        const bool longSide = side % 2 == 0;
        part(quarterTurned(side) * placed({0.0f, 0.0f, longSide ? -HALF_Z : -HALF_X}), longSide ? BAYS_X : BAYS_Z);
    }
}

void addArcades(MeshWriter& writer, const Materials& materials) {
    forEachSide([&](const mat4& toWorld, int bays) {
        addArcadeWall(writer, materials, toWorld, bays);
        for (int i = 1; i < bays; ++i) {
            writer.setTransform(toWorld * placed({(float(i) - 0.5f * float(bays)) * BAY, 0.0f, 0.0f}));
            writer.setMaterial(materials.paleStone);
            addLowerColumn(writer);
            addUpperColumn(writer);
            addMedallion(writer, materials);
        }
        writer.setTransform(toWorld);
        writer.setMaterial(materials.paleStone);
        addBalusters(writer, bays);
    });
    addCornerPiers(writer, materials);
    addCourses(writer, materials);
}

}  // namespace heliograph::generate::courtyard
