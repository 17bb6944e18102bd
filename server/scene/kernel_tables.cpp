#include "server/scene/kernel_tables.h"

#include "server/scene/lobe_table.h"

namespace heliograph {

namespace {

constexpr uint32_t POINTS = 4096;  // SOBOL_COUNT of kernel/sampling.glsl

uint32_t reverseBits(uint32_t x) {
    uint32_t result = 0;
    for (int bit = 0; bit < 32; bit++) result |= ((x >> bit) & 1u) << (31 - bit);
    return result;
}

uint32_t owenScramble(uint32_t x, uint32_t seed) {
    uint32_t v = reverseBits(x);
    v ^= v * 0x3d20adeau;
    v += seed;
    v *= (seed >> 16) | 1u;
    v ^= v * 0x05526c56u;
    v ^= v * 0x53a22864u;
    return reverseBits(v);
}

// Second Sobol dimension: direction numbers of the primitive polynomial x + 1.
uint32_t sobolSecond(uint32_t index) {
    uint32_t result = 0;
    for (uint32_t v = 1u << 31; index != 0; index >>= 1, v ^= v >> 1)
        if (index & 1u) result ^= v;
    return result;
}

}  // namespace

const std::vector<uvec2>& kernelTable() {
    static const std::vector<uvec2> table = [] {
        std::vector<uvec2> both = sobolTable();
        const std::vector<uvec2> lobes = lobeTable();
        both.insert(both.end(), lobes.begin(), lobes.end());
        return both;
    }();
    return table;
}

const std::vector<uvec2>& sobolTable() {
    static const std::vector<uvec2> table = [] {
        std::vector<uvec2> points(POINTS);
        for (uint32_t i = 0; i < POINTS; i++)
            points[i] = uvec2(owenScramble(reverseBits(i), 0x8f2b3c51u), owenScramble(sobolSecond(i), 0x1d9a7e63u));
        return points;
    }();
    return table;
}

SceneView sceneView(const Scene& scene) {
    SceneView view;
    view.positions = scene.positions.data();
    view.attributes = scene.attributes.data();
    view.tangents = scene.tangents.data();
    view.triangles = scene.triangles.data();
    view.meshes = scene.meshes.data();
    view.instances = scene.instances.data();
    view.materials = scene.materials.data();
    view.textures = scene.textures.data();
    view.images = scene.images.data();
    view.imageLevels = scene.imageLevels.data();
    view.texels = scene.texels.data();
    view.lights = scene.lights.data();
    view.environment = &scene.environment;
    view.sobol = kernelTable().data();
    return view;
}

}  // namespace heliograph
