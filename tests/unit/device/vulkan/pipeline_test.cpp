// Programs on a Vulkan device: what outlives the process, and the general one that serves until a request has its own.

#include "server/device/vulkan/core/pipeline_store.h"
#include "server/device/vulkan/core/shader_code.h"
#include "server/device/vulkan/trace/vulkan_device.h"
#include "server/film/cell_bounces.h"
#include "tests/support/direct_renderer.h"
#include "server/scene/load/scene_source.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <optional>
#include <string>

#include <malloc.h>
#include <unistd.h>

namespace heliograph::TEST_FILE {
namespace {

namespace fs = std::filesystem;

/// A folder of the test's own, which goes with it.
class ScratchFolder {
public:
    ScratchFolder() : path(fs::temp_directory_path() / ("heliograph-pipelines-" + std::to_string(getpid()))) {
        fs::remove_all(path);
        fs::create_directories(path);
    }
    ~ScratchFolder() { fs::remove_all(path); }
    const fs::path path;
};

/// An environment variable, put back at the end.
class Variable {
public:
    Variable(const char* name, std::optional<std::string> value) : name_(name) {
        if (const char* before = std::getenv(name)) before_ = before;
        set(value);
    }
    ~Variable() { set(before_); }

private:
    void set(const std::optional<std::string>& value) { value ? setenv(name_, value->c_str(), 1) : unsetenv(name_); }
    const char* name_;
    std::optional<std::string> before_;
};

const std::vector<uint8_t> PROGRAM = {1, 2, 3, 250, 0, 7};

TEST(ShaderCode, IsUnpackedOnceAndDamageIsRefused) {
    const shaders::Words words = shaders::rasterVertex();
    ASSERT_GT(words.size(), 5u);
    EXPECT_EQ(words[0], 0x07230203u) << "the mark of SPIR-V";
    EXPECT_EQ(shaders::rasterVertex().data(), words.data());
    // "HEYA" as gzip packs it.
    std::vector<unsigned char> packed = {0x1f, 0x8b, 8, 0, 0,    0,    0,    0,    2, 3, 0xf3, 0x70,
                                         0x8d, 0x74, 4, 0, 0xfe, 0x77, 0x17, 0x63, 4, 0, 0,    0};
    EXPECT_EQ(shaders::unpacked(packed, 4), std::vector<uint32_t>{0x41594548u});
    for (const size_t bytes : {0u, 8u}) EXPECT_THROW(shaders::unpacked(packed, bytes), std::runtime_error) << bytes;
    packed[16] ^= 1;  // of the checksum
    EXPECT_THROW(shaders::unpacked(packed, 4), std::runtime_error);
    packed.resize(12);
    EXPECT_THROW(shaders::unpacked(packed, 4), std::runtime_error);
}

TEST(PipelineStore, KeepsAndReplaces) {
    const ScratchFolder scratch;
    const fs::path file = scratch.path / "deeper/than/it/is";
    EXPECT_TRUE(PipelineStore(file).read().empty());
    EXPECT_TRUE(PipelineStore(file).keep(PROGRAM));
    EXPECT_EQ(PipelineStore(file).read(), PROGRAM);
    EXPECT_TRUE(PipelineStore(file).keep(std::vector<uint8_t>{9}));
    EXPECT_EQ(PipelineStore(file).read(), std::vector<uint8_t>{9});
    EXPECT_EQ(std::distance(fs::directory_iterator(file.parent_path()), fs::directory_iterator()), 1)
        << "something was left beside it";
}

TEST(PipelineStore, WhatIsDamagedCountsAsAbsent) {
    const ScratchFolder scratch;
    const fs::path file = scratch.path / "kept";
    ASSERT_TRUE(PipelineStore(file).keep(PROGRAM));
    std::string whole;
    {
        std::ifstream in(file, std::ios::binary);
        whole.assign(std::istreambuf_iterator<char>(in), {});
    }
    const auto readWith = [&](const std::string& content) {
        std::ofstream(file, std::ios::binary | std::ios::trunc) << content;
        return PipelineStore(file).read();
    };
    EXPECT_EQ(readWith(whole), PROGRAM);
    for (size_t length = 0; length < whole.size(); length++) EXPECT_TRUE(readWith(whole.substr(0, length)).empty()) << length;
    EXPECT_TRUE(readWith(whole + "x").empty());
    for (size_t at = 0; at < whole.size(); at++) {
        std::string changed = whole;
        changed[at] = static_cast<char>(changed[at] ^ 0x10);
        EXPECT_TRUE(readWith(changed).empty()) << at;
    }
}

TEST(PipelineStore, WhatCannotBeWrittenIsGivenUp) {
    const ScratchFolder scratch;
    std::ofstream(scratch.path / "file") << "in the way";
    EXPECT_FALSE(PipelineStore(scratch.path / "file/kept").keep(PROGRAM));
    EXPECT_FALSE(PipelineStore({}).keeps());
    EXPECT_FALSE(PipelineStore({}).keep(PROGRAM));
    EXPECT_TRUE(PipelineStore({}).read().empty());
}

TEST(PipelineStore, TheFolderFollowsTheEnvironment) {
    const Variable own("HELIOGRAPH_CACHE", std::nullopt);
    const Variable home("HOME", "/home/somebody");
    {
        const Variable caches("XDG_CACHE_HOME", "/var/caches");
        EXPECT_EQ(cacheFolder(), "/var/caches/heliograph");
        const Variable wish("HELIOGRAPH_CACHE", "/mine");
        EXPECT_EQ(cacheFolder(), "/mine");
        const Variable none("HELIOGRAPH_CACHE", "");
        EXPECT_EQ(cacheFolder(), "");
    }
    const Variable relative("XDG_CACHE_HOME", "relative");
    EXPECT_EQ(cacheFolder(), "/home/somebody/.cache/heliograph")
        << "a relative path there counts as absent (XDG Base Directory)";
    const Variable nowhere("HOME", std::nullopt);
    EXPECT_EQ(cacheFolder(), "");
}

VulkanOptions standingBy() {
    VulkanOptions options;
    options.validation = true;
    options.alwaysStandsBy = true;
    return options;
}

std::vector<vec4> picture(Device& device, const FrameRequest& request) {
    Film film;
    renderFrame(device, request, 2, film);
    std::vector<vec4> pixels;
    film.develop(pixels);
    return pixels;
}

bool same(const std::vector<vec4>& a, const std::vector<vec4>& b) {
    return a.size() == b.size() && !a.empty() && std::memcmp(a.data(), b.data(), a.size() * sizeof(vec4)) == 0;
}

// Whatever a viewer switches, the general program makes the picture that the request's own program makes.
TEST(GeneralPipeline, MakesTheSamePictureUntilTheRequestHasItsOwn) {
    auto context = vulkanContext(standingBy());
    const uint64_t before = context->validationMessages();
    const auto scene = openScene("cornell");
    auto device = makeVulkanDevice("", standingBy());
    device->load(scene, {}, {});
    const auto requestWith = [&](std::initializer_list<std::pair<const char*, bool>> switches) {
        Settings settings;
        for (const auto& [name, on] : switches) settings.set(name, on);
        return frameRequest(*scene, cameraFrom(scene->cameras.front()), settings, uvec2(48, 32), 1);
    };
    const FrameRequest few = requestWith({{"shadows", false}, {"refractions", false}});
    const FrameRequest many = requestWith({{"fog", true}, {"indirectLight", true}, {"ambientOcclusion", true}});
    EXPECT_EQ(device->warmth(requestWith({})), Warmth::warm) << "as its first viewer will see the scene";
    EXPECT_EQ(device->warmth(few), Warmth::cold);
    device->standBy();
    for (const FrameRequest& request : {few, many}) {
        EXPECT_EQ(device->warmth(request), Warmth::generic);
        const std::vector<vec4> general = picture(*device, request);
        EXPECT_EQ(device->warmth(request), Warmth::generic) << "nothing was compiled for it";
        device->warmUp(request);
        EXPECT_EQ(device->warmth(request), Warmth::warm);
        EXPECT_TRUE(same(general, picture(*device, request)));
    }
    FrameRequest deep = many;
    deep.settings.maxRefractions = 30;  // more pending rays than the general program has room for
    EXPECT_EQ(device->warmth(deep), Warmth::cold);
    EXPECT_EQ(context->validationMessages(), before);
}

/// The scene with one small mirror, in tiles of 16 pixels, on a device that has a program for paths that end at their first surface.
class FirstSurfacePipeline : public ::testing::Test {
protected:
    FirstSurfacePipeline() {
        Settings settings;
        settings.tileWidth = settings.tileHeight = 1;
        device_->load(scene_, settings, {});
        request_ = frameRequest(*scene_, cameraFrom(scene_->cameras.front()), settings, uvec2(160, 96), 1);
        Film film;
        film.reset(request_.resolution, request_.generation);
        tiles_ = film.tilesFor(0, 1, tileSize(settings));
        stats_ = render(expected_);
        device_->standBy();
        reach_->forget();
    }

