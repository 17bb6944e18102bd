// Pictures that a glTF file names: what cannot be read costs its texture, never the scene.

#include "server/base/error.h"
#include "server/request/effect_rules.h"
#include "server/scene/load/scene_source.h"
#include "tests/unit/scene/scene_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

using namespace testing_files;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;

// One grey pixel (0.2 of 1).
const std::string PNG =
    "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAAAAAA6fptVAAAACklEQVR4nGNoAAAAggCBd81ytgAAAABJRU5ErkJggg==";
const std::string WEBP = "data:image/webp;base64,UklGRhoAAABXRUJQVlA4TA0AAAAvAAAAEAcQERGIiP4HAA==";
const std::string KTX2 = "data:image/ktx2;base64,q0tUWCAyMLsNChoKAAAAAAEAAAA=";

/// A triangle with an emissive texture; `images`, `texture` and `material` are JSON.
std::shared_ptr<const Scene> open(const std::string& images, const std::string& texture, const std::string& extensions = {},
                                  const std::string& material = R"("emissiveTexture":{"index":0})") {
    const ScratchFolder outer;
    outer.write("outside.png", "x");
    const std::string lists =
        extensions.empty() ? "" : R"(,"extensionsUsed":[)" + extensions + R"(],"extensionsRequired":[)" + extensions + "]";
    std::string json = triangleJson(dataUri(triangleBytes()), R"(,"images":[)" + images + R"(],"textures":[)" + texture +
                                                                  R"(],"materials":[{)" + material + "}]" + lists);
    const std::string primitive = R"("attributes":{"POSITION":0})";
    json.replace(json.find(primitive), primitive.size(), primitive + R"(,"material":0)");
    return openScene(outer.write("scene/scene.gltf", json));
}

std::string image(const std::string& uri) { return R"({"uri":")" + uri + R"("})"; }

TEST(GltfPictures, ThoseThatAreMissingOrForbiddenAreTold) {
    for (const std::string uri :
         {"gone.png", "/etc/hostname", "../outside.png", "http://example.org/a.png", "file:///etc/hostname", "%2", "a%00.png",
          "", "data:image/png;base64,###", "data:image/png"}) {
        SCOPED_TRACE(uri);
        const auto scene = open(image(uri), R"({"source":0})");
        EXPECT_EQ(scene->triangleCount(), 1u);
        EXPECT_EQ(scene->surfaceImages, 0u);
        EXPECT_THAT(scene->warnings, Contains(HasSubstr("image 0 is not drawn: ")));
    }
    EXPECT_THAT(open(image("../outside.png"), R"({"source":0})")->warnings,
                Contains(AllOf(HasSubstr("'../outside.png'"), HasSubstr("a relative path inside the scene file's folder"))));
}

TEST(GltfPictures, OcclusionHasAStrengthAndCallsForItsEffect) {
    const std::string material = R"("occlusionTexture":{"index":0,"strength":0.25})";
    const auto scene = open(image(PNG), R"({"source":0})", {}, material);
    const Material& m = scene->materials[scene->triangles[0].w];
    ASSERT_LT(m.occlusionTexture, scene->textures.size());
    EXPECT_EQ(scene->images[scene->textures[m.occlusionTexture].image].format, IMAGE_LINEAR8);
    EXPECT_EQ(m.occlusionStrength, 0.25f);
    EXPECT_TRUE(effectsOf(*scene).has(EFFECT_OCCLUSION_TEXTURES));
    EXPECT_FALSE(effectsOf(*open(image(PNG), R"({"source":0})")).has(EFFECT_OCCLUSION_TEXTURES));
    const auto none = open(image(PNG), R"({"source":0})", {}, R"("occlusionTexture":{"index":0,"strength":0})");
    EXPECT_FALSE(effectsOf(*none).has(EFFECT_OCCLUSION_TEXTURES));
}

TEST(GltfPictures, DataMayBeEscapedBrokenIntoLinesOrNamedInCapitals) {
    const std::string head = "data:image/png;", text = PNG.substr(PNG.find(',') + 1);
    std::string escaped;
    for (const char c : text) escaped += c == '+' ? "%2B" : c == '/' ? "%2f" : c == '=' ? "%3D" : std::string(1, c);
    const std::string lines = text.substr(0, 40) + "\\r\\n " + text.substr(40);  // as JSON escapes them
    for (const std::string& uri : {head + "charset=utf-8;base64," + text, "DATA" + PNG.substr(4), head + "BASE64," + text,
                                   head + "base64," + escaped, head + "base64," + lines}) {
        SCOPED_TRACE(uri);
        const auto scene = open(image(uri), R"({"source":0})");
        ASSERT_EQ(scene->surfaceImages, 1u);
        EXPECT_EQ(scene->texels, open(image(PNG), R"({"source":0})")->texels);
    }
}

TEST(GltfPictures, WebpIsReadWhereThereIsNothingElse) {
    const std::string webp = R"({"extensions":{"EXT_texture_webp":{"source":1}}})",
                      both = R"({"source":0,"extensions":{"EXT_texture_webp":{"source":1}}})";
    const std::string images = image(PNG) + "," + image(WEBP), name = R"("EXT_texture_webp")";
    const auto alone = open(images, webp, name), beside = open(images, both, name);
    ASSERT_EQ(alone->surfaceImages, 1u);
    ASSERT_EQ(beside->surfaceImages, 1u);
    EXPECT_THAT(alone->warnings, ::testing::Not(Contains(HasSubstr("not drawn: "))));
    EXPECT_NE(alone->contentHash, beside->contentHash);
    EXPECT_EQ(open(images, R"({"source":0})")->contentHash, beside->contentHash);
}

TEST(GltfPictures, BasisTexturesAreRefusedAlone) {
    const std::string name = R"("KHR_texture_basisu")";
    const auto scene = open(image(KTX2), R"({"extensions":{"KHR_texture_basisu":{"source":0}}})", name);
    EXPECT_EQ(scene->triangleCount(), 1u);
    EXPECT_THAT(scene->warnings, Contains(AllOf(HasSubstr("image 0 is not drawn: "), HasSubstr("KTX2"))));
    const auto beside =
        open(image(KTX2) + "," + image(PNG), R"({"source":1,"extensions":{"KHR_texture_basisu":{"source":0}}})", name);
    EXPECT_EQ(beside->surfaceImages, 1u);
    EXPECT_THROW(open(image(KTX2), R"({"extensions":{"KHR_texture_basisu":{"source":7}}})", name), InputError);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
