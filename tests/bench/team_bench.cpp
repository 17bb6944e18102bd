#include "tests/bench/gpu_bench.h"

#include "server/request/effect_rules.h"
#include "server/device/embree/embree_device.h"
#include "server/device/vulkan/trace/vulkan_device.h"
#include "server/lab/effect_bench.h"
#include "server/lab/hybrid_bench.h"
#include "server/film/cell_bounces.h"
#include "server/render/device_set.h"
#include "server/scene/generate/generate.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>

namespace heliograph::gpu_bench {

namespace {

constexpr double LONGEST_WAIT = 30.0;  // seconds, for a GPU that compiles

/// The setting `device` that means the GPU.
std::string gpuWord(const Options& options) {
    return "vulkan:" + std::to_string(vulkanContext(vulkanOptions(options))->find(options.device).index);
}

DeviceOffer offerOf(const Options& options, const std::string& gpu) {
    DeviceOffer offer;
    offer.team = {"embree", gpu};
    offer.nameOf = [](const Settings& settings) { return Settings::choiceWord("device", settings.device); };
    offer.make = [options](const std::string& word) {
        return word == "embree" ? makeEmbreeDevice() : makeVulkanDevice(word.substr(7), vulkanOptions(options));
    };
    offer.fallback = "embree";
    return offer;
}

/// A frame of the scene's first viewpoint.
template <typename Renders>
FrameStats shown(Renders& device, const Scene& scene, const Settings& settings, uvec2 size) {
    static uint32_t generation = 0;
    FrameRequest request = frameRequest(scene, cameraFrom(scene.cameras.front()), settings, size, ++generation);
    Film film;
    return renderFrame(device, request, 1, film);
}

ordered_json switchedOn(Renderer& device, const Scene& scene, const EffectReason& effect, const std::string& gpu, uvec2 size) {
    Settings off;
    off.set("device", gpu);
    off.set(effect.setting, false);
    Settings on = off;
    on.set(effect.setting, true);
    auto byGpu = [&](const FrameStats& stats) { return stats.tiles.size() == 1 && stats.tiles.contains(gpu); };
    const double settle = now() + LONGEST_WAIT;
    FrameStats before = shown(device, scene, off, size);
    while (now() < settle && !byGpu(before)) before = shown(device, scene, off, size);
    for (int i = 0; i < 20; i++) before = shown(device, scene, off, size);
    const double begin = now();
    const FrameStats first = shown(device, scene, on, size);
    const double firstSeconds = now() - begin;
    FrameStats last = first;
    uint32_t frames = 1;
    for (; !byGpu(last) && now() < begin + LONGEST_WAIT; frames++) last = shown(device, scene, on, size);
    const double settled = now() - begin;
    return {{"effect", effect.name},
            {"ms_before", before.milliseconds},
            {"first_frame_ms", 1e3 * firstSeconds},
            {"first_by", first.tiles.empty() ? "" : first.tiles.begin()->first},
            {"gpu_after_ms", 1e3 * settled},
            {"frames_until", frames},
            {"gpu_serves", byGpu(last)}};
}

bool wanted(const Options& options, const std::string& scene) { return options.scene.empty() || options.scene == scene; }

/// Frames of two scenes in turns; the ratio is formed within each pair.
ordered_json beside(const Options& options, const char* first, const char* second) {
    struct Side {
        std::shared_ptr<const Scene> scene;
        std::unique_ptr<Device> device;
        std::vector<double> ms;
    };
    Side sides[2] = {{generated(first), makeVulkanDevice(options.device, vulkanOptions(options)), {}},
                     {generated(second), makeVulkanDevice(options.device, vulkanOptions(options)), {}}};
    for (Side& side : sides) side.device->load(side.scene, {}, {});
    const double warm = now() + 1.0;
    while (now() < warm) {
        for (Side& side : sides) shown(*side.device, *side.scene, {}, options.size);
    }
    std::vector<double> ratios;
    for (uint32_t i = 0; i < 3 * options.repetitions; i++) {
        for (Side& side : sides) side.ms.push_back(shown(*side.device, *side.scene, {}, options.size).milliseconds);
        ratios.push_back(sides[0].ms.back() / sides[1].ms.back());
    }
    return {{"scenes", {first, second}},
            {"ms", {percentile(sides[0].ms, 0.5), percentile(sides[1].ms, 0.5)}},
            {"ratio", percentile(ratios, 0.5)},
            {"ratio_low", percentile(ratios, 0.25)},
            {"ratio_high", percentile(ratios, 0.75)}};
}

}  // namespace

VulkanOptions vulkanOptions(const Options& options, uint64_t batch) {
    VulkanOptions result;
    result.validation = options.validation;
    result.statistics = options.statistics;
    if (options.driverRounding) result.rounding = Rounding::driver;
    result.batchSamples = batch;
    return result;
}

std::shared_ptr<const Scene> generated(const std::string& name) {
    SceneBuilder builder(name);
    generateScene(name, builder);
    return builder.finish();
}

ordered_json benchTogether(const Options& options) {
    const std::string gpu = gpuWord(options);
    TileScheduler scheduler;
    ordered_json json;
    for (const char* name : {"courtyard", "cathedral", "glass"}) {
        if (!options.scene.empty() && options.scene != name) continue;
        auto scene = generated(name);
        const DeviceOffer offer = offerOf(options, gpu);
        auto device = makeDeviceSet(offer, scheduler, {{}, true, false});
        auto forced = makeDeviceSet(offer, scheduler, {{}, true, true});
        HybridBenchOptions wanted;
        wanted.camera = cameraFrom(scene->cameras.front());
        wanted.resolution = options.size;
        wanted.repetitions = std::min(options.repetitions, 9u);
        wanted.devices = offer.team;
        Settings hybrid = wanted.settings;
        hybrid.set("device", "hybrid");
        device->load(scene, hybrid, {});
        forced->load(scene, hybrid, {});
        for (uint32_t samples : {1u, 4u, 16u}) {
            wanted.samples = samples;
            wanted.warmUp = samples == 1 ? 40 : 16;
            json[name].push_back(toJson(benchHybrid(*device, *scene, wanted, {})));
            // The same with the processor made to take part, whatever that gains.
            HybridBenchOptions both = wanted;
            both.apart = false;
            both.repetitions = 3;
            json[name].back()["forced"] = toJson(benchHybrid(*forced, *scene, both, {}));
            const ordered_json& row = json[name].back();
            std::fprintf(stderr, "%s, %u samples: %.2f ms, %.3f of the best alone\n", name, samples, row["ms"].get<double>(),
                         row["ratio"].get<double>());
        }
    }
    return json;
}

ordered_json benchEffectCosts(const Options& options) {
    ordered_json json;
    json["small_mirror"] = beside(options, "effects/small-mirror", "effects/no-mirror");
    for (const SceneRecipe& recipe : generatedRecipes()) {
        if (!wanted(options, recipe.name)) continue;
        auto scene = generated(recipe.name);
        auto device = makeVulkanDevice(options.device, vulkanOptions(options));
        EffectBenchOptions bench;
        bench.camera = cameraFrom(scene->cameras.front());
        bench.settings.set("device", gpuWord(options));
        bench.resolution = options.size;
        bench.repetitions = std::min(options.repetitions, 9u);
        device->load(scene, bench.settings, {});
        test::DirectRenderer renderer(*device);
        json["scenes"][recipe.name] = toJson(benchEffects(renderer, *scene, bench, {}));
    }
    return json;
}

ordered_json benchReach(const Options& options) {
    ordered_json json;
    for (const char* name : {"effects/no-mirror", "effects/small-mirror", "courtyard", "cathedral", "glass"}) {
        if (!wanted(options, name)) continue;
        auto scene = generated(name);
        const auto reach = std::make_shared<ViewBounces>(), nothing = std::make_shared<ViewBounces>();
        auto device = makeVulkanDevice(options.device, vulkanOptions(options), reach);
        auto unknowing = makeVulkanDevice(options.device, vulkanOptions(options), nothing);
        device->load(scene, {}, {});
        unknowing->load(scene, {}, {});
        for (bool occlusion : {false, true}) {
            Settings settings;
            settings.ambientOcclusion = occlusion;
            FrameRequest request = frameRequest(*scene, cameraFrom(scene->cameras.front()), settings, options.size, 1);
            device->warmUp(request);
            unknowing->warmUp(request);
            Film film;  // gives the tiles and takes nothing: the host's part is left out
            film.reset(options.size, 1);
            const std::vector<Tile> tiles = film.tilesFor(0, 1, tileSize(settings));
            uint64_t rays[2] = {0, 0};
            auto milliseconds = [&](Device& with, uint64_t& count) {
                std::atomic<uint64_t> sum{0};
                const double begin = now();
                with.render(request, tiles, [&](TileResult&& result) { sum += result.rays.total(); }, {});
                count = sum;
                return 1e3 * (now() - begin);
            };
            for (const double warm = now() + 0.5; now() < warm;) milliseconds(*device, rays[0]);
            std::vector<double> ms[2], ratios;
            for (uint32_t i = 0; i < options.repetitions; i++) {
                nothing->forget();
                ms[0].push_back(milliseconds(*unknowing, rays[0]));
                ms[1].push_back(milliseconds(*device, rays[1]));
                ratios.push_back(ms[1].back() / ms[0].back());
            }
            const auto single = std::count_if(tiles.begin(), tiles.end(),
                                              [&](const Tile& tile) { return reach->of(request)->endsAtOnce(tile); });
            json[name].push_back({{"ambient_occlusion", occlusion},
                                  {"ms_without", percentile(ms[0], 0.5)},
                                  {"ms_with", percentile(ms[1], 0.5)},
                                  {"ratio", percentile(ratios, 0.5)},
                                  {"single_share", double(single) / double(tiles.size())},
                                  {"rays", rays[0]},
                                  {"same_rays", rays[0] == rays[1]}});
            // The same while the camera turns by half a degree a frame, to and fro.
            ratios.clear();
            ms[0].clear();
            ms[1].clear();
            bool same = true;
            for (uint32_t i = 0; i < 2 * options.repetitions; i++) {
                const float angle = 0.00873f * static_cast<float>(i % 20 < 10 ? i % 20 : 20 - i % 20);
                const vec3 forward = cameraFrom(scene->cameras.front()).forward;
                request.camera.forward = vec3(forward.x * std::cos(angle) + forward.z * std::sin(angle), forward.y,
                                              forward.z * std::cos(angle) - forward.x * std::sin(angle));
                nothing->forget();
                ms[0].push_back(milliseconds(*unknowing, rays[0]));
                ms[1].push_back(milliseconds(*device, rays[1]));
                ratios.push_back(ms[1].back() / ms[0].back());
                same = same && rays[0] == rays[1];
            }
            json[name].back()["turning"] = {{"ms_without", percentile(ms[0], 0.5)},
                                            {"ms_with", percentile(ms[1], 0.5)},
                                            {"ratio", percentile(ratios, 0.5)},
                                            {"same_rays", same}};
        }
    }
    return json;
}

ordered_json benchSwitches(const Options& options) {
    const std::string gpu = gpuWord(options);
    TileScheduler scheduler;
    ordered_json json;
    for (const char* name : {"courtyard", "glass", "effects/soft-shadows"}) {
        if (!wanted(options, name)) continue;
        auto scene = generated(name);
        auto device = makeDeviceSet(offerOf(options, gpu), scheduler);
        Settings settings;
        settings.set("device", gpu);
        device->load(scene, settings, {});
        for (const EffectReason& effect : explainEffects(*scene)) {
            if (!effect.possible() || effect.setting != effect.name) continue;
            json[name].push_back(switchedOn(*device, *scene, effect, gpu, options.size));
            std::fprintf(stderr, "%s: %s\n", name, json[name].back().dump().c_str());
        }
    }
    return json;
}

}  // namespace heliograph::gpu_bench
