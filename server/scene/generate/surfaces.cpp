#include "server/scene/generate/surfaces.h"

#include "server/scene/generate/noise.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace heliograph::generate {

namespace {

uint8_t byteOf(float x) { return uint8_t(std::clamp(x, 0.0f, 1.0f) * 255.0f + 0.5f); }

/// A rectangular stone of a bond: its cell and the distance to its nearest joint, in units of u.
struct Stone {
    int column, row;
    vec2 inside;       // position in the stone, [0, 1)^2
    float joint;       // distance to the edge
};

Stone stoneAt(vec2 uv, int columns, int rows, float shift) {
    const float y = uv.y * float(rows);
    const int row = int(std::floor(y));
    const float x = uv.x * float(columns) + (row & 1 ? shift : 0.0f);
    const int column = int(std::floor(x));
    const vec2 inside(fraction(x), fraction(y));
    const vec2 edge = glm::min(inside, 1.0f - inside) / vec2(float(columns), float(rows));
    return {column % columns, row, inside, std::min(edge.x, edge.y)};
}

}  // namespace

SurfaceImages paintSurface(const std::string& name, uint32_t size, float metres,
                           const std::function<SurfacePoint(vec2)>& paint) {
    SurfaceImages result;
    result.metres = metres;
    std::vector<float> heights(size_t(size) * size);
    std::vector<uint8_t> color(size_t(size) * size * 4);
    tbb::parallel_for(tbb::blocked_range<uint32_t>(0, size, 16), [&](const tbb::blocked_range<uint32_t>& rows) {
        for (uint32_t y = rows.begin(); y < rows.end(); ++y) {
            for (uint32_t x = 0; x < size; ++x) {
                const SurfacePoint p = paint((vec2(float(x), float(y)) + 0.5f) / float(size));
                const size_t i = size_t(y) * size + x;
                heights[i] = p.height;
                for (int c = 0; c < 3; ++c) color[i * 4 + size_t(c)] = byteOf(p.color[c]);
                color[i * 4 + 3] = 255;
            }
        }
    });
    // Normals at half the resolution: a quarter of the memory, and finer ones would only glitter.
    const uint32_t half = size / 2;
    std::vector<uint8_t> normal(size_t(half) * half * 4);
    const float slopeScale = float(size) / (3.0f * metres);
    for (uint32_t y = 0; y < half; ++y) {
        for (uint32_t x = 0; x < half; ++x) {
            // Sums over the texel's two rows or columns; the outer differences reach three pixels.
            auto at = [&](uint32_t u, uint32_t v) { return heights[size_t(v % size) * size + u % size]; };
            const uint32_t u = 2 * x, v = 2 * y;
            const float du =
                0.5f * (at(u + 2, v) + at(u + 2, v + 1) - at(u + size - 1, v) - at(u + size - 1, v + 1)) * slopeScale;
            const float dv =
                0.5f * (at(u, v + 2) + at(u + 1, v + 2) - at(u, v + size - 1) - at(u + 1, v + size - 1)) * slopeScale;
            const vec3 n = glm::normalize(vec3(-du, dv, 1.0f));  // green points against growing v, as glTF has it
            const size_t i = (size_t(y) * half + x) * 4;
            for (int c = 0; c < 3; ++c) normal[i + size_t(c)] = byteOf(0.5f + 0.5f * n[c]);
            normal[i + 3] = 255;
        }
    }
    result.color = {.width = size, .height = size, .srgb = true, .rgba8 = std::move(color), .name = name};
    result.normal = {
        .width = half, .height = half, .srgb = false, .rgba8 = std::move(normal), .name = name + " normal"};
    return result;
}

SurfaceImages paintLimestone(const std::string& name, vec3 color, uint32_t seed) {
    return paintSurface(name, 512, 1.0f, [=](vec2 uv) {
        const float broad = fractalNoise(uv * 4.0f, 4, 5, seed), grain = fractalNoise(uv * 64.0f, 64, 2, seed + 7);
        const float bed = fractalNoise(vec2(uv.x * 3.0f, uv.y * 12.0f), 12, 3, seed + 13);  // faint horizontal bedding
        const float pit = stepBetween(0.72f, 0.84f, fractalNoise(uv * 40.0f, 40, 2, seed + 19));
        const float tone = 0.88f + 0.16f * broad + 0.06f * (bed - 0.5f) + 0.07f * (grain - 0.5f) - 0.06f * pit;
        return SurfacePoint{color * tone, 0.0012f * broad + 0.0006f * grain - 0.0010f * pit};
    });
}

