#include "server/lab/convergence/independence.h"

#include "server/device/embree/embree_device.h"
#include "server/request/camera.h"
#include "server/scene/framing.h"
#include "server/scene/load/scene_source.h"
#include "tests/support/direct_renderer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace heliograph::TEST_FILE {
namespace {

LinearPicture noise(uint32_t seed, float size) {
    std::mt19937 random(seed);
    std::normal_distribution<float> normal(0.0f, size);
    LinearPicture picture{uvec2(64, 64), std::vector<vec4>(64 * 64)};
    for (vec4& p : picture.pixels) p = vec4(1.0f + normal(random), 2.0f + normal(random), 0.5f + normal(random), 0.0f);
    return picture;
}

TEST(AgreementOfErrors, IsOneForTheSameAndNoneForOthers) {
    const LinearPicture truth = noise(1, 0.0f), a = noise(2, 0.1f), b = noise(3, 0.4f);
    EXPECT_NEAR(agreementOfErrors(a, a, truth, truth), 1.0, 1e-6);
    EXPECT_NEAR(agreementOfErrors(a, b, truth, truth), 0.0, 0.03) << "4,096 pixels";
    EXPECT_EQ(agreementOfErrors(truth, truth, truth, truth), 0.0) << "without error there is nothing to share";
}

TEST(AgreementOfErrors, IsThatOfHalfOfTheSamplesAndNoOnePixelsAlone) {
    const LinearPicture truth = noise(1, 0.0f), a = noise(2, 0.1f), b = noise(3, 0.1f);
    const double halved = agreementOfErrors(a, meanOf(a, b), truth, truth);
    EXPECT_GT(halved, 0.5);
    EXPECT_LT(halved, 0.8);
    LinearPicture c = b, d = b;
    c.pixels[7] = d.pixels[7] = vec4(1e6f);
    EXPECT_NEAR(agreementOfErrors(a, c, truth, truth), 0.0, 0.03);
    EXPECT_LT(agreementOfErrors(noise(4, 0.1f), d, truth, truth), 0.03);
}

TEST(Independence, HalvesOfAReferenceShareNoNoiseWithEachOtherOrAPicture) {
    const auto scene = openScene("effects/image-light");
    Settings settings;
    test::DirectRenderer renderer(makeEmbreeDevice());
    renderer.load(scene, settings, {});
    const Camera camera = checkedCamera(cameraFrom(startCamera(*scene, 16.0 / 9.0)));
    const FrameRequest request = frameRequest(*scene, camera, settings, uvec2(80, 45), 1);
    const Independence found = measureIndependence(renderer, request, {32, 128, 8.0f}, {});
    EXPECT_LT(std::abs(found.halves), 0.1);
    EXPECT_LT(std::abs(found.withReference), 0.1);
    EXPECT_NEAR(found.byLargerPicture / found.byReference, 1.0, 0.1);
    EXPECT_GT(found.referenceError, 0.0);
    EXPECT_LT(found.referenceError, found.byReference);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
