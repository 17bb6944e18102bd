#include "server/base/error.h"
#include "server/scene/load/gltf_mesh.h"
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

std::shared_ptr<const Scene> openText(const std::string& json) {
    const ScratchFolder folder;
    return openScene(folder.write("scene.gltf", json));
}

/// The message with which a file is refused; fails if it is not.
std::string refusal(const std::string& content, const std::string& name = "scene.gltf") {
    const ScratchFolder folder;
    try {
        openScene(folder.write(name, content));
    } catch (const InputError& error) {
        return error.what();
    }
    ADD_FAILURE() << "not refused: " << content.substr(0, 400);
    return {};
}

vec3 positionOf(const Scene& scene, uint32_t vertex) { return vec3(scene.positions[vertex]); }

// An accessor without a buffer view is all zero but for what is sparse in it: for indices, too.
TEST(GltfLoader, IndicesMayBeSparseAlone) {
    const ScratchFolder folder;
    const std::string bytes = triangleBytes() + bytesOf<uint16_t>({1, 2, 1, 2});
    std::string json = triangleJson(dataUri(bytes));
    const auto put = [&](const std::string& old, const std::string& text) { json.replace(json.find(old), old.size(), text); };
    put(R"("attributes":{"POSITION":0})", R"("attributes":{"POSITION":0},"indices":1)");
    put(R"("max":[1,1,0]})", R"("max":[1,1,0]},{"componentType":5123,"count":3,"type":"SCALAR","sparse":{"count":2,)"
                             R"("indices":{"bufferView":1,"componentType":5123},"values":{"bufferView":2}}})");
    put(R"("byteLength":36}],"buffers")", R"("byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":4},)"
                                          R"({"buffer":0,"byteOffset":40,"byteLength":4}],"buffers")");
    put(R"("byteLength":36}])", R"("byteLength":44}])");
    const auto scene = openScene(folder.write("a.gltf", json));
    ASSERT_EQ(scene->triangleCount(), 1u);
    EXPECT_EQ(scene->bounds.high, vec3(1.0f, 1.0f, 0.0f));
}

