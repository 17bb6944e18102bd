#include "tests/kernel/kernel_access.h"

#include "server/request/effect_rules.h"
#include "tests/support/bodies.h"

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

#include <map>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;

Material painted(float albedo, float glow) {
    Material m = SceneBuilder::defaultMaterial();
    m.baseColor = vec4(vec3(albedo), 1.0f);
    m.emission = vec4(vec3(glow), 0.0f);
    return m;
}

/// `count` glowing triangles of all sizes and strengths, every third one in an instance of its own and a dark one after each.
/// `spread`: metres that they stand apart.
std::shared_ptr<const Scene> lamps(size_t count, float spread, uint64_t seed) {
    Random random(seed);
    SceneBuilder builder("lamps");
    const uint32_t dark = builder.addMaterial(painted(0.5f, 0.0f), "dark");
    std::vector<uint32_t> bright;
    for (int i = 0; i < 32; i++)
        bright.push_back(builder.addMaterial(painted(0.0f, float(random.magnitude(0.01, 100.0))), "lamp"));
    MeshData together;
    for (size_t i = 0; i < count; i++) {
        MeshData piece = panel(random.inCube(spread), random.direction() * random.real(0.01f, 0.3f), 0.1f * random.direction());
        piece.materials = {bright[i % 32], dark};
        if (i % 3 == 0) {
            builder.addInstance(builder.addMesh(piece), glm::translate(mat4(1.0f), random.inCube(1.0f)));
            continue;
        }
        const auto first = static_cast<uint32_t>(together.positions.size());
        together.positions.insert(together.positions.end(), piece.positions.begin(), piece.positions.end());
        together.normals.insert(together.normals.end(), piece.normals.begin(), piece.normals.end());
        for (uvec3 t : piece.indices) together.indices.push_back(t + uvec3(first));
        together.materials.insert(together.materials.end(), piece.materials.begin(), piece.materials.end());
    }
    builder.addInstance(builder.addMesh(together), mat4(1.0f));
    return builder.finish();
}

struct Chooser {
    std::shared_ptr<const Scene> scene;
    EveryKernel kernel = bareKernel();

    explicit Chooser(std::shared_ptr<const Scene> of) : scene(std::move(of)) {
        kernel.scene = sceneView(*scene);
        kernel.frame.effects |= EFFECT_SURFACE_LIGHTS;
        kernel.frame.layers |= static_cast<uint32_t>(EFFECT_MANY_LAMPS >> 32);
    }
    uint32_t count() const { return scene->environment.emitterCount; }
    uvec2 placeOf(uint32_t entry) const {
        const uint32_t* words = &scene->texels[scene->environment.emitterTable + size_t(entry) * EMITTER_TABLE_WORDS];
        return {words[2], words[3]};
    }
    double chance(vec3 point, uint32_t entry) { return double(kernel.lampChance(point, placeOf(entry).x, placeOf(entry).y)); }
    uint32_t entryOf(uint32_t word) const { return (word - scene->environment.emitterTable) / EMITTER_TABLE_WORDS; }
};

void expectExactChances(Chooser& c, vec3 point) {
    std::vector<double> of(c.count());
    double sum = 0.0;
    for (uint32_t i = 0; i < c.count(); i++) {
        of[i] = c.chance(point, i);
        EXPECT_GT(of[i], 0.0) << "nothing that glows is left out";
        sum += of[i];
    }
    EXPECT_NEAR(sum, 1.0, 1e-4);
    const int n = 16384;
    std::vector<double> often(c.count());
    for (int i = 0; i < n; i++) {
        const auto chosen = c.kernel.chosenLamp(point, (float(i) + 0.5f) / n);
        ASSERT_GT(chosen.chance, 0.0f);
        const uint32_t entry = c.entryOf(chosen.light);
        ASSERT_LT(entry, c.count());
        ASSERT_NEAR(double(chosen.chance), of[entry], 1e-5 * of[entry] + 1e-12);
        often[entry] += 1.0 / n;
    }
    for (uint32_t i = 0; i < c.count(); i++) ASSERT_NEAR(often[i], of[i], 2.5 / n) << i;
}

TEST(ManyLamps, AreChosenWithTheChancesThatPathsAreTold) {
    for (size_t count : {65u, 513u, 2000u}) {
        Chooser c(lamps(count, 3.0f, count));
        ASSERT_EQ(c.count(), count);
        Random random(4);
        for (int i = 0; i < 6; i++) expectExactChances(c, random.inCube(i < 3 ? 4.0f : 40.0f));
    }
}

TEST(ManyLamps, NearOnesAreChosenMoreOften) {
    Chooser c(lamps(500, 8.0f, 3));
    const Scene& scene = *c.scene;
    for (uint32_t entry : {7u, 100u, 480u}) {
        const uvec2 place = c.placeOf(entry);
        const Instance& instance = scene.instances[place.x];
        const vec4 p(vec3(scene.positions[scene.triangles[scene.meshes[instance.mesh].firstTriangle + place.y].x]), 1.0f);
        const vec3 at(glm::dot(instance.toWorld0, p), glm::dot(instance.toWorld1, p), glm::dot(instance.toWorld2, p));
        EXPECT_GT(c.chance(at, entry), 4.0 * c.chance(at + vec3(6.0f, 0.0f, 0.0f), entry)) << entry;
    }
}

TEST(ManyLamps, EveryLampHasItsEntryAndOthersHaveNone) {
    Chooser c(lamps(300, 3.0f, 9));
    std::map<std::pair<uint32_t, uint32_t>, uint32_t> entries;
    for (uint32_t i = 0; i < c.count(); i++) entries[{c.placeOf(i).x, c.placeOf(i).y}] = i;
    for (uint32_t i = 0; i < c.scene->instances.size(); i++) {
        for (uint32_t t = 0; t < c.scene->meshes[c.scene->instances[i].mesh].triangleCount; t++) {
            const auto found = entries.find({i, t});
            EXPECT_EQ(c.kernel.lampEntry(i, t), found == entries.end() ? c.count() : found->second);
            if (found == entries.end()) EXPECT_EQ(c.kernel.lampChance(vec3(0.0f), i, t), 0.0f);
        }
    }
}

// A way down takes LAMP_TRAIL_BITS of a word a level: also where all lamps stand in one place the tree is not too deep for it.
TEST(ManyLamps, TrailsFitIntoAWord) {
    for (float spread : {0.0f, 1e-6f, 100.0f}) {
        Chooser c(lamps(6000, spread, 2));
        EXPECT_GE(c.scene->environment.lampTreeLevels, 5u);
        EXPECT_LE(c.scene->environment.lampTreeLevels, 32u / LAMP_TRAIL_BITS);
        double sum = 0.0;
        for (uint32_t i = 0; i < c.count(); i++) sum += c.chance(vec3(0.5f, 1.0f, 2.0f), i);
        EXPECT_NEAR(sum, 1.0, 1e-3) << spread;
    }
}

TEST(ManyLamps, AFewStandInNoTree) {
    const auto few = lamps(MOST_LISTED_LAMPS, 3.0f, 1);
    EXPECT_EQ(few->environment.lampTreeLevels, 0u);
    EXPECT_TRUE(effectsOf(*few).has(EFFECT_SURFACE_LIGHTS));
    EXPECT_FALSE(effectsOf(*few).has(EFFECT_MANY_LAMPS));
    EXPECT_TRUE(effectsOf(*lamps(MOST_LISTED_LAMPS + 1, 3.0f, 1)).has(EFFECT_MANY_LAMPS));
}

}  // namespace
}  // namespace heliograph::TEST_FILE
