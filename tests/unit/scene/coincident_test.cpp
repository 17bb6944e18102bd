// Triangles that lie exactly on others: which of them are drawn.

#include "server/scene/build/scene_builder.h"

#include "tests/support/bodies.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;

/// Two triangles of the given materials on the corners `order` of the first.
struct Pair {
    Material first = SceneBuilder::defaultMaterial(), second = SceneBuilder::defaultMaterial();
    bool oneMaterial = false;
    uvec3 order{0, 1, 2};

    /// Which of the two has an area.
    std::pair<bool, bool> drawn() const {
        SceneBuilder builder("t");
        const uint32_t red = builder.addMaterial(first, "first");
        const uint32_t green = oneMaterial ? red : builder.addMaterial(second, "second");
        const vec3 corners[] = {vec3(0.0f, 1.0f, 2.0f), vec3(3.0f, -0.0f, 1.0f), vec3(-1.0f, 4.0f, 0.5f)};
        MeshData mesh;
        for (int k = 0; k < 3; k++) mesh.positions.push_back(corners[k]);
        for (int k = 0; k < 3; k++) mesh.positions.push_back(corners[order[k]] + vec3(0.0f));
        mesh.indices = {{0, 1, 2}, {3, 4, 5}};
        mesh.materials = {red, green};
        builder.addInstance(builder.addMesh(mesh), mat4(1.0f));
        const auto scene = builder.finish();
        bool area[2] = {};
        for (const uvec4& t : scene->triangles) {
            const auto at = [&](uint32_t v) { return vec3(scene->positions[v]); };
            const bool spans = glm::cross(at(t.y) - at(t.x), at(t.z) - at(t.x)) != vec3(0.0f);
            area[t.x / 3] = spans;
        }
        const auto told = Contains(HasSubstr("1 triangles lie exactly on others"));
        if (area[0] && area[1]) EXPECT_THAT(scene->warnings, Not(told));
        else EXPECT_THAT(scene->warnings, told);
        return {area[0], area[1]};
    }
};

constexpr std::pair FIRST{true, false}, BOTH{true, true};

TEST(Coincident, OfTwoSolidOnesTheFirstIsDrawnWhicheverCornerComesFirst) {
    EXPECT_EQ(Pair{}.drawn(), FIRST);
    EXPECT_EQ((Pair{.order = {1, 2, 0}}.drawn()), FIRST);
    EXPECT_EQ((Pair{.order = {2, 0, 1}}.drawn()), FIRST);
}

TEST(Coincident, TheBackOfAnotherMaterialIsDrawnToo) {
    EXPECT_EQ((Pair{.order = {0, 2, 1}}.drawn()), BOTH);
    EXPECT_EQ((Pair{.oneMaterial = true, .order = {0, 2, 1}}.drawn()), FIRST) << "one material looks the same from both sides";
    Material inside = SceneBuilder::defaultMaterial();
    inside.flags |= MATERIAL_VOLUME;
    inside.transmission = 1.0f;
    EXPECT_EQ((Pair{.first = inside, .oneMaterial = true, .order = {0, 2, 1}}.drawn()), BOTH) << "of a body that has an inside";
}

TEST(Coincident, WhatShowsWhatIsBehindItHidesOnlyItsLike) {
    Material glass = SceneBuilder::defaultMaterial();
    glass.transmission = 1.0f;
    EXPECT_EQ((Pair{.first = glass, .second = glass}.drawn()), BOTH);
    EXPECT_EQ((Pair{.first = glass, .oneMaterial = true}.drawn()), FIRST);
}

TEST(Coincident, ManyInOnePlaceTakeNoTimeAndOneIsDrawn) {
    SceneBuilder builder("t");
    MeshData mesh = panel(vec3(0.0f), vec3(1, 0, 0), vec3(0, 1, 0));
    const auto once = mesh.indices;
    for (int i = 1; i < 100000; i++) mesh.indices.insert(mesh.indices.end(), once.begin(), once.end());
    builder.addInstance(builder.addMesh(mesh), mat4(1.0f));
    const auto scene = builder.finish();
    EXPECT_EQ(std::ranges::count_if(scene->triangles, [](uvec4 t) { return t.x != t.y; }), std::ptrdiff_t(once.size()));
}

}  // namespace
}  // namespace heliograph::TEST_FILE
