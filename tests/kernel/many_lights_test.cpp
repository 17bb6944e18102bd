#include "tests/kernel/kernel_access.h"

#include "server/request/effect_rules.h"
#include "tests/support/bodies.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstring>
#include <map>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;

Light shining(uint32_t type, vec3 position, vec3 direction, float intensity) {
    Light light{};
    light.type = type;
    light.position = position;
    light.direction = glm::normalize(direction);
    light.intensity = vec3(intensity, 0.7f * intensity, 0.3f * intensity);
    light.cosInner = 0.9f;
    light.cosOuter = 0.7f;
    return light;
}

/// A floor of 2 m under these lights.
std::shared_ptr<const Scene> under(const std::vector<Light>& lights) {
    SceneBuilder builder("lights");
    builder.addInstance(builder.addMesh(panel(vec3(-1, 0, 1), vec3(2, 0, 0), vec3(0, 0, -2), 0)), mat4(1.0f));
    for (const Light& light : lights) builder.addLight(light);
    return builder.finish();
}

std::vector<Light> mixedLights(size_t count, uint64_t seed) {
    Random random(seed);
    std::vector<Light> lights;
    for (size_t i = 0; i < count; i++) {
        const uint32_t types[] = {LIGHT_POINT, LIGHT_SPOT, LIGHT_QUAD};
        Light light = shining(types[i % 3], random.inCube(4.0f), random.direction(), float(random.magnitude(0.01, 10.0)));
        if (i % 3 != 2 && i % 5 == 0) light.radius = random.real(0.01f, 0.5f);
        if (i % 7 == 0) light.range = random.real(1.0f, 8.0f);
        if (i % 11 == 0) light.falloff = FALLOFF_LINEAR;
        if (light.type == LIGHT_QUAD) {
            light.edge = glm::normalize(glm::cross(light.direction, vec3(0.3f, 0.5f, 0.8f))) * random.real(0.1f, 0.6f);
            light.aspect = random.real(0.3f, 2.0f);
        }
        lights.push_back(light);
    }
    return lights;
}

/// The kernel before a scene, with the choice of lights on.
struct Chooser {
    std::shared_ptr<const Scene> scene;
    EveryKernel kernel = bareKernel();

    explicit Chooser(std::shared_ptr<const Scene> of) : scene(std::move(of)) {
        kernel.scene = sceneView(*scene);
        kernel.frame.effects |= EFFECT_MANY_LIGHTS;
        kernel.frame.lightCount = scene->environment.listedLights;
    }
    uint32_t lights() const { return static_cast<uint32_t>(scene->lights.size()) - scene->environment.listedLights; }
    /// Index in Scene::lights of what a choice found.
    uint32_t indexOf(uint32_t word) const {
        if (of_.empty()) {
            // The lights stand before the root, in the order of the scene; dark ones do not.
            uint32_t end = scene->environment.lightTree;
            for (uint32_t i = static_cast<uint32_t>(scene->lights.size()); i-- > scene->environment.listedLights;)
                if (scene->lights[i].intensity != vec3(0.0f)) of_[end -= 20u] = i;
        }
        EXPECT_EQ(std::memcmp(&scene->lights[of_.at(word)], &scene->texels[word], sizeof(Light)), 0);
        return of_.at(word);
    }
    EveryKernel::LightWay way(vec3 origin, vec3 normal) const { return {origin, normal, 0.0f}; }
    EveryKernel::ChosenLight choose(vec3 point, vec3 normal, double u) {
        return kernel.chosenLight(way(point, normal), 1, static_cast<float>(u));
    }
    /// What the light gives there: irradiance times the cosine, seen from its middle.
    double given(uint32_t index, vec3 point, vec3 normal) {
        kernel.frame.lightCount = static_cast<uint32_t>(scene->lights.size());
        const auto sample = kernel.lightAt(index, point);
        kernel.frame.lightCount = scene->environment.listedLights;
        return double(sample.irradiance.x) * std::max(glm::dot(normal, sample.direction), 0.0f);
    }

private:
    mutable std::map<uint32_t, uint32_t> of_;
};

