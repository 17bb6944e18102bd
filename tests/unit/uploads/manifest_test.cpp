#include "server/uploads/manifest.h"

#include "server/base/error.h"
#include "tests/unit/uploads/upload_stream.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

using test::manifestOf;
using testing::HasSubstr;

std::string refusal(const std::string& text, const UploadLimits& limits = {}) {
    try {
        parseManifest(text, limits);
    } catch (const InputError& error) {
        return error.what();
    }
    return "taken";
}

TEST(UploadManifest, TakesAModelWithItsFolders) {
    const UploadManifest manifest = parseManifest(
        manifestOf({{"car/car.gltf", "12345"}, {"car/car.bin", ""}, {"car/maps/Paint 1.PNG", "123"}}, "car/car.gltf"), {});
    EXPECT_EQ(manifest.scene, "car/car.gltf");
    ASSERT_EQ(manifest.files.size(), 3u);
    EXPECT_EQ(manifest.bytes(), 8u);
    EXPECT_TRUE(isSurroundings("a/Sky.HDR") && isSurroundings("sky.exr") && !isSurroundings("hdr.png"));
}

TEST(UploadManifest, NamesWithPathsOutOfTheUploadAreRefused) {
    for (const char* path :
         {"../a.glb", "a/../../b.glb", "/etc/a.glb", "a//b.glb", "./a.glb", "a/./b.glb", ".hidden.glb", "a/.ssh/b.glb",
          "C:\\a.glb", "a\\b.glb", "c:a.glb", "a\nb.glb", "a\tb.glb", "a#b.glb", "", "a.glb/"}) {
        EXPECT_THAT(refusal(manifestOf({{path, "1"}}, path)), HasSubstr("file name")) << path;
    }
    EXPECT_THAT(refusal(manifestOf({{std::string(300, 'a') + ".glb", "1"}}, "a.glb")), HasSubstr("1 to 200 bytes"));
    EXPECT_THAT(refusal(manifestOf({{"1/2/3/4/5/6/7/8/9/a.glb", "1"}}, "a.glb")), HasSubstr("at most 8 folders"));
    const std::string zero("a\0.glb", 6);
    EXPECT_THAT(refusal(manifestOf({{zero, "1"}}, zero)), HasSubstr("no control characters"));
}

TEST(UploadManifest, FilesThatWouldCoverEachOtherAreRefused) {
    EXPECT_THAT(refusal(manifestOf({{"a.glb", "1"}, {"A.GLB", "1"}}, "a.glb")), HasSubstr("each once"));
    EXPECT_THAT(refusal(manifestOf({{"a.glb", "1"}, {"a.glb/b.png", "1"}}, "a.glb")), HasSubstr("another one's folder"));
}

TEST(UploadManifest, WrongKindsOfFilesAreRefusedByName) {
    EXPECT_THAT(refusal(manifestOf({{"a.glb", "1"}, {"run.sh", "1"}}, "a.glb")), HasSubstr("\"run.sh\""));
    EXPECT_THAT(refusal(manifestOf({{"a.zip", "1"}}, "a.zip")), HasSubstr("unpacked first"));
    EXPECT_THAT(refusal(manifestOf({{"a.png", "1"}}, "a.png")), HasSubstr("upload.scene: \"a.png\""));
    EXPECT_THAT(refusal(manifestOf({{"a.glb", "1"}}, "b.glb")), HasSubstr("one of the files"));
}

TEST(UploadManifest, TooManyFilesOrBytesAreRefused) {
    test::Files many;
    for (int i = 0; i < 10'000; i++) many.push_back({std::to_string(i) + ".png", ""});
    EXPECT_THAT(refusal(manifestOf(many, "0.png")), HasSubstr("10000 files; allowed: 1 to 1000"));
    EXPECT_THAT(refusal("{\"scene\":\"\",\"files\":[]}"), HasSubstr("0 files"));
    UploadLimits limits;
    limits.bytes = 1 << 20;
    const auto sized = [](const std::string& bytes) {
        return "{\"scene\":\"a.glb\",\"files\":[{\"path\":\"b.bin\",\"bytes\":9},{\"path\":\"a.glb\",\"bytes\":" + bytes +
               "}]}";
    };
    EXPECT_EQ(refusal(sized("1048567"), limits), "taken");
    EXPECT_THAT(refusal(sized("1048568"), limits), HasSubstr("more than 1 MiB"));
    EXPECT_THAT(refusal(sized("18446744073709551615"), limits), HasSubstr("more than 1 MiB")) << "no sum that runs over";
    EXPECT_THAT(refusal(sized("-1"), limits), HasSubstr("without path or bytes"));
    EXPECT_THAT(refusal(sized("1.5"), limits), HasSubstr("without path or bytes"));
}

TEST(UploadManifest, WhatIsNoListIsRefused) {
    for (const char* text :
         {"", "[]", "{}", "{\"files\":{},\"scene\":\"a\"}", "{\"files\":[1],\"scene\":\"a.glb\"}", "\xff\xfe"})
        EXPECT_THAT(refusal(text), HasSubstr("upload")) << text;
    EXPECT_THAT(refusal(std::string(100'000, '[')), HasSubstr("nested too deep"));
}

}  // namespace
}  // namespace heliograph::TEST_FILE
