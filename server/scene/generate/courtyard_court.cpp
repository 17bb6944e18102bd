#include "server/scene/generate/courtyard_parts.h"

#include "server/scene/generate/noise.h"
#include "server/scene/generate/shapes.h"

#include <algorithm>
#include <cmath>

namespace heliograph::generate::courtyard {

namespace {

/// Barrel tiles: one corrugated sheet per side, cut along the diagonals, and the boards and rafters below its eaves.
void addTiles(MeshWriter& writer, const mat4& side, float halfLength) {
    constexpr float OVERHANG = 0.85f, RIDGE = 3.7f, SLOPE = 0.34f;
    constexpr int STEPS = 4;  // per tile
    writer.setTransform(side);
    const float halfWidth = halfLength + RIDGE - 0.05f;
    const int tiles = int(2.0f * halfWidth / 0.37f);
    const float pitch = 2.0f * halfWidth / float(tiles);
    uint32_t previousLow = 0, previousHigh = 0, previousRim = 0, previousFace = 0;
    for (int i = 0; i <= tiles * STEPS; ++i) {
        const float phase = float(i % STEPS) / float(STEPS);
        const float x = (float(i) / float(STEPS) - 0.5f * float(tiles)) * pitch;
        // Above the middle of a tile the sheet bulges, between two it forms a gutter.
        const float bulge = 0.055f * (0.5f - 0.5f * std::cos(6.2831853f * phase));
        const float lean = 0.055f * 3.14159265f / pitch * std::sin(6.2831853f * phase);
        const float start = std::max(-OVERHANG, std::abs(x) - halfLength);
        auto at = [&](float d, float lift) { return vec3(x, EAVES + SLOPE * (d + OVERHANG) + lift, -d); };
        const vec3 normal(-lean, 1.0f, SLOPE);
        const uint32_t low = writer.vertex(at(start, bulge), normal, {x, start}),
                       high = writer.vertex(at(RIDGE, bulge), normal, {x, RIDGE});
        const uint32_t rim = writer.vertex(at(start, bulge), {0, 0, 1}, {x, 0.06f}),
                       face = writer.vertex(at(start, -0.04f), {0, 0, 1}, {x, 0.0f});
        if (i > 0) {
            writer.quad(previousLow, low, high, previousHigh);
            if (start <= -OVERHANG + 1e-4f) writer.quad(previousFace, face, rim, previousRim);
        }
        previousLow = low, previousHigh = high, previousRim = rim, previousFace = face;
    }
}

void addEaves(MeshWriter& writer, const Materials& materials) {
    writer.setTransform(mat4(1.0f));
    writer.setMaterial(materials.wood);
    addRectangleSweep(writer, HALF_X, HALF_Z, {{-0.83f, EAVES - 0.03f}, {-0.10f, EAVES + 0.04f}});
    writer.setMaterial(materials.brick);
    addRectangleSweep(writer, HALF_X, HALF_Z, {{3.55f, COURT_FLOOR - 0.4f}, {3.55f, EAVES + 1.48f}});
    writer.setMaterial(materials.wood);
    forEachSide([&](const mat4& side, int bays) {
        writer.setTransform(side);
        for (int i = -1; i < bays * 5 + 1; ++i) {
            const float x = ((float(i) + 0.5f) / 5.0f - 0.5f * float(bays)) * BAY;
            if (std::abs(x) > 0.5f * float(bays) * BAY - 0.9f) continue;
            addBox(writer, {x - 0.05f, EAVES - 0.16f, 0.2f}, {x + 0.05f, EAVES + 0.02f, 0.74f},
                   BOX_LEFT | BOX_RIGHT | BOX_BOTTOM | BOX_FRONT);
        }
    });
}

/// Three rings about a common centre and an arrow through it.
void addArmillary(MeshWriter& writer, vec3 center, float radius) {
    auto ring = [&](float r, float thickness, const mat4& turn) {
        std::vector<vec3> curve;
        constexpr int STEPS = 36;
        for (int i = 0; i < STEPS; ++i) {
            const float angle = 6.2831853f * float(i) / float(STEPS);
            curve.push_back(vec3(turn * vec4(r * std::cos(angle), r * std::sin(angle), 0.0f, 1.0f)) + center);
        }
        addSweep(writer, framesAlong(curve, std::vector<float>(STEPS, thickness), true), circleSection(6),
                 {.closedPath = true, .creaseDegrees = 70.0f});
    };
    ring(radius, 0.018f, turned(20.0f));
    ring(0.96f * radius, 0.018f, turned(110.0f));
    ring(0.92f * radius, 0.022f, turned(20.0f) * glm::rotate(mat4(1.0f), glm::radians(67.0f), vec3(1, 0, 0)));
    const vec3 axis = glm::normalize(vec3(0.35f, 0.85f, 0.2f));
    const vec3 curve[2] = {center - axis * (1.25f * radius), center + axis * (1.25f * radius)};
    const float thickness[2] = {0.012f, 0.012f};
    addSweep(writer, framesAlong(curve, thickness, false), circleSection(6), {.caps = true, .creaseDegrees = 70.0f});
    const vec3 tip[2] = {center + axis * (1.2f * radius), center + axis * (1.42f * radius)};
    const float taper[2] = {0.05f, 0.003f};
    addSweep(writer, framesAlong(tip, taper, false), circleSection(8), {.caps = true, .creaseDegrees = 50.0f});
    writer.setTransform(writer.transform() * placed(center));
    addSphere(writer, 0.10f, 16, 8);
}

void addFountain(MeshWriter& writer, const Materials& materials) {
    writer.setTransform(placed({0.0f, COURT_FLOOR, 0.0f}));
    writer.setMaterial(materials.stone);
    addLathe(writer,
             {{2.95f, -0.05f}, {2.95f, 0.13f}, {2.92f, 0.16f}, {2.50f, 0.16f}, {2.50f, 0.29f}, {2.47f, 0.32f},
              {1.20f, 0.32f}},
             {.segments = 8, .creaseDegrees = 20.0f, .startDegrees = 22.5f});
    writer.setMaterial(materials.paleStone);
    addLathe(writer,
             {{1.96f, 0.28f}, {1.98f, 0.40f}, {1.90f, 0.46f}, {1.86f, 0.74f}, {1.92f, 0.80f}, {2.02f, 0.86f},
              {2.02f, 0.92f}, {1.96f, 0.95f}, {1.74f, 0.95f}, {1.70f, 0.92f}, {1.68f, 0.34f}, {0.30f, 0.34f}},
             {.segments = 40});
    addLathe(writer,
             {{0.42f, 0.33f}, {0.42f, 0.60f}, {0.36f, 0.66f}, {0.24f, 0.80f}, {0.17f, 1.05f}, {0.16f, 1.25f},
              {0.22f, 1.36f}, {0.16f, 1.44f}, {0.20f, 1.60f}, {0.46f, 1.72f}, {0.78f, 1.86f}, {0.92f, 1.98f},
              {0.96f, 2.06f}, {0.92f, 2.09f}, {0.86f, 2.07f}, {0.80f, 1.98f}, {0.30f, 1.90f}, {0.14f, 1.92f}},
             {.segments = 32, .creaseDegrees = 50.0f});
    addLathe(writer,
             {{0.20f, 1.88f}, {0.15f, 2.06f}, {0.11f, 2.12f}, {0.09f, 2.32f}, {0.14f, 2.40f}, {0.14f, 2.46f},
              {0.05f, 2.52f}, {0.0f, 2.53f}},
             {.segments = 20, .creaseDegrees = 50.0f});
    writer.setMaterial(materials.water);
    addLathe(writer, {{1.71f, 0.84f}, {0.0f, 0.84f}}, {.segments = 48});
    addLathe(writer, {{0.875f, 2.05f}, {0.0f, 2.05f}}, {.segments = 32});
    writer.setMaterial(materials.bronze);
    addArmillary(writer, {0.0f, 3.10f, 0.0f}, 0.52f);
    writer.setTransform(placed({0.0f, COURT_FLOOR, 0.0f}));
    const vec3 stem[2] = {{0.0f, 2.48f, 0.0f}, {0.0f, 2.60f, 0.0f}};
    const float thickness[2] = {0.035f, 0.03f};
    addSweep(writer, framesAlong(stem, thickness, false), circleSection(8), {.creaseDegrees = 60.0f});
}

/// A clipped orange tree in a terracotta pot.
void addPottedTree(MeshWriter& writer, const Materials& materials, vec3 at, uint64_t seed) {
    Random random(seed);
    const mat4 before = placed(at) * turned(random.between(0.0f, 360.0f));
    writer.setTransform(before);
    writer.setMaterial(materials.terracotta);
    addLathe(writer,
             {{0.0f, 0.0f}, {0.26f, 0.0f}, {0.28f, 0.05f}, {0.38f, 0.50f}, {0.41f, 0.52f}, {0.42f, 0.60f},
              {0.40f, 0.62f}, {0.36f, 0.62f}, {0.35f, 0.50f}},
             {.segments = 18, .creaseDegrees = 40.0f});
    writer.setMaterial(materials.soil);
    addLathe(writer, {{0.37f, 0.55f}, {0.0f, 0.58f}}, {.segments = 18});
    writer.setMaterial(materials.bark);
    const vec3 trunk[4] = {{0, 0.5f, 0}, {0.02f, 0.85f, 0.01f}, {-0.01f, 1.15f, 0.02f}, {0.01f, 1.45f, 0.0f}};
    const float girth[4] = {0.04f, 0.033f, 0.03f, 0.026f};
    addSweep(writer, framesAlong(trunk, girth, false), circleSection(6), {.creaseDegrees = 70.0f});
    writer.setMaterial(materials.leaf);
    const vec3 crown(0.0f, 1.72f, 0.0f);
    writer.setTransform(before * placed(crown));
    addSphere(writer, 0.36f, 10, 7);  // the dark inside
    writer.setTransform(before);
    for (int i = 0; i < 270; ++i) {
        const float z = random.between(-1.0f, 1.0f), angle = random.between(0.0f, 6.2831853f),
                    ring = std::sqrt(1.0f - z * z);
        const vec3 out(ring * std::cos(angle), z, ring * std::sin(angle));
        const vec3 center = crown + out * 0.49f * std::cbrt(random.between(0.40f, 1.0f));
        const vec3 loose = glm::normalize(
            out + vec3(random.between(-0.8f, 0.8f), random.between(-0.3f, 0.9f), random.between(-0.8f, 0.8f)));
        const vec3 along = glm::normalize(
            glm::cross(loose, vec3(random.between(-1, 1), random.between(-1, 1), random.between(-1, 1))));
        const vec3 across = glm::cross(loose, along);
        const float length = random.between(0.06f, 0.09f), width = 0.55f * length;
        // Two triangles folded along the midrib; the normal leans outwards, so that the crown is lit as a ball.
        const uint32_t tip = writer.vertex(center + along * length, out + 0.6f * loose, {0.1f, 0.0f});
        const uint32_t foot = writer.vertex(center - along * length, out + 0.6f * loose, {0.0f, 0.0f});
        const uint32_t left =
            writer.vertex(center + across * width + loose * 0.02f, out + 0.7f * loose - 0.4f * across, {0.05f, 0.05f});
        const uint32_t right =
            writer.vertex(center - across * width + loose * 0.02f, out + 0.7f * loose + 0.4f * across, {0.05f, -0.05f});
        writer.triangle(foot, tip, left);
        writer.triangle(tip, foot, right);
    }
}

void addBench(MeshWriter& writer, const Materials& materials, const mat4& at) {
    writer.setTransform(at);
    writer.setMaterial(materials.stone);
    addBeveledBox(writer, {-0.85f, 0.40f, -0.24f}, {0.85f, 0.50f, 0.24f}, 0.02f);
    for (float x : {-0.6f, 0.6f}) addBeveledBox(writer, {x - 0.09f, -0.04f, -0.18f}, {x + 0.09f, 0.42f, 0.18f}, 0.02f);
}

/// Cloth hung over the balustrade of one bay, clear of the rail and of the string course.
void addBanner(MeshWriter& writer, const mat4& bay, uint64_t seed) {
    Random random(seed);
    const float phase = random.between(0.0f, 6.28f), half = 0.62f;
    const float front = 0.235f, top = UPPER_FLOOR + 1.005f;
    writer.setTransform(bay);
    // Over the rail from the gallery's side, then down the front; the folds grow towards the free hem.
    addSurface(writer, 12, 16, {2.0f * half, 3.1f}, [=](float u, float v) {
        const float x = (2.0f * u - 1.0f) * half, s = (1.0f - v) * 3.1f;  // s: metres from the gallery's hem, v = 1
        float y, z;
        const float back = 0.45f, over = back + 2.0f * front;
        if (s < back) y = top - (back - s), z = -front;
        else if (s < over)
            y = top + 0.05f * std::sin(3.14159265f * (s - back) / (over - back)), z = -front + (s - back);
        else y = top - (s - over), z = front;
        const float hang = std::clamp((s - over) / 2.0f, 0.0f, 1.0f);
        // The string course stands out by half a metre: the cloth lies over it.
        const float push = 0.33f * std::clamp((top - y - 0.35f) / 0.5f, 0.0f, 1.0f) * (s >= over ? 1.0f : 0.0f);
        z += push +
             hang * (0.06f * std::sin(11.0f * x + phase) + 0.03f * std::sin(23.0f * x + 2.0f * phase + 1.5f * hang));
        y += (s >= over ? 0.06f * (1.0f - hang) * hang * std::cos(4.0f * x) : 0.0f);
        return vec3(x, y, z);
    });
}

}  // namespace

void addRoof(MeshWriter& writer, const Materials& materials) {
    addEaves(writer, materials);
    writer.setMaterial(materials.roof);
    forEachSide([&](const mat4& side, int bays) { addTiles(writer, side, 0.5f * float(bays) * BAY); });
}

void addCourt(MeshWriter& writer, const Materials& materials) {
    writer.setTransform(mat4(1.0f));
    writer.setMaterial(materials.pavers);
    const float x = HALF_X - 0.6f, z = HALF_Z - 0.6f, g = COURT_FLOOR;
    writer.flatQuad({-x, g, z}, {x, g, z}, {x, g, -z}, {-x, g, -z}, {-x, -z}, {x, -z}, {x, z}, {-x, z});
    addFountain(writer, materials);
    uint64_t seed = 11;
    for (float sx : {-1.0f, 1.0f}) {
        for (float sz : {-1.0f, 1.0f}) {
            addPottedTree(writer, materials, {sx * 4.5f, g - 0.01f, sz * 6.05f}, seed++);
            addBench(writer, materials, placed({sx * 6.0f, g, sz * 6.15f}));
        }
    }
    forEachSide([&](const mat4& side, int bays) {
        for (int i = 1; i < bays - 1; ++i) {
            if (bays == BAYS_X ? i != 1 && i != 5 : i != 2) continue;
            writer.setMaterial(bays == BAYS_X ? materials.crimson : materials.indigo);
            addBanner(writer, side * placed({(float(i) - 0.5f * float(bays - 1)) * BAY, 0.0f, 0.0f}), seed++);
        }
    });
}

}  // namespace heliograph::generate::courtyard