// Whether few or most of the vertices are used: they come in their order, once, and corners name the same ones as before.
TEST(GltfMesh, TakesTheVerticesThatAreUsed) {
    for (const size_t count : {size_t(9), size_t(40), size_t(41), size_t(100'000)}) {
        const std::vector<uint32_t> before{7, 2, NO_INDEX, 2, 8, 7, 0, NO_INDEX, 7, 3};
        std::vector<uint32_t> corners = before;
        const std::vector<uint32_t> vertices = takeUsed(corners, count);
        EXPECT_EQ(vertices, (std::vector<uint32_t>{0, 2, 3, 7, 8})) << count;
        for (size_t i = 0; i < before.size(); i++)
            EXPECT_EQ(corners[i] == NO_INDEX ? NO_INDEX : vertices.at(corners[i]), before[i]) << count << ", " << i;
    }
    std::vector<uint32_t> none;
    EXPECT_TRUE(takeUsed(none, 0).empty());
    std::vector<uint32_t> bad{NO_INDEX, NO_INDEX, NO_INDEX};
    EXPECT_TRUE(takeUsed(bad, 2).empty());
    EXPECT_EQ(bad[0], NO_INDEX);
}

TEST(GltfLoader, ReadsTextAndBinary) {
    const ScratchFolder folder;
    const auto text = openScene(folder.write("a.gltf", triangleJson(dataUri(triangleBytes()))));
    const auto binary = openScene(folder.write("b.glb", glb(triangleJson(""), triangleBytes())));
    folder.write("data/tri angle.bin", triangleBytes());
    const auto beside = openScene(folder.write("c.gltf", triangleJson("data/tri%20angle.bin")));
    EXPECT_EQ(text->triangleCount(), 1u);
    EXPECT_EQ(text->contentHash, binary->contentHash);
    EXPECT_EQ(text->contentHash, beside->contentHash);
    EXPECT_EQ(text->bounds.high, vec3(1, 1, 0));
}

// KHR_lights_punctual has points alone; an extent is an extra of ours.
TEST(GltfLoader, ReadsTheRadiusOfALightFromItsExtras) {
    const auto lightOf = [](const std::string& extras) {
        std::string json = triangleJson(
            dataUri(triangleBytes()),
            R"(,"extensionsUsed":["KHR_lights_punctual"],"extensions":{"KHR_lights_punctual":{"lights":[{"type":"point","intensity":5)" +
                extras + "}]}}");
        const std::string node = R"("nodes":[{"mesh":0}])";
        json.replace(json.find(node), node.size(), R"("nodes":[{"mesh":0,"extensions":{"KHR_lights_punctual":{"light":0}}}])");
        return openText(json)->lights.at(0);
    };
    EXPECT_EQ(lightOf("").radius, 0.0f);
    EXPECT_EQ(lightOf(R"(,"extras":{"radius":0.25})").radius, 0.25f);
    EXPECT_EQ(lightOf(R"(,"extras":{"radius":-1})").radius, 0.0f);
    EXPECT_EQ(lightOf(R"(,"extras":{"radius":"wide"})").radius, 0.0f);
    EXPECT_EQ(lightOf(R"(,"extras":"wide")").radius, 0.0f);
}

TEST(GltfLoader, RemembersWhatTheFileWouldHaveMoving) {
    const std::string sampler = R"("samplers":[{"input":0,"output":0}],"channels":[{"sampler":0,"target":{"path":"scale"}}]})";
    const std::string animations = R"(,"animations":[{"name":"walk",)" + sampler + ",{" + sampler + "]";
    std::string json = triangleJson(dataUri(triangleBytes()), animations + R"(,"skins":[{"joints":[0]}])");
    const auto change = [&json](const std::string& from, const std::string& to) {
        json.replace(json.find(from), from.size(), to);
    };
    change(R"("nodes":[{"mesh":0}])", R"("nodes":[{"mesh":0,"skin":0}])");
    change(R"({"POSITION":0})", R"({"POSITION":0},"targets":[{"POSITION":0}])");
    const auto scene = openText(json);
    EXPECT_EQ(scene->atRest.animations, (std::vector<std::string>{"walk", ""}));
    EXPECT_EQ(scene->atRest.skinnedMeshes, 1u);
    EXPECT_EQ(scene->atRest.morphedMeshes, 1u);
    json.replace(json.find(R"("walk")"), 6, "5");
    EXPECT_THAT(refusal(json), HasSubstr("/animations/0/name: 5; allowed: "));
    const auto still = openText(triangleJson(dataUri(triangleBytes())));
    EXPECT_TRUE(still->atRest.animations.empty());
    EXPECT_EQ(still->atRest.skinnedMeshes + still->atRest.morphedMeshes, 0u);
}

TEST(GltfLoader, NeverLeavesItsFolder) {
    const ScratchFolder outer;
    outer.write("secret.bin", triangleBytes());
    outer.write("scene/inside.bin", triangleBytes());
    fs::create_symlink(outer.path() / "secret.bin", outer.path() / "scene/link.bin");
    fs::create_symlink(outer.path(), outer.path() / "scene/up");
    for (const std::string uri :
         {"../secret.bin", "%2e%2e/secret.bin", "a/../../secret.bin", "./../secret.bin", "..\\\\secret.bin", "link.bin",
          "up/secret.bin", "file:///etc/hostname", "http://127.0.0.1/x.bin", "/etc/hostname", "//etc/hostname",
          "%2fetc/hostname", "C:/x.bin", "inside.bin%00.png", "", "%2", "~/x.bin", "."}) {
        SCOPED_TRACE(uri);
        const std::string file = outer.write("scene/scene.gltf", triangleJson(uri));
        try {
            const auto scene = openScene(file);
            ADD_FAILURE() << "opened";
        } catch (const InputError& error) {
            EXPECT_THAT(error.what(), ::testing::AnyOf(HasSubstr("/buffers/0/uri"), HasSubstr("no regular file"),
                                                       HasSubstr("/bufferViews/0")));
        }
        const std::string image =
            R"(,"images":[{"uri":")" + uri + R"("}],"textures":[{"source":0}],"materials":[{"emissiveTexture":{"index":0}}])";
        const std::string withImage = outer.write("scene/image.gltf", triangleJson("inside.bin", image));
        try {
            EXPECT_EQ(openScene(withImage)->surfaceImages, 0u);
        } catch (const InputError& error) {
            EXPECT_THAT(error.what(), ::testing::AnyOf(HasSubstr("/images/0/uri"), HasSubstr("no regular file")));
        }
    }
    EXPECT_EQ(openScene(outer.write("scene/scene.gltf", triangleJson("inside.bin")))->triangleCount(), 1u);
}

TEST(GltfLoader, RefusesUnknownRequiredExtensionsAndWarnsOfUsedOnes) {
    const std::string uri = dataUri(triangleBytes());
    EXPECT_THAT(refusal(triangleJson(uri, R"(,"extensionsUsed":["ABC_x"],"extensionsRequired":["ABC_x"])")),
                AllOf(HasSubstr("/extensionsRequired"), HasSubstr("ABC_x"), HasSubstr("KHR_lights_punctual")));
    EXPECT_THAT(openText(triangleJson(uri, R"(,"extensionsUsed":["ABC_x"])"))->warnings, Contains(HasSubstr("ABC_x")));
}

TEST(GltfLoader, RefusesWhatPointsOutside) {
    const std::string uri = dataUri(triangleBytes());
    const auto with = [&](const std::string& from, const std::string& to) {
        std::string json = triangleJson(uri);
        const size_t at = json.find(from);
        EXPECT_NE(at, std::string::npos) << from;
        return refusal(json.replace(at, from.size(), to));
    };
    EXPECT_THAT(with(R"("count":3)", R"("count":4)"), HasSubstr("/accessors/0"));
    EXPECT_THAT(with(R"("count":3)", R"("count":9007199254740991)"), HasSubstr("/accessors/0"));
    EXPECT_THAT(with(R"("count":3)", R"("count":-3)"), HasSubstr("/accessors/0/count"));
    EXPECT_THAT(with(R"("count":3)", R"("count":0)"), HasSubstr("/accessors/0/count"));
    EXPECT_THAT(with(R"("byteLength":36}]})", R"("byteLength":37}]})"), HasSubstr("/buffers/0/byteLength"));
    EXPECT_THAT(with(R"("buffer":0,"byteLength":36)", R"("buffer":0,"byteLength":36,"byteOffset":4)"),
                HasSubstr("/bufferViews/0"));
    EXPECT_THAT(with(R"("buffer":0,"byteLength":36)", R"("buffer":0,"byteLength":36,"byteOffset":9007199254740991)"),
                HasSubstr("/bufferViews/0"));
    EXPECT_THAT(with(R"("buffer":0)", R"("buffer":1)"), HasSubstr("/bufferViews/0/buffer"));
    EXPECT_THAT(with(R"("mesh":0)", R"("mesh":1)"), HasSubstr("/nodes/0/mesh"));
    EXPECT_THAT(with(R"("POSITION":0)", R"("POSITION":1e300)"), HasSubstr("POSITION"));
    EXPECT_THAT(with(R"("POSITION":0)", R"("POSITION":-1)"), HasSubstr("POSITION"));
    EXPECT_THAT(with(R"("componentType":5126)", R"("componentType":5124)"), HasSubstr("componentType"));
    EXPECT_THAT(with(R"("nodes":[0])", R"("nodes":[0,0])"), HasSubstr("/scenes/0/nodes"));
    EXPECT_THAT(with(R"({"mesh":0})", R"({"mesh":0,"children":[0]})"), HasSubstr("/nodes/0"));
    EXPECT_THAT(with("VEC3", "VEC2"), HasSubstr("POSITION"));
    EXPECT_THAT(with("VEC3", "VEC9"), HasSubstr("VEC9"));
    EXPECT_THAT(with(R"("version":"2.0")", R"("version":"1.0")"), HasSubstr("/asset/version"));
}

TEST(GltfLoader, RefusesDeepJsonAndMissingFiles) {
    EXPECT_THAT(refusal(std::string(100000, '[')), HasSubstr("nested"));
    EXPECT_THAT(refusal(R"({"asset":{"version":"2.0"},"extras":)" + std::string(5000, '[') + std::string(5000, ']') + "}"),
                HasSubstr("nested"));
    EXPECT_THAT(refusal(""), HasSubstr("JSON"));
    EXPECT_THAT(refusal(triangleJson("none.bin")), HasSubstr("does not exist"));
    EXPECT_THAT(refusal(std::string("glTF\2\0\0\0", 8), "a.glb"), HasSubstr("header"));
    EXPECT_THROW(openScene("/nonexistent/scene.gltf"), InputError);
    EXPECT_THROW(openScene("no-such-scene"), InputError);
    EXPECT_THROW(openScene(""), InputError);
    EXPECT_THROW(openScene(std::string("a\0b", 3)), InputError);
    EXPECT_THROW(openScene(fs::temp_directory_path().string()), InputError);
    try {
        openScene("no-such-scene");
    } catch (const InputError& error) {
        EXPECT_THAT(error.what(), AllOf(HasSubstr("no-such-scene"), HasSubstr("courtyard")));
    }
}

TEST(GltfLoader, RefusesBombsOfSmallFiles) {
    // A billion vertices of zeros, without a byte behind them.
    EXPECT_THAT(refusal(R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
                        R"("meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],)"
                        R"("accessors":[{"componentType":5126,"count":1000000000,"type":"VEC3"}]})"),
                HasSubstr("for a file of this size"));
    // Many primitives that read the same bytes again and again.
    std::string primitives;
    for (int i = 0; i < 3000; i++) primitives += std::string(i ? "," : "") + R"({"attributes":{"POSITION":0},"indices":1})";
    EXPECT_THAT(
        refusal(
            R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[)" +
            primitives +
            R"(]}],"accessors":[{"componentType":5126,"count":3,"type":"VEC3"},{"bufferView":0,"componentType":5121,"count":30000,"type":"SCALAR"}],)"
            R"("bufferViews":[{"buffer":0,"byteLength":30000}],"buffers":[{"byteLength":30000,"uri":")" +
            dataUri(std::string(30000, '\0')) + R"("}]})"),
        HasSubstr("for a file of this size"));
}

