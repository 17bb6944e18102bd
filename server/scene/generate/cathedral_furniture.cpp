#include "server/scene/generate/cathedral_parts.h"

#include <array>
#include <cmath>

namespace heliograph::generate::cathedral {

namespace {

void addPew(MeshWriter& writer, const mat4& at) {
    writer.setTransform(at);
    const float half = 1.25f;
    addBox(writer, {-half, 0.42f, -0.22f}, {half, 0.47f, 0.24f});
    addBox(writer, {-half, 0.50f, -0.27f}, {half, 0.92f, -0.23f});
    addBox(writer, {-half, 0.04f, -0.18f}, {half, 0.44f, -0.14f}, BOX_FRONT | BOX_BACK | BOX_BOTTOM);
    for (float side : {-1.0f, 1.0f}) {
        const float x = side * (half + 0.02f);
        addBeveledBox(writer, {x - 0.045f, -0.02f, -0.32f}, {x + 0.045f, 0.98f, -0.16f}, 0.015f);
        addBeveledBox(writer, {x - 0.040f, -0.03f, -0.20f}, {x + 0.040f, 0.62f, 0.27f}, 0.015f);
    }
}

/// A candle with its flame; the foot stands on y = 0.
void addCandle(MeshWriter& writer, const Materials& materials, const mat4& at, float height, float radius) {
    writer.setTransform(at);
    writer.setMaterial(materials.wax);
    addLathe(writer, {{radius, -0.01f}, {radius, height}, {0.6f * radius, height - 0.006f}, {0.0f, height - 0.01f}},
             {.segments = 8, .textureSize = 0.1f});
    writer.setMaterial(materials.flame);
    const float f = height + 0.012f;
    addLathe(writer, {{0.0f, f}, {0.55f * radius, f + 0.02f}, {0.6f * radius, f + 0.04f}, {0.0f, f + 0.11f}},
             {.segments = 6, .creaseDegrees = 80.0f, .textureSize = 0.1f});
}

void addChandelier(MeshWriter& writer, const Materials& materials, vec3 center) {
    constexpr int STEPS = 24;
    std::vector<vec3> curve;
    for (int i = 0; i < STEPS; ++i) {
        const float angle = 6.2831853f * float(i) / float(STEPS);
        curve.push_back(center + vec3(0.95f * std::cos(angle), 0.0f, -0.95f * std::sin(angle)));
    }
    writer.setTransform(mat4(1.0f));
    writer.setMaterial(materials.gold);
    const std::array<float, STEPS> thickness = [] { std::array<float, STEPS> a{}; a.fill(0.045f); return a; }();
    addSweep(writer, framesAlong(curve, thickness, true), circleSection(6),
             {.closedPath = true, .creaseDegrees = 70.0f});
    for (int i = 0; i < 8; ++i) {
        const float angle = 6.2831853f * (float(i) + 0.5f) / 8.0f;
        const vec3 foot = center + vec3(0.95f * std::cos(angle), 0.03f, -0.95f * std::sin(angle));
        writer.setMaterial(materials.gold);
        writer.setTransform(placed(foot));
        addLathe(writer, {{0.015f, 0.0f}, {0.07f, 0.045f}, {0.065f, 0.055f}, {0.0f, 0.05f}},
                 {.segments = 8, .creaseDegrees = 60.0f, .textureSize = 0.1f});
        addCandle(writer, materials, placed(foot + vec3(0.0f, 0.052f, 0.0f)), 0.20f, 0.028f);
    }
    writer.setTransform(mat4(1.0f));
    writer.setMaterial(materials.iron);
    const vec3 knot = center + vec3(0.0f, 1.5f, 0.0f);
    for (int i = 0; i < 4; ++i) {
        const float angle = 6.2831853f * float(i) / 4.0f;
        const vec3 chain[2] = {center + vec3(0.95f * std::cos(angle), 0.0f, -0.95f * std::sin(angle)), knot};
        const float thin[2] = {0.010f, 0.010f};
        addSweep(writer, framesAlong(chain, thin, false), circleSection(4), {.creaseDegrees = 100.0f});
    }
    const vec3 rope[2] = {knot - vec3(0.0f, 0.05f, 0.0f),
                          {center.x, VAULT_SPRINGING + NAVE_VAULT.rise() - 0.15f, center.z}};
    const float thin[2] = {0.014f, 0.014f};
    addSweep(writer, framesAlong(rope, thin, false), circleSection(5), {.creaseDegrees = 100.0f});
}

void addAltar(MeshWriter& writer, const Materials& materials) {
    const float z = -HALF_LENGTH + 2.2f;
    writer.setTransform(mat4(1.0f));
    writer.setMaterial(materials.stone);
    addBeveledBox(writer, {-3.2f, -0.05f, z - 2.8f}, {3.2f, 0.16f, z + 1.9f}, 0.02f);
    addBeveledBox(writer, {-2.7f, 0.05f, z - 2.7f}, {2.7f, 0.32f, z + 1.4f}, 0.02f);
    addBeveledBox(writer, {-2.2f, 0.20f, z - 2.6f}, {2.2f, 0.48f, z + 0.9f}, 0.02f);
    addBeveledBox(writer, {-1.20f, 0.40f, z - 0.40f}, {1.20f, 1.38f, z + 0.40f}, 0.03f);
    addBeveledBox(writer, {-1.32f, 1.32f, z - 0.50f}, {1.32f, 1.46f, z + 0.50f}, 0.03f);
    writer.setMaterial(materials.linen);
    // The cloth lies 4 mm above the slab and hangs clear of its edge.
    addSurface(writer, 10, 16, {1.6f, 2.2f}, [=](float u, float v) {
        const float x = (2.0f * u - 1.0f) * 0.8f, s = v * 2.0f;  // from the front hem over the slab to the back hem
        const float wave = 0.008f * std::sin(17.0f * x);
        if (s < 0.46f) return vec3(x, 1.0f + s, z + 0.515f + wave * (0.46f - s) / 0.46f);
        if (s < 1.54f) return vec3(x, 1.464f + 0.0f * s, z + 0.515f - (s - 0.46f) * (1.03f / 1.08f));
        return vec3(x, 1.464f - (s - 1.54f), z - 0.515f - wave * (s - 1.54f) / 0.46f);
    });
    writer.setMaterial(materials.gold);
    for (float x : {-1.05f, -0.88f, 0.88f, 1.05f}) {
        writer.setMaterial(materials.gold);
        writer.setTransform(placed({x, 1.455f, z - 0.1f}));
        addLathe(writer,
                 {{0.07f, 0.0f}, {0.075f, 0.015f}, {0.02f, 0.05f}, {0.028f, 0.12f}, {0.018f, 0.18f}, {0.018f, 0.30f},
                  {0.05f, 0.34f}, {0.0f, 0.345f}},
                 {.segments = 12, .creaseDegrees = 40.0f, .textureSize = 0.1f});
        addCandle(writer, materials, placed({x, 1.455f + 0.342f, z - 0.1f}), 0.28f, 0.022f);
    }
    writer.setTransform(mat4(1.0f));
    writer.setMaterial(materials.gold);
    addBeveledBox(writer, {-0.16f, 1.467f, z - 0.20f}, {0.16f, 1.52f, z - 0.02f}, 0.012f);
    addBeveledBox(writer, {-0.028f, 1.50f, z - 0.137f}, {0.028f, 2.34f, z - 0.083f}, 0.008f);
    addBeveledBox(writer, {-0.24f, 1.98f, z - 0.133f}, {0.24f, 2.036f, z - 0.087f}, 0.008f);
}

/// A tall candlestick that stands on the floor.
void addStandingCandle(MeshWriter& writer, const Materials& materials, vec3 at) {
    writer.setTransform(placed(at));
    writer.setMaterial(materials.gold);
    addLathe(writer,
             {{0.0f, -0.01f}, {0.24f, -0.01f}, {0.25f, 0.04f}, {0.16f, 0.09f}, {0.05f, 0.18f}, {0.07f, 0.30f},
              {0.035f, 0.42f}, {0.035f, 1.10f}, {0.06f, 1.16f}, {0.03f, 1.22f}, {0.10f, 1.34f}, {0.09f, 1.36f},
              {0.0f, 1.35f}},
             {.segments = 14, .creaseDegrees = 45.0f, .textureSize = 0.25f});
    addCandle(writer, materials, placed(at + vec3(0.0f, 1.35f, 0.0f)), 0.55f, 0.035f);
}

}  // namespace

std::vector<vec3> chandelierCenters() {
    return {{0.0f, 6.2f, 0.5f * BAY * 3.0f}, {0.0f, 6.2f, 0.0f}, {0.0f, 6.2f, -0.5f * BAY * 3.0f}};
}

void addFurniture(MeshWriter& writer, const Materials& materials) {
    writer.setMaterial(materials.oak);
    for (int row = 0; row < 7; ++row) {
        for (float side : {-1.0f, 1.0f})
            addPew(writer, placed({side * 1.95f, 0.0f, 4.2f - 1.15f * float(row)}) * turned(180.0f));
    }
    for (const vec3& center : chandelierCenters()) addChandelier(writer, materials, center);
    addAltar(writer, materials);
    for (float side : {-1.0f, 1.0f}) addStandingCandle(writer, materials, {side * 1.75f, 0.48f, -HALF_LENGTH + 2.6f});
}

}  // namespace heliograph::generate::cathedral