/// Chances of all lights at a point, by the tree's parts, in double; under NO_INDEX that of finding none: bounds of several lights
/// may let through what those of each do not.
void chancesBelow(Chooser& c, uint32_t node, const EveryKernel::LightWay& way, uint32_t surface, double chance,
                  std::map<uint32_t, double>& of) {
    std::array<double, LIGHT_TREE_WIDTH> weight{};
    std::array<uint32_t, LIGHT_TREE_WIDTH> next{};
    double sum = 0.0;
    for (uint32_t i = 0; i < LIGHT_TREE_WIDTH; i++) {
        const auto part = c.kernel.lightPartAt(node + i * LIGHT_TREE_WORDS, way, surface);
        weight[i] = double(part.strength) * part.strength * part.facing;
        next[i] = part.next;
        sum += weight[i];
    }
    if (!(sum > 0.0)) of[NO_INDEX] += chance;
    for (uint32_t i = 0; i < LIGHT_TREE_WIDTH; i++) {
        if (!(weight[i] > 0.0)) continue;
        const double own = chance * weight[i] / sum;
        if (next[i] & LIGHT_TREE_LEAF) of[next[i] & ~LIGHT_TREE_LEAF] += own;
        else chancesBelow(c, next[i], way, surface, own, of);
    }
}

std::map<uint32_t, double> chances(Chooser& c, vec3 point, vec3 normal) {
    std::map<uint32_t, double> of;
    chancesBelow(c, c.scene->environment.lightTree, c.way(point, normal), 1, 1.0, of);
    return of;
}

/// Chances add up to one, those told with a choice are those of the tree and how often it is made, and what shines has one.
void expectExactChances(Chooser& c, vec3 point, vec3 normal) {
    const std::map<uint32_t, double> of = chances(c, point, normal);
    double sum = 0.0;
    for (const auto& [word, chance] : of) sum += chance;
    ASSERT_NEAR(sum, 1.0, 1e-9);
    std::map<uint32_t, double> often;
    const int n = 4096;
    for (int i = 0; i < n; i++) {
        const auto chosen = c.choose(point, normal, (i + 0.5) / n);
        const uint32_t word = chosen.chance > 0.0f ? chosen.light : NO_INDEX;
        ASSERT_TRUE(of.contains(word)) << chosen.chance;
        if (word != NO_INDEX) {
            ASSERT_NEAR(chosen.chance / of.at(word), 1.0, 2e-5);
        }
        often[word] += 1.0 / n;
    }
    std::vector<bool> has(c.scene->lights.size(), false);
    for (const auto& [word, chance] : of) {
        if (word == NO_INDEX) continue;
        EXPECT_NEAR(often[word], chance, 2.1 / n);  // each has one stretch of the numbers
        has[c.indexOf(word)] = true;
    }
    double all = 0.0, missed = 0.0;
    for (uint32_t i = c.scene->environment.listedLights; i < c.scene->lights.size(); i++) {
        all += c.given(i, point, normal);
        if (!has[i]) missed += c.given(i, point, normal);
    }
    EXPECT_LE(missed, 1e-6 * all);
}

/// The mean over choices is the sum over all lights.
void expectWholeLight(Chooser& c, vec3 point, vec3 normal, double tolerance) {
    double sum = 0.0, mean = 0.0;
    for (uint32_t i = c.scene->environment.listedLights; i < c.scene->lights.size(); i++) sum += c.given(i, point, normal);
    const int n = 1 << 16;
    for (int i = 0; i < n; i++) {
        const auto chosen = c.choose(point, normal, (i + 0.5) / n);
        if (chosen.chance > 0.0f) mean += c.given(c.indexOf(chosen.light), point, normal) / chosen.chance / n;
    }
    EXPECT_NEAR(mean, sum, tolerance * sum);
}

TEST(ManyLights, ChancesAreExactAtRandomPoints) {
    for (size_t count : {33, 64, 257, 1000}) {
        Chooser c(under(mixedLights(count, count)));
        ASSERT_EQ(c.lights(), count);
        Random random(count);
        for (int i = 0; i < 40; i++) expectExactChances(c, random.inCube(6.0f), random.direction());
    }
}