TEST(GltfLoader, RefusesEveryTruncation) {
    const ScratchFolder folder;
    const std::string whole = glb(triangleJson(""), triangleBytes());
    for (size_t length = 0; length < whole.size(); length++) {
        const std::string file = folder.write("cut.glb", whole.substr(0, length));
        EXPECT_THROW(openScene(file), InputError) << length << " of " << whole.size() << " bytes";
    }
}

/// A mesh with explicit primitive JSON over one buffer.
std::string meshJson(const std::string& primitive, const std::string& accessors, const std::string& views,
                     const std::string& bytes, const std::string& extra = {}) {
    return R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[)" + primitive +
           R"(]}],"accessors":[)" + accessors + R"(],"bufferViews":[)" + views + R"(],"buffers":[{"byteLength":)" +
           std::to_string(bytes.size()) + R"(,"uri":")" + dataUri(bytes) + R"("}])" + extra + "}";
}

TEST(GltfLoader, AssemblesStripsAndFans) {
    const std::string bytes = bytesOf<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0});
    const std::string accessor = R"({"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,0]})";
    const std::string view = R"({"buffer":0,"byteLength":48})";
    for (const int mode : {5, 6}) {
        const auto scene =
            openText(meshJson(R"({"attributes":{"POSITION":0},"mode":)" + std::to_string(mode) + "}", accessor, view, bytes));
        ASSERT_EQ(scene->triangleCount(), 2u);
        const uvec4 first = scene->triangles[0], second = scene->triangles[1];
        EXPECT_EQ(positionOf(*scene, first.x), vec3(0, 0, 0));
        EXPECT_EQ(positionOf(*scene, first.y), vec3(1, 0, 0));
        EXPECT_EQ(positionOf(*scene, first.z), vec3(0, 1, 0));
        EXPECT_EQ(positionOf(*scene, second.x), mode == 5 ? vec3(1, 0, 0) : vec3(0, 0, 0));
        EXPECT_EQ(positionOf(*scene, second.y), mode == 5 ? vec3(1, 1, 0) : vec3(0, 1, 0));
        EXPECT_EQ(positionOf(*scene, second.z), mode == 5 ? vec3(0, 1, 0) : vec3(1, 1, 0));
    }
    EXPECT_THAT(openText(meshJson(R"({"attributes":{"POSITION":0},"mode":1})", accessor, view, bytes))->warnings,
                Contains(HasSubstr("lines are not drawn")));
}