SurfaceImages paintAshlar(const std::string& name, vec3 color, uint32_t seed) {
    return paintSurface(name, 1024, 3.2f, [=](vec2 uv) {
        const Stone stone = stoneAt(uv, 4, 8, 0.5f);
        const float tint = hash01(stone.column, stone.row, seed), warm = hash01(stone.column, stone.row, seed + 1);
        const float broad = fractalNoise(uv * 8.0f, 8, 5, seed + 2),
                    grain = fractalNoise(uv * 128.0f, 128, 2, seed + 3);
        const float joint = stepBetween(0.0016f, 0.0034f, stone.joint + 0.0006f * (grain - 0.5f));
        const float bevel = stepBetween(0.0016f, 0.0060f, stone.joint);
        vec3 stoneColor = color * (0.84f + 0.12f * tint + 0.14f * (broad - 0.3f) + 0.05f * (grain - 0.5f));
        stoneColor *= glm::mix(vec3(1.02f, 1.0f, 0.96f), vec3(0.97f, 0.99f, 1.02f), warm);
        const vec3 mortar = color * (0.66f + 0.1f * grain);
        return SurfacePoint{glm::mix(mortar, stoneColor, joint),
                            0.007f * bevel + 0.003f * broad + 0.0012f * grain + 0.003f * tint};
    });
}

SurfaceImages paintBrick(const std::string& name, uint32_t seed) {
    return paintSurface(name, 512, 1.04f, [=](vec2 uv) {
        const Stone brick = stoneAt(uv, 4, 14, 0.5f);
        const float tint = hash01(brick.column, brick.row, seed), burnt = hash01(brick.column, brick.row, seed + 1);
        const float broad = fractalNoise(uv * 6.0f, 6, 4, seed + 2), grain = fractalNoise(uv * 96.0f, 96, 2, seed + 3);
        const float face = stepBetween(0.0030f, 0.0068f, brick.joint + 0.002f * (grain - 0.5f));
        vec3 color = glm::mix(vec3(0.62f, 0.37f, 0.26f), vec3(0.74f, 0.50f, 0.36f), tint);
        if (burnt > 0.85f) color *= 0.82f;
        color *= 0.86f + 0.22f * broad + 0.14f * (grain - 0.5f);
        const vec3 mortar = vec3(0.74f, 0.69f, 0.60f) * (0.86f + 0.2f * grain);
        return SurfacePoint{glm::mix(mortar, color, face), 0.006f * face + 0.0016f * grain + 0.0015f * tint};
    });
}

SurfaceImages paintPlaster(const std::string& name, vec3 color, uint32_t seed) {
    return paintSurface(name, 512, 3.0f, [=](vec2 uv) {
        const float broad = fractalNoise(uv * 3.0f, 3, 5, seed), trowel = fractalNoise(uv * 14.0f, 14, 4, seed + 5);
        const float grain = valueNoise(uv * 256.0f, 256, seed + 9);
        const float faded = stepBetween(0.30f, 0.75f, fractalNoise(uv * 5.0f, 5, 4, seed + 17));
        const vec3 pale = glm::mix(color, vec3(0.88f, 0.82f, 0.72f), 0.16f);
        const vec3 tone = glm::mix(color, pale, faded) * (0.90f + 0.18f * (broad - 0.4f) + 0.04f * (grain - 0.5f));
        return SurfacePoint{tone, 0.006f * trowel + 0.0015f * grain};
    });
}

SurfaceImages paintPavers(const std::string& name, uint32_t seed) {
    return paintSurface(name, 1024, 3.0f, [=](vec2 uv) {
        const Stone slab = stoneAt(uv, 4, 4, 0.0f);
        const vec2 corner = glm::min(slab.inside, 1.0f - slab.inside);  // distance to the slab's corner, slabs
        const float inset = corner.x + corner.y - 0.22f;                // < 0 inside the small diamond
        const float joint = std::min(slab.joint * 4.0f, std::abs(inset) * 0.7f);
        const bool diamond = inset < 0.0f;
        const int kind = diamond ? 99 : 0;
        const float tint = hash01(slab.column + kind, slab.row, seed);
        const float broad = fractalNoise(uv * 8.0f, 8, 5, seed + 2), grain = fractalNoise(uv * 96.0f, 96, 2, seed + 3);
        const vec3 base =
            diamond ? vec3(0.55f, 0.36f, 0.28f) : glm::mix(vec3(0.71f, 0.62f, 0.50f), vec3(0.79f, 0.71f, 0.58f), tint);
        const vec3 color = base * (0.85f + 0.24f * broad + 0.06f * (grain - 0.5f));
        const float inside = diamond && slab.joint * 4.0f < std::abs(inset) * 0.7f ? std::abs(inset) * 0.7f
                                                                                   : joint;  // no joint across an inset
        const float face = stepBetween(0.006f, 0.016f, inside);
        return SurfacePoint{glm::mix(vec3(0.50f, 0.45f, 0.38f), color, face),
                            0.005f * face + 0.003f * broad + 0.001f * grain};
    });
}