TEST(ManyLights, TheMeanOfChoicesIsTheSumOfAllLights) {
    Chooser c(under(mixedLights(200, 5)));
    Random random(6);
    for (int i = 0; i < 6; i++) expectWholeLight(c, random.inCube(5.0f), random.direction(), 2e-3);
}

// Any point of a way may be where a light shines from, so the chances there know nothing of cosines.
TEST(ManyLights, ChancesInFogAddUpToOneAndReachEveryLight) {
    Chooser c(under(mixedLights(300, 7)));
    Random random(8);
    for (int i = 0; i < 50; i++) {
        const EveryKernel::LightWay way{random.inCube(6.0f), random.direction(), random.real(0.1f, 10.0f)};
        std::map<uint32_t, double> of;
        chancesBelow(c, c.scene->environment.lightTree, way, 0, 1.0, of);
        double sum = 0.0;
        for (const auto& [word, chance] : of) sum += chance;
        ASSERT_NEAR(sum, 1.0, 1e-9);
        std::vector<bool> has(c.scene->lights.size(), false);
        for (const auto& [word, chance] : of)
            if (word != NO_INDEX) has[c.indexOf(word)] = true;
        for (int k = 0; k < 20; k++) {
            const vec3 point = way.origin + way.direction * random.real(0.0f, way.reach);
            for (uint32_t l = 0; l < c.scene->lights.size(); l++) {
                const bool shines = c.given(l, point, glm::normalize(c.scene->lights[l].position - point)) > 0.0;
                ASSERT_TRUE(has[l] || !shines) << "light " << l;
            }
        }
    }
}

TEST(ManyLights, ALightOfTheTreeIsTheOneOfTheList) {
    Chooser c(under(mixedLights(330, 9)));
    Random random(10);
    for (uint32_t l = 0; l < c.scene->lights.size(); l++) {
        const Light& light = c.scene->lights[l];
        const uint32_t word = c.scene->environment.lightTree - static_cast<uint32_t>(c.scene->lights.size() - l) * 20u;
        ASSERT_EQ(c.indexOf(word), l);
        for (const bool soft : {false, true}) {
            c.kernel.frame.effects =
                soft ? c.kernel.frame.effects | EFFECT_SOFT_SHADOWS : c.kernel.frame.effects & ~uint32_t(EFFECT_SOFT_SHADOWS);
            for (int i = 0; i < 20; i++) {
                const vec3 point = random.inCube(6.0f);
                const uvec2 number(random.word(), random.word());
                const vec2 place(c.kernel.unitFloat(number.x), c.kernel.unitFloat(number.y ^ c.kernel.hashUint(0)));
                c.kernel.frame.lightCount = static_cast<uint32_t>(c.scene->lights.size());
                const auto listed = c.kernel.anyLightAt(l, number, 0, point);
                const auto chosen = c.kernel.lightOfTree(word, place, point);
                ASSERT_EQ(chosen.direction, listed.direction) << light.type;
                ASSERT_EQ(chosen.distance, listed.distance) << light.type;
                for (int k = 0; k < 3; k++)
                    ASSERT_NEAR(chosen.irradiance[k], listed.irradiance[k], 4e-7f * listed.irradiance[k]) << light.type;
            }
        }
    }
}

TEST(ManyLights, AFewAreAskedOneByOneInTheOrderOfTheFile) {
    const std::vector<Light> lights = mixedLights(MOST_LISTED_LIGHTS, 11);
    const auto scene = under(lights);
    EXPECT_EQ(scene->environment.lightTreeLevels, 0u);
    EXPECT_FALSE(effectsOf(*scene).has(EFFECT_MANY_LIGHTS));
    ASSERT_EQ(scene->lights.size(), lights.size());
    for (size_t i = 0; i < lights.size(); i++) EXPECT_EQ(scene->lights[i].position, lights[i].position);
    EXPECT_TRUE(effectsOf(*under(mixedLights(MOST_LISTED_LIGHTS + 1, 11))).has(EFFECT_MANY_LIGHTS));
}