TEST(GltfLoader, ReadsNormalizedIntegersStridesAndSparseValues) {
    // Positions as normalised shorts 8 bytes apart, colours as bytes, one position replaced by a sparse value.
    const std::string shorts = bytesOf<int16_t>({0, 0, 0, 0, 32767, 0, 0, 0, 0, -32768, 0, 0});
    const std::string colors = bytesOf<uint8_t>({255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 51});
    const std::string sparse = bytesOf<uint8_t>({2, 0, 0, 0}) + bytesOf<int16_t>({0, 32767, 0, 0});
    const std::string accessors =
        R"({"bufferView":0,"componentType":5122,"normalized":true,"count":3,"type":"VEC3","min":[0,-32768,0],"max":[32767,0,0],)"
        R"("sparse":{"count":1,"indices":{"bufferView":2,"componentType":5121},"values":{"bufferView":2,"byteOffset":4}}},)"
        R"({"bufferView":1,"componentType":5121,"normalized":true,"count":3,"type":"VEC4"})";
    const std::string views =
        R"({"buffer":0,"byteLength":24,"byteStride":8},{"buffer":0,"byteOffset":24,"byteLength":12},{"buffer":0,"byteOffset":36,"byteLength":12})";
    const auto scene =
        openText(meshJson(R"({"attributes":{"POSITION":0,"COLOR_0":1}})", accessors, views, shorts + colors + sparse));
    ASSERT_EQ(scene->triangleCount(), 1u);
    EXPECT_EQ(positionOf(*scene, 1), vec3(1, 0, 0));
    EXPECT_EQ(positionOf(*scene, 2), vec3(0, 1, 0));
    EXPECT_EQ(scene->attributes[0].color, 0xff0000ffu);
    EXPECT_EQ(scene->attributes[2].color, 0x33ff0000u);
    EXPECT_THAT(scene->warnings, Contains(HasSubstr("min or max")));  // the sparse value moved the bounds
}