    RayCounts render(std::vector<vec4>& pixels, bool asStream = false) {
        Film film;
        film.reset(request_.resolution, request_.generation);
        RayCounts rays;
        std::mutex mutex;
        const TileSink sink = [&](TileResult&& result) {
            film.add(result);
            std::lock_guard lock(mutex);
            rays.add(result.rays);
        };
        if (asStream) device_->renderStream(request_, tiles_, sink, {});
        else device_->render(request_, tiles_, sink, {});
        EXPECT_EQ(film.completedSamples(), 1u);
        film.develop(pixels);
        return rays;
    }

    void expectTheSame(const std::string& when, bool asStream) {
        std::vector<vec4> pixels;
        EXPECT_EQ(render(pixels, asStream).by, stats_.by) << when;
        EXPECT_TRUE(same(pixels, expected_)) << when;
    }

    std::shared_ptr<const Scene> scene_ = openScene("effects/small-mirror");
    std::shared_ptr<ViewBounces> reach_ = std::make_shared<ViewBounces>();
    std::unique_ptr<Device> device_ = makeVulkanDevice("", standingBy(), reach_);
    FrameRequest request_;
    std::vector<Tile> tiles_;
    std::vector<vec4> expected_;
    RayCounts stats_;
};

TEST_F(FirstSurfacePipeline, ServesTheTilesThatSeeNoMirrorWithTheSamePicture) {
    ASSERT_GT(stats_[RayKind::reflection], 0u) << "the mirror is seen";
    for (bool asStream : {false, true}) {
        expectTheSame("nothing is known of the view", asStream);
        const auto atFirst =
            std::count_if(tiles_.begin(), tiles_.end(), [&](const Tile& t) { return reach_->of(request_)->endsAtOnce(t); });
        EXPECT_GT(atFirst, static_cast<long>(tiles_.size() / 2));
        EXPECT_LT(atFirst, static_cast<long>(tiles_.size()));
        expectTheSame("the view is known", asStream);
    }
}

TEST_F(FirstSurfacePipeline, WhatItCutsOffIsRenderedAgain) {
    for (bool asStream : {false, true}) {
        reach_->forget();
        for (const Tile& tile : tiles_) {
            TileResult lie;  // that none of its paths has gone on
            lie.tile = tile;
            reach_->of(request_)->note(lie);
        }
        expectTheSame("all tiles are said to see no mirror", asStream);
        const auto atFirst =
            std::count_if(tiles_.begin(), tiles_.end(), [&](const Tile& t) { return reach_->of(request_)->endsAtOnce(t); });
        EXPECT_LT(atFirst, static_cast<long>(tiles_.size())) << "and now it is known better";
    }
}

// Lavapipe kept a copy of the program, 1.5 MB of it, for every pass over this scene.
TEST(Pipeline, PassesKeepNoMemory) {
    const auto scene = openScene("courtyard");
    VulkanOptions options;
    options.validation = true;
    auto device = makeVulkanDevice("", options);
    device->load(scene, {}, {});
    const FrameRequest request = frameRequest(*scene, cameraFrom(scene->cameras.front()), {}, uvec2(32, 16), 1);
    const auto passes = [&](uint32_t count) {
        Film film;
        renderFrame(*device, request, count, film);
        return mallinfo2().uordblks + mallinfo2().hblkhd;
    };
    const size_t before = passes(4), after = passes(40);
    EXPECT_LT(after, before + (16 << 20));
}

TEST(GeneralPipeline, AProcessorNeedsNone) {
    VulkanOptions options = standingBy();
    options.alwaysStandsBy = false;
    auto device = makeVulkanDevice("", options);
    if (device->info().hardware != "cpu") GTEST_SKIP() << "the best device here is " << device->info().details;
    const auto scene = openScene("cornell");
    device->load(scene, {}, {});
    device->standBy();
    Settings settings;
    settings.fog = true;
    const FrameRequest request = frameRequest(*scene, cameraFrom(scene->cameras.front()), settings, uvec2(48, 32), 1);
    EXPECT_EQ(device->warmth(request), Warmth::cold);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