TEST(ManyLights, WithoutAPlaceTheyAreListedAndDarkOnesAreInNoTree) {
    std::vector<Light> lights = mixedLights(60, 12);
    for (size_t i = 0; i < 10; i++) lights[i * 5].intensity = vec3(0.0f);
    for (int i = 0; i < 3; i++)
        lights.insert(lights.begin() + 7 * i, shining(LIGHT_DIRECTIONAL, vec3(0.0f), vec3(0, -1, 0), 1.0f));
    Chooser c(under(lights));
    EXPECT_EQ(c.scene->environment.listedLights, 3u);
    for (uint32_t i = 0; i < 3; i++) EXPECT_EQ(c.scene->lights[i].type, LIGHT_DIRECTIONAL);
    EXPECT_EQ(c.scene->lights.back().intensity, vec3(0.0f));
    Random random(13);
    for (int i = 0; i < 20; i++) expectExactChances(c, random.inCube(6.0f), random.direction());
}

TEST(ManyLights, HardPlaces) {
    std::map<std::string, std::vector<Light>> cases;
    for (int i = 0; i < 1000; i++) {
        const float x = float(i);
        cases["at one point"].push_back(shining(LIGHT_POINT, vec3(1, 2, 3), vec3(0, -1, 0), 1.0f + 0.001f * x));
        cases["on a line"].push_back(shining(LIGHT_POINT, vec3(0.01f * x, 2, 0), vec3(0, -1, 0), 1.0f + 0.001f * x));
        cases["one far away"].push_back(
            shining(LIGHT_POINT, i == 500 ? vec3(2e6f, 2, 0) : vec3(0.01f * x, 2, 0.02f * float(i % 7)), vec3(0, -1, 0), 1.0f));
        cases["one enormous"].push_back(shining(LIGHT_POINT, vec3(0.01f * x, 2, 0), vec3(0, -1, 0), i == 3 ? 1e25f : 1.0f));
        cases["ever farther"].push_back(
            shining(LIGHT_SPOT, vec3(std::exp2(0.03f * x), 2, 0), vec3(-1, 0, 0), std::exp2(0.05f * x)));
        cases["tiny"].push_back(shining(LIGHT_POINT, vec3(1e-9f * x, 1e-9f, 0), vec3(0, -1, 0), 1e-20f));
    }
    for (const auto& [name, lights] : cases) {
        SCOPED_TRACE(name);
        Chooser c(under(lights));
        ASSERT_EQ(c.lights(), 1000u);
        EXPECT_LE(c.scene->environment.lightTreeLevels, 12u);
        Random random(14);
        for (const vec3 point : {vec3(0.0f), vec3(1, 2, 3), vec3(1, 2.5f, 0), vec3(1e6f, 0, 1), vec3(-3, 1, 2)})
            for (int i = 0; i < 4; i++) expectExactChances(c, point, random.direction());
        expectWholeLight(c, vec3(0.3f, 0.0f, 0.4f), vec3(0, 1, 0), 5e-3);
    }
}

TEST(ManyLights, NothingIsChosenWhereAllShineFromBehind) {
    std::vector<Light> lights;
    for (int i = 0; i < 200; i++)
        lights.push_back(shining(LIGHT_POINT, vec3(0.1f * float(i % 17), 2.0f + 0.01f * float(i), 0), vec3(0, -1, 0), 1.0f));
    Chooser c(under(lights));
    EXPECT_EQ(c.choose(vec3(0.0f), vec3(0, -1, 0), 0.3).chance, 0.0f);
    EXPECT_GT(c.choose(vec3(0.0f), vec3(0, 1, 0), 0.3).chance, 0.0f);
    for (Light& light : lights) light.type = LIGHT_SPOT;
    Chooser spots(under(lights));
    EXPECT_EQ(spots.choose(vec3(0.5f, 9.0f, 0), vec3(0, -1, 0), 0.3).chance, 0.0f) << "above spots that shine down";
    EXPECT_GT(spots.choose(vec3(0.5f, 0.0f, 0), vec3(0, 1, 0), 0.3).chance, 0.0f);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