TEST(GltfLoader, ComposesDeepHierarchiesInDouble) {
    std::string nodes;
    constexpr int DEPTH = 900;
    for (int i = 0; i < DEPTH; i++) nodes += R"({"translation":[1,0,0],"children":[)" + std::to_string(i + 1) + "]},";
    std::string json = triangleJson(dataUri(triangleBytes()));
    const std::string node = R"("nodes":[{"mesh":0}])";
    json.replace(json.find(node), node.size(),
                 R"("nodes":[)" + nodes + R"({"mesh":0,"scale":[1,1,-1],"rotation":[0,0,0.70710678,0.70710678]}])");
    const auto scene = openText(json);
    EXPECT_NEAR(scene->bounds.low.x, DEPTH - 1.0f, 1e-3f);
    EXPECT_NEAR(scene->bounds.high.x, DEPTH, 1e-3f);
    // Mirrored along z: the front still looks along the turned +z, now -z.
    const uvec4 t = scene->triangles[0];
    const vec3 normal =
        glm::cross(positionOf(*scene, t.y) - positionOf(*scene, t.x), positionOf(*scene, t.z) - positionOf(*scene, t.x));
    EXPECT_LT(normal.z, 0.0f);
    EXPECT_LT(scene->attributes[0].normal.z, -0.999f);
}

