#include "server/denoise/oidn.h"

#include "server/base/error.h"

#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

DenoiseJob smallJob() {
    DenoiseJob job;
    job.size = {3, 2};
    job.light.assign(6, vec4(1.0f, 2.0f, 3.0f, -1.0f));
    job.guides.assign(6, vec4(16777215.0f, 1023.0f, 0.5f, 1.0f));
    return job;
}

// The library of tests/unit/denoise/other_oidn.cpp gives light plus albedo plus normal.
TEST(Oidn, IsGivenLightAlbedoAndNormals) {
    const OidnLibrary library(OTHER_OIDN);
    OidnDenoiser denoiser(library);
    DenoiseJob job = smallJob();
    job.guides[5].z = 0.0f;  // nothing there
    denoiser.run(job);
    for (size_t i = 0; i < 5; i++) {
        EXPECT_NEAR(job.light[i].x, 2.0f, 1e-2f);
        EXPECT_NEAR(job.light[i].z, 4.0f, 1e-2f);
        EXPECT_NEAR(job.light[i].y, 3.0f - 1.0f, 1e-2f) << "the normal of that word is (0, -1, 0)";
    }
    EXPECT_EQ(job.light[5], vec4(2.0f, 3.0f, 4.0f, 0.0f)) << "no normal where nothing is";
}

TEST(Oidn, SaysWhatTheLibrarySays) {
    const OidnLibrary library(OTHER_OIDN);
    OidnDenoiser denoiser(library);
    DenoiseJob job = smallJob();
    job.size = {13, 1};  // which that library refuses
    try {
        denoiser.run(job);
        FAIL();
    } catch (const std::runtime_error& error) {
        EXPECT_STREQ(error.what(), "Open Image Denoise: thirteen is unlucky");
    }
}

TEST(Oidn, ALibraryThatIsNotThereOrAnotherIsRefusedInWords) {
    try {
        const OidnLibrary library("libnosuch.so.9");
        FAIL();
    } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("libnosuch.so.9"), std::string::npos) << error.what();
        EXPECT_NE(std::string(error.what()).find("filter"), std::string::npos) << error.what();
    }
    EXPECT_THROW(OidnLibrary("libm.so.6"), InputError) << "a library without its functions";
}

}  // namespace
}  // namespace heliograph::TEST_FILE
