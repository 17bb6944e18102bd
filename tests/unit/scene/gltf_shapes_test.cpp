// HELIOGRAPH_shapes: analytic shapes of glTF nodes.

#include "server/base/error.h"
#include "server/request/effect_rules.h"
#include "server/scene/load/scene_source.h"
#include "server/scene/shape.h"
#include "tests/unit/scene/scene_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

using namespace testing_files;
using testing::Contains;
using testing::HasSubstr;

std::string fileWith(const std::string& nodes, const std::string& more = "") {
    return R"({"asset":{"version":"2.0"},"extensionsUsed":["HELIOGRAPH_shapes"],)" + more + R"("nodes":[)" + nodes + "]}";
}
std::string node(const std::string& shape, const std::string& more = "") {
    return "{" + more + R"("extensions":{"HELIOGRAPH_shapes":)" + shape + "}}";
}

std::shared_ptr<const Scene> opened(const std::string& json) {
    const ScratchFolder folder;
    return openScene(folder.write("a.gltf", json));
}

TEST(GltfShapes, AreReadWithSizePlaceAndMaterial) {
    const auto scene = opened(fileWith(
        node(R"({"kind":"sphere","radius":2,"material":0})", R"("name":"moon","translation":[10,20,30],)") + "," +
            node(R"({"kind":"cylinder","radius":0.5,"height":3})") + "," + node(R"({"kind":"cylinder","capped":false})") + "," +
            node(R"({"kind":"disc","radius":4})") + "," + node(R"({"kind":"plane"})"),
        R"("materials":[{"name":"rock"}],)"));
    ASSERT_EQ(scene->instances.size(), 5u);
    EXPECT_EQ(scene->triangleCount(), 0u);
    const Instance& moon = scene->instances[0];
    EXPECT_TRUE(isShape(moon));
    EXPECT_EQ(shapeKindOf(moon), SHAPE_SPHERE);
    EXPECT_EQ(moon.toWorld0, vec4(2, 0, 0, 10));
    EXPECT_EQ(moon.toWorld1, vec4(0, 2, 0, 20));
    EXPECT_EQ(scene->materialNames[scene->triangles[moon.firstTriangle].w], "rock");
    EXPECT_EQ(scene->objects.of(0, moon.firstTriangle), "moon");
    EXPECT_EQ(scene->instances[1].toWorld1.y, 1.5f);
    EXPECT_EQ(scene->instances[1].flags & SHAPE_CAPPED, SHAPE_CAPPED);
    EXPECT_EQ(scene->instances[2].flags & SHAPE_CAPPED, 0u);
    EXPECT_EQ(scene->instances[2].toWorld1.y, 0.5f);
    EXPECT_EQ(scene->instances[3].toWorld0.x, 4.0f);
    EXPECT_EQ(shapeKindOf(scene->instances[4]), SHAPE_PLANE);
    EXPECT_TRUE(effectsOf(*scene).has(EFFECT_SHAPES));
}

TEST(GltfShapes, APlaneMakesNoSceneLarger) {
    const auto alone = opened(fileWith(node(R"({"kind":"sphere"})")));
    const auto both =
        opened(fileWith(node(R"({"kind":"sphere"})") + "," + node(R"({"kind":"plane"})", R"("translation":[0,-1,0],)")));
    EXPECT_EQ(alone->bounds.low, both->bounds.low);
    EXPECT_EQ(alone->bounds.high, both->bounds.high);
    EXPECT_GT(shapeBounds(both->instances[1]).high.x, 1000.0f);
    const auto plane = opened(fileWith(node(R"({"kind":"plane"})", R"("translation":[0,7,0],)")));
    EXPECT_NEAR(plane->bounds.center().y, 7.0f, 1e-5f);
    EXPECT_GT(plane->cameras.at(0).position.y, 7.5f) << "seen from above";
}

TEST(GltfShapes, WhatAKindHasNoUseForIsTold) {
    const auto scene =
        opened(fileWith(node(R"({"kind":"plane","radius":3})") + "," + node(R"({"kind":"disc","capped":true})")));
    EXPECT_THAT(scene->warnings, Contains(HasSubstr("HELIOGRAPH_shapes/radius: a plane has none")));
    EXPECT_THAT(scene->warnings, Contains(HasSubstr("HELIOGRAPH_shapes/capped: a disc has none")));
}

TEST(GltfShapes, OddValuesAreRefusedWithFieldAndRange) {
    const std::pair<const char*, const char*> CASES[] = {
        {R"({})", "kind"},
        {R"({"kind":7})", "kind"},
        {R"({"kind":"cube"})", "sphere, cylinder, disc or plane"},
        {R"({"kind":"sphere","radius":0})", "radius"},
        {R"({"kind":"sphere","radius":-1})", "radius"},
        {R"({"kind":"sphere","radius":1e30})", "radius"},
        {R"({"kind":"sphere","radius":"big"})", "radius"},
        {R"({"kind":"cylinder","height":[1]})", "height"},
        {R"({"kind":"cylinder","capped":1})", "capped"},
        {R"({"kind":"disc","material":0})", "material"},
        {R"({"kind":"disc","material":-1})", "material"},
        {R"([])", "HELIOGRAPH_shapes"},
    };
    for (const auto& [shape, said] : CASES) {
        try {
            opened(fileWith(node(shape)));
            ADD_FAILURE() << shape;
        } catch (const InputError& error) {
            EXPECT_THAT(error.what(), HasSubstr(said)) << shape;
            EXPECT_THAT(error.what(), HasSubstr("/nodes/0")) << shape;
        }
    }
}

TEST(GltfShapes, OfManyMaterialsAreHeldToTheSizeOfTheFile) {
    std::string nodes, materials;
    for (int i = 0; i < 4000; i++) {
        nodes += (i ? "," : "") + node(R"({"kind":"sphere","material":)" + std::to_string(i) + "}");
        materials += i ? ",{}" : "{}";
    }
    try {
        opened(fileWith(nodes, R"("materials":[)" + materials + "],"));
        ADD_FAILURE();
    } catch (const InputError& error) {
        EXPECT_THAT(error.what(), HasSubstr("vertices and corners"));
    }
}

TEST(GltfShapes, OneOfZeroScaleIsDrawnFlatOrLeftOut) {
    const auto flat = opened(fileWith(node(R"({"kind":"sphere"})", R"("scale":[1,0,1],)") + "," + node(R"({"kind":"disc"})")));
    ASSERT_EQ(flat->instances.size(), 2u);
    EXPECT_GT(flat->triangleCount(), 0u);
    const auto none = opened(fileWith(node(R"({"kind":"plane"})", R"("scale":[0,0,0],)") + "," + node(R"({"kind":"disc"})")));
    EXPECT_EQ(none->instances.size(), 1u);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