TEST(GltfLoader, ConvertsMaterialExtensions) {
    const std::string materials =
        R"(,"extensionsUsed":["KHR_materials_volume","KHR_materials_transmission","KHR_materials_ior","KHR_materials_emissive_strength"],"materials":[)"
        R"({"name":"glass","pbrMetallicRoughness":{"metallicFactor":0},"alphaMode":"BLEND","emissiveFactor":[1,0.5,0],"extensions":{)"
        R"("KHR_materials_transmission":{"transmissionFactor":0.75},"KHR_materials_ior":{"ior":1.33},"KHR_materials_emissive_strength":{"emissiveStrength":4},)"
        R"("KHR_materials_volume":{"thicknessFactor":1,"attenuationDistance":2,"attenuationColor":[0.25,1,0]}}},)"
        R"({"name":"mirror","extensions":{"KHR_materials_ior":{"ior":0}}}])";
    const auto scene = openText(triangleJson(dataUri(triangleBytes()), materials));
    const Material& glass = scene->materials.at(1);
    EXPECT_EQ(glass.flags, MATERIAL_VOLUME | MATERIAL_ALPHA_BLEND);
    EXPECT_FLOAT_EQ(glass.transmission, 0.75f);
    EXPECT_FLOAT_EQ(glass.ior, 1.33f);
    EXPECT_NEAR(glass.absorption.x, -std::log(0.25) / 2, 1e-6);
    EXPECT_EQ(glass.absorption.y, 0.0f);
    EXPECT_TRUE(std::isfinite(glass.absorption.z));
    EXPECT_EQ(vec3(glass.emission), vec3(4, 2, 0));
    EXPECT_EQ(scene->materials.at(2).ior, 0.0f);  // kept: the kernel knows it as "reflects everything"
    EXPECT_EQ(scene->materialNames.at(1), "glass");
}

TEST(GltfLoader, ReadsTextureTransforms) {
    const ScratchFolder folder;
    const std::string json = triangleJson(
        dataUri(triangleBytes()),
        R"(,"extensionsUsed":["KHR_texture_transform"],"images":[{"uri":"t.png"}],"textures":[{"source":0,"sampler":0}],"samplers":[{"magFilter":9728,"wrapS":33071,"wrapT":33648}],)"
        R"("materials":[{"emissiveTexture":{"index":0,"extensions":{"KHR_texture_transform":{"offset":[0.5,0.25],"rotation":1.5707963267948966,"scale":[2,3],"texCoord":1}}}}])");
    // A grey PNG of one pixel.
    const unsigned char png[] = {0x89, 'P',  'N',  'G',  13,   10,  26,   10,   0,    0,    0,    13,   'I',  'H',
                                 'D',  'R',  0,    0,    0,    1,   0,    0,    0,    1,    8,    0,    0,    0,
                                 0,    0x3a, 0x7e, 0x9b, 0x55, 0,   0,    0,    10,   'I',  'D',  'A',  'T',  0x78,
                                 0x9c, 0x63, 0x68, 0,    0,    0,   0x82, 0,    0x81, 0x77, 0xcd, 0x72, 0xb6, 0,
                                 0,    0,    0,    'I',  'E',  'N', 'D',  0xae, 0x42, 0x60, 0x82};
    folder.write("t.png", std::string_view(reinterpret_cast<const char*>(png), sizeof png));
    const auto scene = openScene(folder.write("scene.gltf", json));
    ASSERT_EQ(scene->textures.size(), 1u) << ::testing::PrintToString(scene->warnings);
    const TextureSlot& slot = scene->textures[0];
    EXPECT_EQ(slot.uvSet, 1u);
    EXPECT_EQ(slot.nearest, 1u);
    EXPECT_EQ(slot.wrapU, WRAP_CLAMP);
    EXPECT_EQ(slot.wrapV, WRAP_MIRROR);
    // A quarter turn: u' = 3 v + 0.5, v' = -2 u + 0.25.
    EXPECT_NEAR(slot.transform.x, 0.0f, 1e-6f);
    EXPECT_NEAR(slot.transform.y, 3.0f, 1e-6f);
    EXPECT_NEAR(slot.transform.z, -2.0f, 1e-6f);
    EXPECT_NEAR(slot.transform.w, 0.0f, 1e-6f);
    EXPECT_EQ(slot.offset, vec2(0.5f, 0.25f));
}

TEST(GltfLoader, PassesOnWhatProgressThrows) {
    const ScratchFolder folder;
    const std::string file = folder.write("a.gltf", triangleJson(dataUri(triangleBytes())));
    struct Abandoned {};
    EXPECT_THROW(openScene(file, {}, [](const std::string&, double) { throw Abandoned(); }), Abandoned);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
