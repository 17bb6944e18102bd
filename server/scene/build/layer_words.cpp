#include "server/scene/build/layer_words.h"

#include "server/base/error.h"
#include "server/kernel/kernel.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>

namespace heliograph {

namespace {

using SheenKernel = scalar_kernel::Kernel<0>;

/// The lobe with the cosine over the hemisphere, by midpoints in the half-way vector's own terms: cosine and azimuth of wi.
float sheenShare(SheenKernel& kernel, double roughness, double cosine) {
    constexpr int RINGS = 32, SECTORS = 16;  // of half a turn: the other half is the same
    const double sine = std::sqrt(1.0 - cosine * cosine);
    double sum = 0.0;
    for (int i = 0; i < RINGS; i++) {
        // Rings lie closer at the rim, where the lobe is high: z = w^2.
        const double w = (i + 0.5) / RINGS, z = w * w, s = std::sqrt(1.0 - z * z);
        for (int j = 0; j < SECTORS; j++) {
            const double turn = std::numbers::pi * (j + 0.5) / SECTORS;
            const glm::dvec3 wi(s * std::cos(turn), s * std::sin(turn), z),
                h = glm::normalize(wi + glm::dvec3(sine, 0.0, cosine));
            sum += double(kernel.sheenLobe(float(roughness), float(cosine), float(z), float(h.z))) * 2.0 * w;
        }
    }
    return static_cast<float>(sum * 2.0 * std::numbers::pi / (RINGS * SECTORS));
}

}  // namespace

MaterialLayers layersOf(const Scene& scene, const Material& material) {
    MaterialLayers layers;
    if (material.layers == NO_INDEX) return layers;
    std::array<uint32_t, LAYER_WORDS> words;
    std::copy_n(scene.texels.begin() + material.layers, LAYER_WORDS, words.begin());
    return std::bit_cast<MaterialLayers>(words);
}

std::vector<float> sheenTable() {
    SheenKernel kernel;
    constexpr uint32_t NODES = SheenKernel::SHEEN_NODES;
    std::vector<float> table(size_t(NODES) * NODES);
    for (uint32_t i = 0; i < NODES; i++) {
        const double roughness = std::max(double(i) / (NODES - 1), double(SheenKernel::LEAST_SHEEN_ROUGHNESS));
        for (uint32_t j = 0; j < NODES; j++) {
            const double root = double(j) / (NODES - 1);
            table[i * NODES + j] = std::log(std::max(sheenShare(kernel, roughness, std::max(root * root, 1e-4)), 1e-8f));
        }
    }
    return table;
}

void appendLayers(SceneDraft& draft) {
    Scene& scene = draft.scene;
    if (draft.layers.empty()) return;
    const size_t first = scene.texels.size(), table = first + draft.layers.size() * LAYER_WORDS;
    if (table + SheenKernel::SHEEN_NODES * SheenKernel::SHEEN_NODES >= NO_INDEX)
        throw InputError(scene.name, std::to_string(first) + " texels", "fewer than 4294967295 with its materials' layers");
    bool sheen = false;
    for (MaterialLayers& layers : draft.layers) {
        if (layers.sheenRed > 0.0f || layers.sheenGreen > 0.0f || layers.sheenBlue > 0.0f) {
            layers.sheenTable = static_cast<uint32_t>(table);
            sheen = true;
        }
        const auto words = std::bit_cast<std::array<uint32_t, LAYER_WORDS>>(layers);
        scene.texels.insert(scene.texels.end(), words.begin(), words.end());
    }
    if (sheen) std::ranges::transform(sheenTable(), std::back_inserter(scene.texels), std::bit_cast<uint32_t, float>);
    for (Material& material : scene.materials) {
        if (material.layers != NO_INDEX) material.layers = static_cast<uint32_t>(first + material.layers * LAYER_WORDS);
    }
}

}  // namespace heliograph