SurfaceImages paintTerracottaFloor(const std::string& name, uint32_t seed) {
    return paintSurface(name, 512, 1.2f, [=](vec2 uv) {
        // Squares turned by 45 degrees: columns of u + v and u - v.
        const float a = (uv.x + uv.y) * 4.0f, b = (uv.x - uv.y) * 4.0f + 8.0f;
        const int column = int(std::floor(a)) % 8, row = int(std::floor(b)) % 8;
        const vec2 inside(fraction(a), fraction(b));
        const vec2 edge = glm::min(inside, 1.0f - inside);
        // (a, b) repeats after (4, 4) and (4, -4): fold the cell into one name.
        const int name0 = (column + row) % 8, name1 = (column - row + 16) % 8;
        const float tint = hash01(name0, name1, seed);
        const float broad = fractalNoise(uv * 4.0f, 4, 5, seed + 2), grain = fractalNoise(uv * 64.0f, 64, 2, seed + 3);
        const float face = stepBetween(0.012f, 0.035f, std::min(edge.x, edge.y));
        const vec3 color = glm::mix(vec3(0.60f, 0.38f, 0.27f), vec3(0.72f, 0.49f, 0.35f), tint) *
                           (0.84f + 0.26f * broad + 0.08f * (grain - 0.5f));
        return SurfacePoint{glm::mix(vec3(0.56f, 0.49f, 0.41f), color, face), 0.004f * face + 0.002f * broad};
    });
}

SurfaceImages paintTerracotta(const std::string& name, uint32_t seed) {
    return paintSurface(name, 512, 1.6f, [=](vec2 uv) {
        const Stone tile = stoneAt(uv, 8, 4, 0.0f);
        const float tint = hash01(tile.column, tile.row, seed);
        const float broad = fractalNoise(uv * 6.0f, 6, 5, seed + 2), grain = fractalNoise(uv * 64.0f, 64, 2, seed + 3);
        const float lichen = stepBetween(0.60f, 0.72f, fractalNoise(uv * 12.0f, 12, 4, seed + 4));
        vec3 color = glm::mix(vec3(0.60f, 0.34f, 0.23f), vec3(0.76f, 0.49f, 0.34f), tint) *
                     (0.82f + 0.30f * broad + 0.08f * (grain - 0.5f));
        color = glm::mix(color, vec3(0.58f, 0.54f, 0.42f), 0.45f * lichen);
        const float edge = stepBetween(0.0f, 0.10f, tile.inside.y);  // the lower rim of each row stands proud
        return SurfacePoint{color * (0.75f + 0.25f * edge), 0.012f * (1.0f - tile.inside.y) * edge + 0.002f * broad};
    });
}

SurfaceImages paintWood(const std::string& name, vec3 color, uint32_t seed) {
    return paintSurface(name, 512, 1.2f, [=](vec2 uv) {
        const float y = uv.y * 6.0f;
        const int board = int(std::floor(y));
        const float edge = std::min(fraction(y), 1.0f - fraction(y));
        const float shift = hash01(board, 3, seed), tint = hash01(board, 5, seed);
        const vec2 p(uv.x * 2.0f + shift * 2.0f, uv.y * 24.0f);
        const float wave = fractalNoise(p, 24, 3, seed + 2);
        const float rings = 0.5f + 0.5f * std::sin(6.2831853f * (wave * 7.0f + uv.y * 12.0f));
        const float fibre = fractalNoise(vec2(uv.x * 8.0f, uv.y * 128.0f), 128, 2, seed + 4);
        const float face = stepBetween(0.01f, 0.05f, edge);
        const vec3 tone = color * (0.70f + 0.16f * rings + 0.22f * fibre + 0.16f * (tint - 0.5f));
        return SurfacePoint{tone * (0.45f + 0.55f * face), 0.003f * face + 0.0007f * fibre + 0.0003f * rings};
    });
}

