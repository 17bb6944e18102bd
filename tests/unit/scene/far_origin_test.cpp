#include "server/scene/load/far_origin.h"

#include "server/scene/load/scene_source.h"
#include "tests/unit/scene/scene_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace heliograph::TEST_FILE {
namespace {

using namespace testing_files;
using glm::dvec3;
using ::testing::Contains;
using ::testing::HasSubstr;

FarBox boxOf(dvec3 low, dvec3 high) {
    FarBox box;
    box.add(low);
    box.add(high);
    box.add(dvec3(NAN));
    return box;
}

TEST(FarOrigin, StaysWhereDigitsSuffice) {
    EXPECT_EQ(originOf({}), dvec3(0.0));
    EXPECT_EQ(originOf(boxOf(dvec3(100.0), dvec3(101.0))), dvec3(0.0));
    EXPECT_EQ(originOf(boxOf(dvec3(-1e9), dvec3(1e9))), dvec3(0.0)) << "large, not far";
    EXPECT_EQ(originNear(dvec3(0.0, 16000.0, 0.0)), dvec3(0.0));
    EXPECT_EQ(originNear(dvec3(NAN)), dvec3(0.0));
}

TEST(FarOrigin, GoesToTheMiddleInRoundNumbers) {
    EXPECT_EQ(originOf(boxOf(dvec3(512344.678, 101.5, 5403210.0), dvec3(512346.678, 103.5, 5403212.0))),
              dvec3(512346.0, 102.0, 5403212.0));
    EXPECT_NEAR(originOf(boxOf(dvec3(0.1, 0.0, 0.0), dvec3(0.1 + 1e-6, 1e-6, 0.0))).x, 0.1, 2e-6) << "small things, too";
    EXPECT_EQ(originNear(dvec3(1e6 + 100.0, 5.0, -3e4)), dvec3(1000448.0, 0.0, -29696.0));
}

std::string farGltf(double away, const std::string& otherNodes = {}) {
    std::array<char, 64> translation;
    std::snprintf(translation.data(), translation.size(), "[%.10g,0.5,%.10g]", away, -away);
    return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"translation":)" +
           std::string(translation.data()) + R"(,"children":[1,2)" + (otherNodes.empty() ? "" : ",3") +
           R"(]},{"mesh":0},{"camera":0,"translation":[0.1,0.2,3.5]})" + otherNodes +
           R"(],"cameras":[{"type":"perspective","perspective":{"yfov":0.8,"znear":0.01}}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],"bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,)" +
           base64(bytesOf<float>({0, 0, 0, 1, 0, 0, 0, 1, 0})) + R"("}]})";
}

/// Corners as the camera sees them, whatever the origin.
std::vector<vec3> seen(const Scene& scene) {
    std::vector<vec3> corners;
    for (int i = 0; i < 3; i++)
        corners.push_back(vec3(scene.positions.at(static_cast<size_t>(i))) - scene.cameras.at(0).position);
    return corners;
}

TEST(FarOrigin, AFarGltfHasTheShapeOfANearOne) {
    const ScratchFolder folder;
    const auto near = openScene(folder.write("a.gltf", farGltf(1.0)));
    EXPECT_THAT(near->warnings, ::testing::Not(Contains(HasSubstr("moved by"))));
    for (double away : {65536.0, 1048576.25, 16777216.375}) {
        const auto far = openScene(folder.write("b.gltf", farGltf(away)));
        EXPECT_THAT(far->warnings, Contains(HasSubstr("moved by")));
        for (int i = 0; i < 3; i++) {
            const vec3 off = seen(*far)[static_cast<size_t>(i)] - seen(*near)[static_cast<size_t>(i)];
            EXPECT_LT(glm::length(off), 1e-6f) << away;
        }
    }
}

TEST(FarOrigin, InALargeSceneTheFirstCameraIsNearTheOrigin) {
    const ScratchFolder folder;
    const auto scene = openScene(folder.write("a.gltf", farGltf(1048576.25, R"(,{"mesh":0,"translation":[-1000000,0,0]})")));
    EXPECT_LT(glm::length(scene->cameras.at(0).position), 1024.0f);
    EXPECT_THAT(scene->warnings, Contains(HasSubstr("moved by (-1048576, 0, 1048576)")));
}

}  // namespace
}  // namespace heliograph::TEST_FILE
