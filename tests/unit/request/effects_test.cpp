#include "server/request/effect_rules.h"

#include "tests/support/test_scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

namespace heliograph::TEST_FILE {
namespace {

using test::litBuilder;
using test::square;
using test::squareScene;

EffectReason reasonFor(const Scene& scene, uint64_t effect) {
    for (const EffectReason& reason : explainEffects(scene)) {
        if (reason.bit == effect) return reason;
    }
    ADD_FAILURE() << "no row for the effect";
    return {};
}

bool calls(const std::function<void(Material&)>& change, uint64_t effect) {
    return reasonFor(*squareScene(change), effect).calledFor;
}

ImageData plainImage(uint8_t red, uint8_t green, uint8_t blue, uint8_t alpha = 255) {
    ImageData image;
    image.width = image.height = 2;
    image.srgb = false;
    for (int i = 0; i < 4; i++) image.rgba8.insert(image.rgba8.end(), {red, green, blue, alpha});
    image.name = "plain";
    return image;
}

TEST(EffectSet, APlainLitSquareCallsForShadowsAndOcclusionAlone) {
    EXPECT_EQ(effectNames(effectsOf(*squareScene())),
              (std::vector<std::string>{"shadows", "ambientOcclusion", "depthOfField", "fog", "glossyReflections", "motionBlur",
                                        "indirectLight", "path", "sun", "ground"}))
        << "the last ones are the viewer's choice";
}

TEST(EffectSet, WhatTheViewerChoosesIsNotCalledFor) {
    const auto scene = squareScene();
    for (uint64_t bit :
         {EFFECT_AMBIENT_OCCLUSION, EFFECT_DEPTH_OF_FIELD, EFFECT_FOG, EFFECT_MOTION_BLUR, EFFECT_INDIRECT_LIGHT}) {
        const EffectReason reason = reasonFor(*scene, bit);
        EXPECT_FALSE(reason.calledFor) << reason.name;
        EXPECT_TRUE(reason.choice && reason.possible()) << reason.name;
    }
    EXPECT_TRUE(reasonFor(*scene, EFFECT_SHADOWS).calledFor);
}

TEST(EffectSet, OneRowPerEffectOfTheTableInItsOrder) {
    std::vector<EffectReason> reasons = explainEffects(*squareScene());
    std::vector<std::string> names;
    uint64_t all = 0;
    size_t simulated = 0;
    for (const EffectReason& reason : reasons) {
        if (reason.simulated) {
            simulated++;
            names.push_back(reason.name);
        }
        all |= reason.bit;
        EXPECT_FALSE(reason.because.empty()) << reason.name;
    }
    EXPECT_EQ(names, effectNames({all}));
    EXPECT_EQ(all + 1, uint64_t(1) << simulated) << "bits are dense";
}

TEST(EffectSet, WhatAFileWouldHaveMovingIsToldAndCostsNothing) {
    SceneBuilder builder = litBuilder();
    builder.addInstance(builder.addMesh(square()), mat4(1.0f));
    builder.setAtRest({{"walk", "", "run"}, 2, 0});
    const auto scene = builder.finish();
    std::map<std::string, EffectReason> rows;
    for (const EffectReason& reason : explainEffects(*scene)) rows[reason.name] = reason;
    EXPECT_EQ(rows.at("animation").because, "3 animations (walk, run); shown at rest");
    EXPECT_EQ(rows.at("skinning").because, "2 skinned meshes; shown at rest");
    EXPECT_EQ(rows.at("morphing").because, "no morph targets in the file");
    EXPECT_TRUE(rows.at("animation").calledFor && rows.at("skinning").calledFor && !rows.at("morphing").calledFor);
    for (const char* name : {"animation", "skinning", "morphing"}) {
        EXPECT_FALSE(rows.at(name).simulated);
        EXPECT_EQ(rows.at(name).bit, 0u);
    }
    EXPECT_EQ(effectsOf(*scene), effectsOf(*squareScene()));
}

TEST(EffectSet, ReflectionsComeFromSmoothMirrorsAndGlass) {
    EXPECT_FALSE(calls(
        [](Material& m) {
            m.metallic = 0.0f;
            m.roughness = 1.0f;
        },
        EFFECT_REFLECTIONS));
    EXPECT_TRUE(calls(
        [](Material& m) {
            m.metallic = 1.0f;
            m.roughness = 0.1f;
        },
        EFFECT_REFLECTIONS));
    EXPECT_FALSE(calls(
        [](Material& m) {
            m.metallic = 1.0f;
            m.roughness = 0.7f;
        },
        EFFECT_REFLECTIONS));
    EXPECT_TRUE(calls(
        [](Material& m) {
            m.metallic = 0.0f;
            m.roughness = 0.1f;
            m.ior = 1.5f;
        },
        EFFECT_REFLECTIONS))
        << "a polished surface";
    EXPECT_FALSE(calls(
        [](Material& m) {
            m.metallic = 0.0f;
            m.roughness = 0.1f;
            m.ior = 1.0f;
        },
        EFFECT_REFLECTIONS));
    EXPECT_TRUE(calls(
        [](Material& m) {
            m.roughness = 1.0f;
            m.transmission = 0.5f;
        },
        EFFECT_REFLECTIONS));
    EXPECT_TRUE(calls(
        [](Material& m) {
            m.flags = MATERIAL_PHONG;
            m.mirror = 0.3f;
        },
        EFFECT_REFLECTIONS));
    EXPECT_FALSE(calls(
        [](Material& m) {
            m.flags = MATERIAL_PHONG;
            m.mirror = 0.0f;
            m.roughness = 0.0f;
        },
        EFFECT_REFLECTIONS));
    auto unlit = [](Material& m) {
        m.flags = MATERIAL_UNLIT;
        m.metallic = 1.0f;
        m.roughness = 0.0f;
    };
    EXPECT_FALSE(calls(unlit, EFFECT_REFLECTIONS));
}

TEST(EffectSet, GlossyIsWhatIsNoMirror) {
    const auto metal = [](float roughness) {
        return [roughness](Material& m) {
            m.metallic = 1.0f;
            m.roughness = roughness;
        };
    };
    EXPECT_FALSE(calls(metal(0.0f), EFFECT_GLOSSY_REFLECTIONS));
    EXPECT_TRUE(calls(metal(0.1f), EFFECT_GLOSSY_REFLECTIONS));
    EXPECT_TRUE(calls(metal(0.4f), EFFECT_GLOSSY_REFLECTIONS));
    EXPECT_TRUE(calls(metal(1.0f), EFFECT_GLOSSY_REFLECTIONS));
    EXPECT_FALSE(calls(
        [](Material& m) {
            m.transmission = 1.0f;
            m.roughness = 0.1f;
        },
        EFFECT_GLOSSY_REFLECTIONS))
        << "rough glass";
    Settings settings;
    EXPECT_FALSE(allowedEffects(settings).has(EFFECT_GLOSSY_REFLECTIONS));
    settings.glossyReflections = true;
    EXPECT_TRUE(allowedEffects(settings).has(EFFECT_GLOSSY_REFLECTIONS));
    settings.reflections = false;
    EXPECT_FALSE(allowedEffects(settings).has(EFFECT_GLOSSY_REFLECTIONS));
}

TEST(EffectSet, RoughnessTexturesAreLookedInto) {
    auto withRoughness = [](uint8_t green) {
        SceneBuilder builder = litBuilder();
        Material material = SceneBuilder::defaultMaterial();
        material.metallic = 1.0f;
        material.roughness = 1.0f;
        material.metallicRoughnessTexture =
            builder.addTexture(SceneBuilder::defaultTexture(builder.addImage(plainImage(0, green, 255))));
        builder.addInstance(builder.addMesh(square(builder.addMaterial(material, "worn metal"))), mat4(1.0f));
        return builder.finish();
    };
    EXPECT_TRUE(effectsOf(*withRoughness(50)).has(EFFECT_REFLECTIONS));
    EXPECT_FALSE(effectsOf(*withRoughness(180)).has(EFFECT_REFLECTIONS));
    EXPECT_TRUE(effectsOf(*withRoughness(180)).has(EFFECT_TEXTURES));
    EXPECT_FALSE(effectsOf(*withRoughness(180)).has(EFFECT_NORMAL_MAPS));
}

TEST(EffectSet, TransmissionCallsForRefractionsAndCoarserThings) {
    auto clear = [](Material& m) {
        m.transmission = 1.0f;
        m.flags = MATERIAL_VOLUME;
        m.roughness = 0.0f;
    };
    auto glass = squareScene(clear, "glass");
    EXPECT_TRUE(effectsOf(*glass).has(EFFECT_REFRACTIONS));
    EXPECT_TRUE(effectsOf(*glass).has(EFFECT_TRANSPARENT_SHADOWS));
    EXPECT_FALSE(effectsOf(*glass).has(EFFECT_ABSORPTION));
    EXPECT_EQ(reasonFor(*glass, EFFECT_REFRACTIONS).because, "1 material (glass), 2 triangles");
    EXPECT_EQ(reasonFor(*squareScene(), EFFECT_REFRACTIONS).because, "no transmissive material");
    auto tinted = [](Material& m) {
        m.transmission = 1.0f;
        m.flags = MATERIAL_VOLUME;
        m.absorption = vec4(1, 0, 0, 0);
    };
    EXPECT_TRUE(calls(tinted, EFFECT_ABSORPTION));
    auto thin = [](Material& m) {
        m.transmission = 1.0f;
        m.absorption = vec4(1, 0, 0, 0);
    };
    EXPECT_FALSE(calls(thin, EFFECT_ABSORPTION)) << "a thin wall has no inside";
    EXPECT_FALSE(calls(
        [](Material& m) {
            m.transmission = 1.0f;
            m.metallic = 1.0f;
        },
        EFFECT_REFRACTIONS))
        << "metal is opaque";
}

TEST(EffectSet, AlphaAndEmission) {
    auto cut = [](Material& m) { m.flags = MATERIAL_ALPHA_MASK, m.baseColor.w = 0.2f; };
    EXPECT_TRUE(calls(cut, EFFECT_ALPHA_MASK));
    EXPECT_FALSE(calls(cut, EFFECT_ALPHA_BLEND));
    EXPECT_FALSE(calls([](Material& m) { m.flags = MATERIAL_ALPHA_MASK; }, EFFECT_ALPHA_MASK)) << "no hole anywhere";
    EXPECT_FALSE(calls([](Material& m) { m.flags = MATERIAL_ALPHA_BLEND; }, EFFECT_ALPHA_BLEND)) << "solid everywhere";
    EXPECT_FALSE(calls([](Material& m) { m.flags = MATERIAL_ALPHA_BLEND; }, EFFECT_TRANSPARENT_SHADOWS));
    EXPECT_TRUE(calls(
        [](Material& m) {
            m.flags = MATERIAL_ALPHA_BLEND;
            m.baseColor.w = 0.5f;
        },
        EFFECT_ALPHA_BLEND));
    EXPECT_TRUE(calls(
        [](Material& m) {
            m.flags = MATERIAL_ALPHA_BLEND;
            m.baseColor.w = 0.5f;
        },
        EFFECT_TRANSPARENT_SHADOWS));
    EXPECT_TRUE(calls([](Material& m) { m.emission = vec4(0, 0, 2, 0); }, EFFECT_EMISSION));
    EXPECT_FALSE(calls({}, EFFECT_EMISSION));
}

/// A lit square whose material uses `image` as `change` says.
std::shared_ptr<const Scene> withImage(const ImageData& image, const std::function<void(Material&, uint32_t)>& change,
                                       MeshData mesh = square()) {
    SceneBuilder builder = litBuilder();
    Material material = SceneBuilder::defaultMaterial();
    change(material, builder.addTexture(SceneBuilder::defaultTexture(builder.addImage(image))));
    mesh.materials.assign(mesh.indices.size(), builder.addMaterial(material, "pictured"));
    builder.addInstance(builder.addMesh(mesh), mat4(1.0f));
    return builder.finish();
}

TEST(EffectSet, BlackImagesTakeGlowAndTransmissionAway) {
    auto glow = [](Material& m, uint32_t t) { m.emission = vec4(1.0f, 1.0f, 1.0f, 0.0f), m.emissionTexture = t; };
    EXPECT_FALSE(effectsOf(*withImage(plainImage(0, 0, 0), glow)).has(EFFECT_EMISSION));
    ImageData speck;  // one texel of 4,096: the 1x1 level rounds it to black
    speck.width = speck.height = 64;
    speck.rgba8.assign(64 * 64 * 4, 0);
    speck.rgba8[4 * 2081 + 1] = 9;
    EXPECT_TRUE(effectsOf(*withImage(speck, glow)).has(EFFECT_EMISSION));
    auto clear = [](Material& m, uint32_t t) { m.transmission = 1.0f, m.roughness = 1.0f, m.transmissionTexture = t; };
    EXPECT_FALSE(effectsOf(*withImage(plainImage(0, 200, 200), clear)).has(EFFECT_REFRACTIONS)) << "red counts";
    EXPECT_FALSE(effectsOf(*withImage(plainImage(0, 200, 200), clear)).has(EFFECT_REFLECTIONS));
    EXPECT_TRUE(effectsOf(*withImage(plainImage(1, 0, 0), clear)).has(EFFECT_REFRACTIONS));
}

TEST(EffectSet, GlassThatBendsNothingReflectsNothing) {
    auto sheet = [](Material& m) { m.transmission = 1.0f, m.ior = 1.0f, m.roughness = 0.0f; };
    EXPECT_TRUE(calls(sheet, EFFECT_REFRACTIONS));
    EXPECT_FALSE(calls(sheet, EFFECT_REFLECTIONS));
}

TEST(EffectSet, NormalImagesOfUnlitSurfacesDoNotCount) {
    auto bumpy = [](Material& m, uint32_t t) { m.normalTexture = t; };
    auto scene = withImage(plainImage(128, 128, 255), bumpy);
    EXPECT_TRUE(effectsOf(*scene).has(EFFECT_NORMAL_MAPS));
    auto unlit = [](Material& m, uint32_t t) { m.normalTexture = t, m.flags = MATERIAL_UNLIT; };
    EXPECT_FALSE(effectsOf(*withImage(plainImage(128, 128, 255), unlit)).has(EFFECT_NORMAL_MAPS));
}

TEST(EffectSet, TangentsCountWhereANormalImageUsesThem) {
    MeshData mesh = square();
    mesh.tangents.assign(mesh.positions.size(), vec4(1, 0, 0, 1));
    auto bumpy = [](Material& m, uint32_t t) { m.normalTexture = t; };
    auto painted = [](Material& m, uint32_t t) { m.baseTexture = t; };
    auto with = withImage(plainImage(128, 128, 255), bumpy, mesh);
    EXPECT_EQ(reasonFor(*with, EFFECT_TANGENTS).because, "1 material (pictured), 2 triangles");
    EXPECT_FALSE(effectsOf(*withImage(plainImage(128, 128, 255), painted, mesh)).has(EFFECT_TANGENTS));
}

TEST(EffectSet, BlackLightsCastNoShadows) {
    SceneBuilder builder("dark");
    Light black{};
    black.type = LIGHT_POINT;
    builder.addLight(black);
    builder.addInstance(builder.addMesh(square()), mat4(1.0f));
    auto scene = builder.finish();
    EXPECT_FALSE(effectsOf(*scene).has(EFFECT_SHADOWS));
    EXPECT_EQ(reasonFor(*scene, EFFECT_SHADOWS).because, "every light is black");
    EXPECT_EQ(reasonFor(*scene, EFFECT_TRANSPARENT_SHADOWS).because, "every light is black");
    EXPECT_EQ(reasonFor(*squareScene(), EFFECT_SHADOWS).because, "1 light (1 directional)");
}

TEST(EffectSet, NothingFallsOnUnlitSurfaces) {
    const auto scene = squareScene([](Material& m) { m.flags |= MATERIAL_UNLIT; });
    for (uint64_t effect :
         {EFFECT_SHADOWS, EFFECT_TRANSPARENT_SHADOWS, EFFECT_SOFT_SHADOWS, EFFECT_AMBIENT_OCCLUSION, EFFECT_INDIRECT_LIGHT}) {
        EXPECT_FALSE(effectsOf(*scene).has(effect));
        EXPECT_EQ(reasonFor(*scene, effect).because, "every surface is unlit");
    }
    EXPECT_TRUE(effectsOf(*scene).has(EFFECT_FOG)) << "which is before them";
}

TEST(EffectSet, RowsNameTheirSwitch) {
    std::vector<EffectReason> rows = explainEffects(*squareScene());
    EXPECT_EQ(rows.at(0).setting, "shadows");
    EXPECT_EQ(rows.at(6).setting, "") << "textures have none";
    for (const EffectReason& row : rows) EXPECT_FALSE(row.help.empty()) << row.name;
}

TEST(EffectSet, VertexColoursCountWhereOneIsNotWhite) {
    SceneBuilder builder = litBuilder();
    MeshData white = square(), red = square();
    white.colors.assign(4, vec4(1.0f));
    red.colors.assign(4, vec4(1.0f));
    builder.addInstance(builder.addMesh(white), mat4(1.0f));
    EXPECT_FALSE(effectsOf(*builder.finish()).has(EFFECT_VERTEX_COLORS));
    red.colors[2] = vec4(1, 0, 0, 1);
    SceneBuilder second = litBuilder();
    second.addInstance(second.addMesh(red), mat4(1.0f));
    EXPECT_TRUE(effectsOf(*second.finish()).has(EFFECT_VERTEX_COLORS));
}

TEST(EffectSet, MaterialsThatNoTriangleHasDoNotCount) {
    SceneBuilder builder = litBuilder();
    Material glass = SceneBuilder::defaultMaterial();
    glass.transmission = 1.0f;
    builder.addMaterial(glass, "unused glass");
    builder.addInstance(builder.addMesh(square()), mat4(1.0f));
    EXPECT_FALSE(effectsOf(*builder.finish()).has(EFFECT_REFRACTIONS));
}

TEST(EffectSet, TrianglesAreCountedOverInstances) {
    SceneBuilder builder = litBuilder();
    Material chrome = SceneBuilder::defaultMaterial();
    chrome.metallic = 1.0f;
    chrome.roughness = 0.0f;
    uint32_t mesh = builder.addMesh(square(builder.addMaterial(chrome, "chrome")));
    for (int i = 0; i < 1000; i++) {
        mat4 toWorld(1.0f);
        toWorld[3] = vec4(static_cast<float>(3 * i), 0.0f, 0.0f, 1.0f);
        builder.addInstance(mesh, toWorld);
    }
    auto scene = builder.finish();
    EXPECT_EQ(reasonFor(*scene, EFFECT_REFLECTIONS).because, "1 material (chrome), 2,000 triangles");
    EXPECT_TRUE(effectsOf(*scene).has(EFFECT_INSTANCING));
    EXPECT_FALSE(effectsOf(*squareScene()).has(EFFECT_INSTANCING));
}

TEST(EffectSet, AnEnvironmentImageIsCalledForAndColourIsNot) {
    SceneBuilder builder = litBuilder();
    builder.addInstance(builder.addMesh(square()), mat4(1.0f));
    ImageData sky;
    sky.width = 8;
    sky.height = 4;
    sky.rgb32f.assign(8 * 4 * 3, 0.5f);
    builder.setEnvironmentImage(builder.addImage(sky));
    auto scene = builder.finish();
    EXPECT_TRUE(effectsOf(*scene).has(EFFECT_ENVIRONMENT_IMAGE));
    EXPECT_EQ(reasonFor(*scene, EFFECT_ENVIRONMENT_IMAGE).because, "an image of 8x4 pixels");
    EXPECT_FALSE(effectsOf(*scene).has(EFFECT_TEXTURES)) << "the sky is on no surface";
    EXPECT_FALSE(effectsOf(*squareScene()).has(EFFECT_ENVIRONMENT_IMAGE));
}

TEST(EffectSet, SettingsAllowWhatTheySwitch) {
    Settings settings;
    EXPECT_TRUE(allowedEffects(settings).has(EFFECT_SHADOWS));
    EXPECT_FALSE(allowedEffects(settings).has(EFFECT_AMBIENT_OCCLUSION));
    settings.shadows = false;
    settings.refractions = false;
    settings.ambientOcclusion = true;
    EffectSet allowed = allowedEffects(settings);
    EXPECT_FALSE(allowed.has(EFFECT_SHADOWS));
    EXPECT_FALSE(allowed.has(EFFECT_TRANSPARENT_SHADOWS));
    EXPECT_FALSE(allowed.has(EFFECT_ABSORPTION));
    EXPECT_TRUE(allowed.has(EFFECT_AMBIENT_OCCLUSION));
    EXPECT_TRUE(allowed.has(EFFECT_TEXTURES)) << "has no switch";
    settings.aoRadius = 0.0f;
    EXPECT_FALSE(allowedEffects(settings).has(EFFECT_AMBIENT_OCCLUSION));
    EXPECT_FALSE(allowedEffects(settings).has(EFFECT_SOFT_SHADOWS)) << "without shadows";
    EXPECT_FALSE(allowedEffects(settings).has(EFFECT_DEPTH_OF_FIELD));
    settings.depthOfField = true;
    EXPECT_TRUE(allowedEffects(settings).has(EFFECT_DEPTH_OF_FIELD));
    settings.aperture = 0.0f;
    EXPECT_FALSE(allowedEffects(settings).has(EFFECT_DEPTH_OF_FIELD)) << "a pinhole";
    EXPECT_FALSE(allowedEffects(settings).has(EFFECT_FOG));
    settings.fog = true;
    EXPECT_TRUE(allowedEffects(settings).has(EFFECT_FOG));
    settings.fogDensity = 0.0f;
    EXPECT_FALSE(allowedEffects(settings).has(EFFECT_FOG)) << "clear air";
    EXPECT_FALSE(allowedEffects(settings).has(EFFECT_MOTION_BLUR));
    settings.motionBlur = true;
    EXPECT_TRUE(allowedEffects(settings).has(EFFECT_MOTION_BLUR));
    settings.shutter = 0.0f;
    EXPECT_FALSE(allowedEffects(settings).has(EFFECT_MOTION_BLUR)) << "no time to move";
}

}  // namespace
}  // namespace heliograph::TEST_FILE
