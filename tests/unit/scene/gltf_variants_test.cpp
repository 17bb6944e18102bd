// KHR_materials_variants: the look that is asked for is drawn, and the file's extensions are listed.

#include "server/base/error.h"
#include "server/scene/load/gltf_extensions.h"
#include "server/scene/load/gltf_variants.h"
#include "server/scene/load/scene_source.h"
#include "tests/unit/scene/scene_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

namespace heliograph::TEST_FILE {
namespace {

using namespace testing_files;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Two triangles: the first is grey, red in "beach" and "night", see-through in "street"; the second is always grey.
std::string shoe(const std::string& mappings = R"([{"material":1,"variants":[0,2]},{"material":2,"variants":[1]}])") {
    std::string json = triangleJson(
        dataUri(triangleBytes()),
        R"(,"materials":[{"name":"grey"},{"name":"red"},{"name":"pane","alphaMode":"BLEND",)"
        R"("pbrMetallicRoughness":{"baseColorFactor":[1,1,1,0.5]}}],"extensionsUsed":["KHR_materials_variants"],)"
        R"("extensions":{"KHR_materials_variants":{"variants":[{"name":"beach"},{"name":"street"},{"name":"night"}]}})");
    const std::string primitive = R"({"attributes":{"POSITION":0}})";
    return json.replace(json.find(primitive), primitive.size(),
                        R"({"attributes":{"POSITION":0},"material":0,"extensions":{"KHR_materials_variants":{"mappings":)" +
                            mappings + R"(}}},{"attributes":{"POSITION":0},"material":0})");
}

/// Names of the materials that some triangle has.
std::vector<std::string> worn(const Scene& scene) {
    std::vector<std::string> names;
    for (const uvec4& triangle : scene.triangles) names.push_back(scene.materialNames[triangle.w]);
    std::ranges::sort(names);
    return names;
}

std::string faultOf(const std::string& name) {
    try {
        openScene(name);
    } catch (const InputError& error) {
        return error.what();
    }
    return "none";
}

struct VariantFile : testing::Test {
    const ScratchFolder folder;
    const std::string path = folder.write("shoe.gltf", shoe());
};

TEST_F(VariantFile, TheOneThatIsAskedForIsWorn) {
    const auto own = openScene(path);
    EXPECT_THAT(own->variants.names, ElementsAre("beach", "street", "night"));
    EXPECT_FALSE(own->variants.chosen);
    EXPECT_THAT(worn(*own), ElementsAre("grey", "grey"));
    for (const char* name : {"#beach", "#night", "#0", "#2"}) {
        SCOPED_TRACE(name);
        const auto scene = openScene(path + name);
        EXPECT_THAT(worn(*scene), ElementsAre("grey", "red"));
        EXPECT_EQ(scene->variants.names[scene->variants.chosen.value()], name[1] == 'b' || name[1] == '0' ? "beach" : "night");
    }
    EXPECT_THAT(worn(*openScene(path + "#street")), ElementsAre("grey", "pane"));
    EXPECT_THAT(worn(*openScene(path + "#")), ElementsAre("grey", "grey"));
}

TEST_F(VariantFile, OneThatIsNotThereIsRefusedWithTheOthersNames) {
    EXPECT_THAT(faultOf(path + "#moon"), HasSubstr("variant: 'moon'; allowed: 'beach', 'street', 'night', or 0 to 2"));
    EXPECT_THAT(faultOf(path + "#3"), HasSubstr("variant: '3'"));
    const std::string plain = folder.write("plain.gltf", triangleJson(dataUri(triangleBytes())));
    EXPECT_THAT(faultOf(plain + "#beach"), HasSubstr("the scene has no material variants"));
    EXPECT_THAT(faultOf("courtyard#beach"), HasSubstr("only glTF files have variants"));
    EXPECT_THAT(faultOf(folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n") + "#x"), HasSubstr("only glTF files"));
}

TEST_F(VariantFile, MappingsToWhatIsNotThereRefuseTheFile) {
    EXPECT_THAT(faultOf(folder.write("a.gltf", shoe(R"([{"material":9,"variants":[0]}])"))),
                HasSubstr("mappings/0/material: 9; allowed: an index below 3"));
    EXPECT_THAT(faultOf(folder.write("b.gltf", shoe(R"([{"material":1,"variants":[3]}])"))),
                HasSubstr("mappings/0/variants/0: 3; allowed: an index below 3"));
    EXPECT_THAT(faultOf(folder.write("c.gltf", shoe(R"([{"variants":[0]}])"))), HasSubstr("'material' is missing"));
}

TEST(SceneNames, AFileOfThatNameComesBeforeAVariant) {
    const auto known = [](const std::string& name) { return name == "a" || name == "a#b"; };
    const auto parts = [&](const std::string& text) {
        const SceneName name = sceneNameOf(text, known);
        return name.name + "|" + name.variant;
    };
    EXPECT_EQ(parts("a"), "a|");
    EXPECT_EQ(parts("a#c"), "a|c");
    EXPECT_EQ(parts("a#c#d"), "a|c#d");
    EXPECT_EQ(parts("a#b"), "a#b|");
    EXPECT_EQ(parts("z#b"), "z#b|");
}

TEST(GltfExtensions, EachIsListedWithWhatBecomesOfIt) {
    const ScratchFolder folder;
    const std::string used = R"(,"extensionsUsed":["KHR_texture_transform","KHR_materials_volume_scatter","MINE_own"])";
    const auto scene = openScene(folder.write("a.gltf", triangleJson(dataUri(triangleBytes()), used)));
    ASSERT_EQ(scene->extensions.size(), 3u);
    EXPECT_TRUE(scene->extensions[0].read);
    EXPECT_FALSE(scene->extensions[1].read);
    EXPECT_EQ(scene->extensions[1].note, whyNotRead("KHR_materials_volume_scatter"));
    EXPECT_FALSE(scene->extensions[2].read);
    EXPECT_THAT(scene->warnings,
                ::testing::Contains("extension 'KHR_materials_volume_scatter' is not read: bodies absorb and do not scatter"));
    const std::string required =
        R"(,"extensionsUsed":["KHR_materials_volume_scatter"],"extensionsRequired":["KHR_materials_volume_scatter"])";
    EXPECT_THAT(faultOf(folder.write("b.gltf", triangleJson(dataUri(triangleBytes()), required))),
                HasSubstr("extension 'KHR_materials_volume_scatter', which is not read: bodies absorb and do not scatter; "
                          "allowed: KHR_lights"));
    EXPECT_THAT(openScene("cornell")->extensions, IsEmpty());
}

}  // namespace
}  // namespace heliograph::TEST_FILE
