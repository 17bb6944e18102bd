// The picture does not depend on how it is made: threads, tiles, packets, instruction set, passes.

#include "tests/image/picture.h"

#include "server/kernel/instruction_set.h"
#include "server/device/embree/embree_scene.h"
#include "server/device/embree/tile_programs.h"
#include "server/scene/load/scene_source.h"
#include "tests/support/material_zoo.h"

#include <gtest/gtest.h>

#include <cstring>

namespace heliograph {

namespace lanes_v2 {
extern const TileProgramTable PROGRAM_TABLE;
}
namespace lanes_v3 {
extern const TileProgramTable PROGRAM_TABLE;
}
namespace lanes_v4 {
extern const TileProgramTable PROGRAM_TABLE;
}
}  // namespace heliograph

namespace heliograph::TEST_FILE {
namespace {

using namespace test;

Settings busy() {
    Settings settings;
    settings.ambientOcclusion = true;
    settings.aoSamples = 4;
    settings.maxReflections = 3;
    return settings;
}

bool identical(const Picture& a, const Picture& b) {
    return a.pixels.size() == b.pixels.size() &&
           std::memcmp(a.pixels.data(), b.pixels.data(), a.pixels.size() * sizeof(vec4)) == 0;
}

std::shared_ptr<const Scene> zoo() {
    static const std::shared_ptr<const Scene> scene = materialZoo();
    return scene;
}

Picture zooPicture(const Settings& settings, uint32_t samples = 1, uvec2 size = uvec2(97, 61)) {
    return render(zoo(), cameraFrom(zooCamera()), settings, samples, size);
}

TEST(Determinism, ThreadsDoNotMatter) {
    Settings settings = busy();
    settings.embreeThreads = 1;
    const Picture one = zooPicture(settings, 2);
    EXPECT_EQ(one.stats.nonfiniteSamples, 0u);
    for (uint32_t threads : {2u, 4u, 7u}) {
        settings.embreeThreads = threads;
        const Picture many = zooPicture(settings, 2);
        EXPECT_TRUE(identical(one, many)) << threads << " threads";
        EXPECT_EQ(one.stats.rays.by, many.stats.rays.by);
    }
}

TEST(Determinism, TilesDoNotMatter) {
    Settings settings = busy();
    const Picture usual = zooPicture(settings);
    for (const char* size : {"8", "16", "64", "256"}) {
        settings.set("tileWidth", size);
        settings.set("tileHeight", size);
        EXPECT_TRUE(identical(usual, zooPicture(settings))) << size;
    }
    settings.set("tileWidth", "128");
    settings.set("tileHeight", "8");
    EXPECT_TRUE(identical(usual, zooPicture(settings)));
    settings.tiles = false;
    EXPECT_TRUE(identical(usual, zooPicture(settings))) << "rows";
}

// Single rays and packets are other code in Embree, which may decide otherwise where two triangles lie at one distance.
TEST(Determinism, PacketsChangeNothingButTies) {
    Settings settings = busy();
    for (bool robust : {false, true}) {
        settings.robust = robust;
        settings.primaryPackets = settings.secondaryPackets = true;
        const Picture usual = zooPicture(settings);
        for (int mode = 0; mode < 3; mode++) {
            settings.primaryPackets = mode == 1;
            settings.secondaryPackets = mode == 2;
            const Picture other = zooPicture(settings);
            int different = 0;
            for (size_t i = 0; i < usual.pixels.size(); i++) different += usual.pixels[i] != other.pixels[i];
            EXPECT_LE(different, 2) << "primary " << settings.primaryPackets << " secondary " << settings.secondaryPackets;
            EXPECT_EQ(usual.stats.rays[RayKind::primary], other.stats.rays[RayKind::primary]);
        }
    }
}

// Of what Embree finds the two indices are taken alone: where a ray meets its triangle is computed again, so that another test of
// rays against triangles gives the same bits.
TEST(Determinism, RobustTraversalChangesNothingButTies) {
    Settings settings = busy();
    const Picture usual = zooPicture(settings);
    settings.robust = true;
    const Picture robust = zooPicture(settings);
    int different = 0;
    for (size_t i = 0; i < usual.pixels.size(); i++) different += usual.pixels[i] != robust.pixels[i];
    EXPECT_LE(different, 2);
}

TEST(Determinism, TheSameAgain) { EXPECT_TRUE(identical(zooPicture(busy(), 2), zooPicture(busy(), 2))); }

// Pass by pass, as a viewer's frames grow, or all samples of a tile at once.
TEST(Determinism, PassesGiveWhatOnePassOfAllSamplesGives) {
    const Settings settings = busy();
    const uvec2 size(97, 61);
    const Picture passes = zooPicture(settings, 4, size);
    const FrameRequest request = frameRequest(*zoo(), cameraFrom(zooCamera()), settings, size, 1);
    Film film;
    film.reset(size, 1);
    cpu().render(request, film.tilesFor(0, 4, uvec2(32, 32)), [&](TileResult&& result) { EXPECT_TRUE(film.add(result)); }, {});
    EXPECT_EQ(film.completedSamples(), 4u);
    std::vector<vec4> pixels;
    film.develop(pixels);
    // The device sums a tile's samples in float, the film sums passes in double: a few ulps apart.
    for (size_t i = 0; i < pixels.size(); i++)
        for (int c = 0; c < 3; c++) ASSERT_NEAR(pixels[i][c], passes.pixels[i][c], 1e-6 * std::max(1.0f, pixels[i][c])) << i;
}

TEST(Determinism, APartOfThePictureIsThatPart) {
    const Settings settings = busy();
    const uvec2 size(97, 61);
    const Picture whole = zooPicture(settings, 1, size);
    const FrameRequest request = frameRequest(*zoo(), cameraFrom(zooCamera()), settings, size, 1);
    const Tile tile{uvec2(40, 24), uvec2(16, 8), 0, 1, 1};
    std::vector<vec4> part;
    cpu().render(request, std::span(&tile, 1), [&](TileResult&& result) { part = result.radianceSum; }, {});
    ASSERT_EQ(part.size(), 128u);
    for (uint32_t y = 0; y < 8; y++)
        for (uint32_t x = 0; x < 16; x++) EXPECT_EQ(vec3(part[y * 16 + x]), whole.at(40 + x, 24 + y)) << x << ' ' << y;
}

// ---- instruction sets and program variants ----

struct TileSums {
    std::vector<vec4> radiance;
    std::vector<uint64_t> rays;
};

TileSums renderTile(const EmbreeScene& scene, const FrameRequest& request, const TileProgramRow& row, uint32_t width) {
    const FrameConstants frame = frameConstants(scene.scene(), request);
    TileSums sums;
    sums.radiance.assign(size_t(request.resolution.x) * request.resolution.y, vec4(0.0f));
    TileJob job;
    job.rtcScene = scene.target();
    job.rtcScene.untraceable = &job.untraceableRays;
    job.view = &scene.view();
    job.frame = &frame;
    job.options.primaryWidth = job.options.secondaryWidth = width;
    job.coherentPrimary = scene.coherentPrimary();
    job.coherentShadows = scene.coherentShadows();
    job.tile.size = request.resolution;
    job.tile.sampleCount = 2;
    job.radianceSum = sums.radiance.data();
    const std::unique_ptr<TileProgram> program(row.make());
    program->render(job);
    EXPECT_EQ(job.nonfiniteSamples, 0u);
    sums.rays.assign(std::begin(job.rays), std::end(job.rays));
    return sums;
}

std::vector<const TileProgramTable*> tablesHere() {
    std::vector<const TileProgramTable*> tables = {&lanes_v2::PROGRAM_TABLE};
    if (processorRuns("v3")) tables.push_back(&lanes_v3::PROGRAM_TABLE);
    if (processorRuns("v4")) tables.push_back(&lanes_v4::PROGRAM_TABLE);
    return tables;
}

/// Every program of every instruction set that can do the request's effects gives the same bits.
void expectSameFromAllPrograms(const std::shared_ptr<const Scene>& scene, const Camera& camera, const Settings& settings) {
    RTCDevice device = rtcNewDevice(nullptr);
    ASSERT_NE(device, nullptr);
    {
        const EmbreeScene embree(device, scene, 1, false, {});
        const FrameRequest request = frameRequest(*scene, camera, settings, uvec2(48, 40), 1);
        const uint32_t width = nativePacketWidth(device);
        TileSums first;
        for (const TileProgramTable* table : tablesHere()) {
            for (uint32_t i = 0; i < table->count; i++) {
                if ((request.effects.bits & ~table->rows[i].effects) != 0) continue;
                TileSums sums = renderTile(embree, request, table->rows[i], width);
                if (first.radiance.empty()) first = sums;
                EXPECT_EQ(std::memcmp(sums.radiance.data(), first.radiance.data(), sums.radiance.size() * sizeof(vec4)), 0)
                    << table->instructionSet << " program " << i << " of " << scene->name;
                EXPECT_EQ(sums.rays, first.rays) << table->instructionSet << " program " << i;
            }
        }
        EXPECT_FALSE(first.radiance.empty());
    }
    rtcReleaseDevice(device);
}

TEST(InstructionSets, AnEffectWithoutCodeIsRefused) {
    const TileProgramRow rows[] = {
        {EFFECT_SHADOWS, nullptr}, {~(EFFECT_ALPHA_MASK | EFFECT_GUIDES), nullptr}, {GUIDE_EFFECTS, nullptr}};
    const TileProgramTable table{"test", rows, 3, EFFECT_TEXTURES};
    EXPECT_EQ(chooseTileProgram(table, EFFECT_SHADOWS), 0u);
    EXPECT_EQ(chooseTileProgram(table, EFFECT_REFLECTIONS), 1u);
    EXPECT_THROW(chooseTileProgram(table, EFFECT_SHADOWS | EFFECT_TEXTURES), std::runtime_error);
    EXPECT_THROW(chooseTileProgram(table, EFFECT_ALPHA_MASK), std::runtime_error);
    EXPECT_EQ(chooseTileProgram(table, EFFECT_GUIDES), 2u);
    EXPECT_EQ(tileProgramTable().leftOut, 0u) << "this build measures something and is not for use";
}

TEST(InstructionSets, GiveTheSameBitsInTheMaterialZoo) { expectSameFromAllPrograms(zoo(), cameraFrom(zooCamera()), busy()); }

TEST(InstructionSets, GiveTheSameBitsWithEveryEffectOn) {
    Settings all = busy();
    all.depthOfField = all.motionBlur = all.fog = all.glossyReflections = all.indirectLight = true;
    all.fogSamples = 2;
    expectSameFromAllPrograms(zoo(), cameraFrom(zooCamera()), all);
    const auto scene = openScene("effects/soft-shadows");
    expectSameFromAllPrograms(scene, cameraFrom(scene->cameras[0]), Settings{});
}

TEST(InstructionSets, GiveTheSameBitsInTheCornellBox) {
    const auto scene = openScene("cornell");
    expectSameFromAllPrograms(scene, cameraFrom(scene->cameras[0]), busy());
    expectSameFromAllPrograms(scene, cameraFrom(scene->cameras[0]), Settings{});
    Settings plain;
    plain.reflections = plain.refractions = false;
    expectSameFromAllPrograms(scene, cameraFrom(scene->cameras[0]), plain);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