SurfaceImages paintMarbleChequer(const std::string& name, vec3 light, vec3 dark, uint32_t seed) {
    return paintSurface(name, 1024, 4.0f, [=](vec2 uv) {
        const Stone square = stoneAt(uv, 4, 4, 0.0f);
        const bool white = (square.column + square.row) % 2 == 0;
        const float turn = hash01(square.column, square.row, seed);
        const vec2 warp = vec2(fractalNoise(uv * 6.0f, 6, 2, seed + 1), fractalNoise(uv * 6.0f, 6, 3, seed + 2)) - 0.5f;
        const vec2 along = turn < 0.5f ? vec2(uv.x, uv.y) : vec2(-uv.y, uv.x);
        const float wave = (along.x + along.y) * 8.0f + turn * 5.0f + 5.0f * warp.x;
        const float vein = 1.0f - std::abs(2.0f * fraction(wave) - 1.0f);
        const float fine = 1.0f - std::abs(2.0f * fraction(wave * 2.0f + 4.0f * warp.y) - 1.0f);
        const float lines = 0.7f * stepBetween(0.86f, 1.0f, vein) + 0.35f * stepBetween(0.80f, 1.0f, fine);
        const float cloud = fractalNoise(uv * 10.0f, 10, 4, seed + 3);
        const vec3 color = white ? light * (0.90f + 0.12f * cloud - 0.16f * lines)
                                 : dark * (0.80f + 0.4f * cloud) + vec3(0.20f) * lines * lines;
        const float face = stepBetween(0.0008f, 0.0020f, square.joint);
        return SurfacePoint{glm::mix(vec3(0.22f, 0.20f, 0.18f), color, face), 0.0f};
    });
}

SurfaceImages paintCloth(const std::string& name, vec3 color, vec3 pattern, uint32_t seed) {
    return paintSurface(name, 256, 0.8f, [=](vec2 uv) {
        const vec2 cell(fraction(uv.x * 4.0f) - 0.5f, fraction(uv.y * 4.0f) - 0.5f);
        const float diamond = std::abs(cell.x) + std::abs(cell.y);
        const float lattice = 1.0f - stepBetween(0.018f, 0.04f, std::abs(diamond - 0.5f));
        const float radius = glm::length(cell), angle = std::atan2(cell.y, cell.x);
        const float flower = 1.0f - stepBetween(0.0f, 0.03f, radius - 0.13f * (0.75f + 0.25f * std::cos(4.0f * angle)));
        const float thread = 0.5f + 0.5f * std::sin(uv.x * 6.2831853f * 100.0f) * std::sin(uv.y * 6.2831853f * 100.0f);
        const float worn = fractalNoise(uv * 5.0f, 5, 4, seed);
        const vec3 tone = glm::mix(color, pattern, std::max(lattice, flower));
        return SurfacePoint{tone * (0.80f + 0.12f * thread + 0.16f * worn),
                            0.0006f * thread + 0.0008f * std::max(lattice, flower)};
    });
}

SurfaceImages paintRipples(const std::string& name, uint32_t seed) {
    return paintSurface(name, 256, 0.9f, [=](vec2 uv) {
        return SurfacePoint{vec3(0.5f), 0.009f * fractalNoise(uv * 6.0f, 6, 3, seed)};
    });
}

uint32_t addSurfaceMaterial(SceneBuilder& builder, const SurfaceImages& images, Material base, const std::string& name,
                            float normalScale) {
    auto slotFor = [&](const ImageData& image) {
        TextureSlot slot = SceneBuilder::defaultTexture(builder.addImage(image));
        slot.transform = vec4(1.0f / images.metres, 0.0f, 0.0f, 1.0f / images.metres);
        return builder.addTexture(slot);
    };
    base.baseTexture = slotFor(images.color);
    if (normalScale > 0.0f) {
        base.normalTexture = slotFor(images.normal);
        base.normalScale = normalScale;
    }
    return builder.addMaterial(base, name);
}

Material matte(vec3 color, float roughness) {
    Material material = SceneBuilder::defaultMaterial();
    material.baseColor = vec4(color, 1.0f);
    material.roughness = roughness;
    material.metallic = 0.0f;
    return material;
}

}  // namespace heliograph::generate
