// Benchmark for machines with a GPU, in one program that needs neither image libraries nor sockets:
//   heliograph-bench rays      bare tracing of primary, shadow, occlusion and diffuse rays on 0.9 million triangles at 1080p:
//                              our tracer, the driver's ray tracing pipeline, Embree, all on the same rays; JSON
//   heliograph-bench frames    primary + shadow + 1 occlusion ray through the device interface, by batch size; JSON
//   heliograph-bench hybrid    the GPU and the processor together through the tile scheduler, beside each alone; JSON
//   heliograph-bench effects   what each effect costs on the GPU, and a small mirror; JSON
//   heliograph-bench switch    effects switched on: time to the first frame, and to the GPU's own; JSON
//   heliograph-bench reach     views at rest, with and without knowing which tiles see no mirror; JSON
//   heliograph-bench parity    our scenes against Embree, also as a checkerboard; JSON, pictures
//   heliograph-bench start     seconds from nothing to the first frame; JSON
//   heliograph-bench devices   what there is
// Options: --device D, --size WxH, --detail X (share of the triangles), --repetitions N, --out FOLDER, --validation,
// --statistics (registers and memory of each program, logged), --driver-rounding (quotients and roots as the driver has them),
// --scene NAME (hybrid, effects, reach, switch: one scene)

#include "tests/bench/colonnade.h"
#include "tests/bench/gpu_bench.h"
#include "tests/support/effect_views.h"

#include "server/device/embree/embree_device.h"
#include "server/device/embree/embree_scene.h"
#include "server/device/embree/flush_denormals.h"
#include "server/device/vulkan/bench/ray_bench.h"
#include "server/device/vulkan/trace/vulkan_device.h"
#include "server/encode/png_encoder.h"
#include "server/film/stats.h"
#include "server/scene/generate/generate.h"
#include "server/kernel/kernel.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iostream>

namespace heliograph {
namespace {

using namespace gpu_bench;
using KernelType = scalar_kernel::Kernel<0u>;

// ---- rays ----

struct RayClass {
    std::string name;
    bool anyHit;
    std::vector<Ray> rays;
};

Ray makeRay(vec3 origin, vec3 direction, float tMax) {
    Ray ray{};
    ray.origin = origin;
    ray.direction = direction;
    ray.tMax = tMax;
    return ray;
}

/// The rays that hits of the primary rays lead to. Only rays that are needed are made.
std::vector<RayClass> makeRays(const Scene& scene, RayBench& bench, uvec2 size) {
    std::vector<RayClass> classes = {
        {"primary", false, {}}, {"shadow", true, {}}, {"ambient_occlusion", true, {}}, {"diffuse", false, {}}};
    KernelType kernel;
    kernel.scene = sceneView(scene);
    FrameRequest request = frameRequest(scene, cameraFrom(scene.cameras.front()), Settings{}, size, 1);
    kernel.frame = frameConstants(scene, request);
    kernel.frame.effects = 0;
    // 8 x 4 pixels in a row of rays, as a workgroup of the tracer sees them.
    std::vector<uvec2> pixels;
    for (uint32_t y = 0; y < size.y; y += 4)
        for (uint32_t x = 0; x < size.x; x += 8)
            for (uint32_t j = y; j < std::min(y + 4, size.y); j++)
                for (uint32_t i = x; i < std::min(x + 8, size.x); i++) pixels.push_back({i, j});
    for (uvec2 pixel : pixels) {
        auto path = kernel.startSample(pixel, 0);
        classes[0].rays.push_back(makeRay(path.origin, path.direction, KernelType::FLOAT_MAX));
    }
    std::vector<RayAnswer> answers;
    bench.trace(classes[0].rays, false, 1, 0.0, answers);
    vec3 toSun = -scene.lights.front().direction;
    for (size_t i = 0; i < answers.size(); i++) {
        if (answers[i].instance == NO_INDEX) continue;
        Hit hit{answers[i].instance, answers[i].primitive};
        const Ray& ray = classes[0].rays[i];
        auto s = kernel.surfaceAt(ray.origin, ray.direction, 0.0f, 0.0f, hit);
        vec3 origin = kernel.offsetRayOrigin(s.position, s.geometricNormal, s.clearance);
        if (dot(s.geometricNormal, toSun) > 0.0f) classes[1].rays.push_back(makeRay(origin, toSun, KernelType::FLOAT_MAX));
        vec3 tangent, bitangent;
        kernel.orthonormalBasis(s.geometricNormal, tangent, bitangent);
        uint32_t bits = kernel.hashPixel(pixels[i], 7u);
        vec3 local = kernel.cosineHemisphere(kernel.unitFloat(bits), kernel.unitFloat(kernel.hashUint(bits)));
        vec3 d = tangent * local.x + bitangent * local.y + s.geometricNormal * local.z;
        classes[2].rays.push_back(makeRay(origin, d, 5.0f));
        classes[3].rays.push_back(makeRay(origin, d, KernelType::FLOAT_MAX));
    }
    return classes;
}

/// Embree on the same rays, sixteen at a time on all cores; the answers are the reference.
double traceEmbree(const TraceTarget& scene, const RayClass& rays, bool coherent, std::vector<RayAnswer>& answers) {
    size_t count = rays.rays.size();
    answers.resize(count);
    double begin = now();
    tbb::parallel_for(size_t(0), (count + 1023) / 1024, [&](size_t block) {
        const FlushDenormals flush;
        for (size_t first = block * 1024; first < std::min(count, (block + 1) * 1024); first += PACKET) {
            RTCRayHit16 packet;
            uint32_t n = static_cast<uint32_t>(std::min<size_t>(PACKET, count - first));
            for (uint32_t i = 0; i < n; i++) {
                const Ray& ray = rays.rays[first + i];
                setRay(packet.ray, i, ray.origin, ray.direction, ray.tMax);
            }
            uint32_t transparent = 0, blocked = 0;
            if (rays.anyHit) blocked = traceOccluded(scene, packet.ray, n, {16, coherent}, transparent);
            else traceClosest(scene, packet, n, {16, coherent});
            for (uint32_t i = 0; i < n; i++) {
                if (rays.anyHit) answers[first + i] = {0, 0, blocked >> i & 1u, 0};
                else
                    answers[first + i] = {packet.hit.geomID[i],
                                          packet.hit.geomID[i] == NO_INDEX ? NO_INDEX : packet.hit.primID[i], 0, 0};
            }
        }
    });
    return now() - begin;
}

ordered_json rates(const RayClass& rays, std::vector<double> seconds) {
    double best = *std::min_element(seconds.begin(), seconds.end());
    return {{"mrays_per_s", static_cast<double>(rays.rays.size()) / median(seconds) * 1e-6},
            {"best_mrays_per_s", static_cast<double>(rays.rays.size()) / best * 1e-6},
            {"ms", median(seconds) * 1e3}};
}

uint64_t disagreements(const RayClass& rays, const std::vector<RayAnswer>& a, const std::vector<RayAnswer>& b) {
    uint64_t count = 0;
    for (size_t i = 0; i < a.size(); i++) {
        if (rays.anyHit) count += (a[i].found & 1u) != (b[i].found & 1u);
        else count += a[i].primitive != b[i].primitive;
    }
    return count;
}

ordered_json benchRays(const Options& options) {
    auto context = vulkanContext(vulkanOptions(options));
    const PhysicalDevice& physical = context->find(options.device);
    GpuFeatures features;
    features.rayTracingPipeline = physical.rayTracingPipeline;
    Gpu gpu(context, physical, features);
    double begin = now();
    auto scene = makeColonnade(options.detail);
    ordered_json json = {
        {"device", physical.name},  {"driver", physical.driver},           {"width", options.size.x},
        {"height", options.size.y}, {"triangles", scene->triangleCount()}, {"generate_ms", 1e3 * (now() - begin)}};
    GpuScene(gpu, scene, 1, {});  // the first build also starts Embree's threads
    GpuScene resident(gpu, scene, 1, {});
    json["build_ms"] = 1e3 * resident.buildSeconds();
    json["upload_ms"] = 1e3 * resident.uploadSeconds();
    std::unique_ptr<RayBench> ours = makeTracerBench(gpu, resident);
    double anchorBuild = 0.0;
    std::unique_ptr<RayBench> anchor;
    if (features.rayTracingPipeline) anchor = makeAnchorBench(gpu, *scene, anchorBuild);
    if (anchor) json["anchor_build_ms"] = 1e3 * anchorBuild;
    std::vector<RayClass> classes = makeRays(*scene, *ours, options.size);
    RTCDevice embree = rtcNewDevice("set_affinity=0");
    {
        EmbreeScene reference(embree, scene, 1, false, {});
        double warm = physical.isCpu() ? 0.0 : 0.5;
        for (const RayClass& rays : classes) {
            ordered_json row = {{"rays", rays.rays.size()}};
            std::vector<RayAnswer> expected, answers;
            bool coherent = rays.name == "primary" || rays.name == "shadow";
            std::vector<double> seconds;
            for (int i = 0; i < 5; i++) seconds.push_back(traceEmbree(reference.target(), rays, coherent, expected));
            row["embree"] = rates(rays, seconds);
            row["ours"] = rates(rays, ours->trace(rays.rays, rays.anyHit, options.repetitions, warm, answers));
            row["ours"]["differ_from_embree"] = disagreements(rays, answers, expected);
            if (anchor) {
                row["anchor"] = rates(rays, anchor->trace(rays.rays, rays.anyHit, options.repetitions, warm, answers));
                row["anchor"]["differ_from_embree"] = disagreements(rays, answers, expected);
                row["ours_over_anchor"] = row["anchor"]["ms"].get<double>() / row["ours"]["ms"].get<double>();
            }
            row["ours_over_embree"] = row["embree"]["ms"].get<double>() / row["ours"]["ms"].get<double>();
            json[rays.name] = row;
        }
    }
    rtcReleaseDevice(embree);
    json["validation_messages"] = context->validationMessages();
    return json;
}

// ---- frames ----

ordered_json frameTimes(Device& device, const FrameRequest& request, uint32_t repetitions, Film* film) {
    std::vector<double> ms;
    RayCounts rays;
    double warmUntil = now() + 0.5;
    for (uint32_t i = 0; i < repetitions || now() < warmUntil; i++) {
        Film sizes;
        if (!film) sizes.reset(request.resolution, 1);
        else film->reset(request.resolution, 1);
        std::vector<Tile> tiles = (film ? *film : sizes).tilesFor(0, 1, tileSize(request.settings));
        std::mutex mutex;
        rays = {};
        double begin = now();
        device.render(request, tiles,
                      [&](TileResult&& result) {
                          if (film) film->add(result);
                          std::lock_guard lock(mutex);
                          rays.add(result.rays);
                      },
                      {});
        ms.push_back(1e3 * (now() - begin));
    }
    std::vector<double> last(ms.end() - std::min<long>(repetitions, static_cast<long>(ms.size())), ms.end());
    double best = *std::min_element(last.begin(), last.end());
    return {{"ms", median(last)},
            {"best_ms", best},
            {"rays", rays.total()},
            {"mrays_per_s", static_cast<double>(rays.total()) / median(last) * 1e-3}};
}

ordered_json benchFrames(const Options& options) {
    auto scene = makeColonnade(options.detail);
    Settings settings;
    settings.ambientOcclusion = true;
    settings.aoSamples = 1;
    settings.aoRadius = 1.0f;
    settings.tileWidth = settings.tileHeight = 3;  // 64 pixels
    FrameRequest request = frameRequest(*scene, cameraFrom(scene->cameras.front()), settings, options.size, 1);
    ordered_json json = {{"width", options.size.x}, {"height", options.size.y}, {"triangles", scene->triangleCount()}};
    struct Size {
        const char* name;
        uint64_t samples;
    };
    for (Size size : {Size{"65k", 65536}, {"262k", 262144}, {"1M", 1 << 20}, {"frame", 1 << 26}, {"automatic", 0}}) {
        auto device = makeVulkanDevice(options.device, vulkanOptions(options, size.samples));
        json["device"] = device->info().details;
        device->load(scene, settings, {});
        json["batches"][size.name] = frameTimes(*device, request, options.repetitions, nullptr);
        if (size.samples != 0) continue;
        Film film;
        json["with_film"] = frameTimes(*device, request, options.repetitions, &film);
        Settings rest = settings;
        rest.ambientOcclusion = false;
        FrameRequest bare = frameRequest(*scene, cameraFrom(scene->cameras.front()), rest, options.size, 1);
        json["primary_and_shadow"] = frameTimes(*device, bare, options.repetitions, nullptr);
    }
    auto embree = makeEmbreeDevice();
    embree->load(scene, settings, {});
    json["embree"] = frameTimes(*embree, request, 5, nullptr);
    return json;
}

// ---- start ----

ordered_json benchStart(const Options& options) {
    auto scene = makeColonnade(options.detail);
    double begin = now();
    auto device = makeVulkanDevice(options.device, vulkanOptions(options));
    double opened = now();
    Settings settings;
    device->load(scene, settings, {});
    double loaded = now();
    FrameRequest request = frameRequest(*scene, cameraFrom(scene->cameras.front()), settings, options.size, 1);
    Film film;
    renderFrame(*device, request, 1, film);
    double shown = now();
    return {{"device", device->info().details},         {"triangles", scene->triangleCount()},
            {"open_ms", 1e3 * (opened - begin)},        {"load_ms", 1e3 * (loaded - opened)},
            {"first_frame_ms", 1e3 * (shown - loaded)}, {"total_ms", 1e3 * (shown - begin)}};
}

// ---- parity ----

void writePicture(const std::string& path, const std::vector<vec4>& pixels, uvec2 size) {
    DisplayImage image{size.x, size.y, {}};
    for (const vec4& p : pixels) {
        for (int i = 0; i < 3; i++)
            image.rgba.push_back(static_cast<uint8_t>(255.0f * std::pow(std::clamp(p[i], 0.0f, 1.0f), 1.0f / 2.2f) + 0.5f));
        image.rgba.push_back(255);
    }
    std::vector<uint8_t> bytes;
    makePngEncoder()->encode(image, 100, bytes);
    std::ofstream file(path, std::ios::binary);
    file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<long>(bytes.size()));
    if (!file) throw std::runtime_error(path + ": cannot be written");
}

ordered_json compare(const std::vector<vec4>& a, const std::vector<vec4>& b) {
    uint64_t identical = 0, off = 0;
    double squares = 0.0;
    for (size_t i = 0; i < a.size(); i++) {
        identical += std::memcmp(&a[i], &b[i], 3 * sizeof(float)) == 0;
        vec3 d = glm::abs(glm::clamp(vec3(a[i]), 0.0f, 1.0f) - glm::clamp(vec3(b[i]), 0.0f, 1.0f));
        squares += glm::dot(d, d);
        off += std::max({d.x, d.y, d.z}) > 1.0f / 255.0f;
    }
    double pixels = static_cast<double>(a.size());
    double mse = squares / (3.0 * pixels);
    return {{"identical_percent", 100.0 * static_cast<double>(identical) / pixels},
            {"off_pixels", off},
            {"off_percent", 100.0 * static_cast<double>(off) / pixels},
            {"psnr_db", mse > 0.0 ? -10.0 * std::log10(mse) : 999.0}};
}

ordered_json benchParity(const Options& options) {
    ordered_json json;
    auto context = vulkanContext(vulkanOptions(options));
    auto gpu = makeVulkanDevice(options.device, vulkanOptions(options));
    auto cpu = makeEmbreeDevice();
    json["device"] = gpu->info().details;
    for (const SceneRecipe& recipe : generatedRecipes()) {
        auto scene = generated(recipe.name);
        Settings settings;
        for (const test::EffectView& view : test::effectViews()) {
            if (view.scene != recipe.name) continue;
            for (const std::string& text : view.set) settings.setFromText(text);
        }
        settings.ambientOcclusion = true;
        settings.aoSamples = 4;
        settings.primaryPackets = settings.secondaryPackets = false;
        gpu->load(scene, settings, {});
        cpu->load(scene, settings, {});
        Camera camera = cameraFrom(scene->cameras.front());
        camera.forward += vec3(0.00317f, 0.00171f, -0.00233f);  // off the scene's axes: no ray along an edge
        FrameRequest request = frameRequest(*scene, camera, settings, options.size, 1);
        request.previousCamera = camera;  // as if it had stepped aside, for motion blur
        request.previousCamera->position += vec3(0.04f, 0.02f, 0.03f) * scene->bounds.radius();
        Film film;
        std::vector<vec4> a, b;
        double gpuMs = renderFrame(*gpu, request, 1, film).milliseconds;
        film.develop(a);
        double cpuMs = renderFrame(*cpu, request, 1, film).milliseconds;
        film.develop(b);
        ordered_json row = compare(a, b);
        row["gpu_ms"] = gpuMs;
        row["embree_ms"] = cpuMs;
        json["scenes"][recipe.name] = row;
        // Every other 32-pixel cell from the other device: a border between them must not be seen.
        std::vector<vec4> mixed = a;
        for (size_t i = 0; i < mixed.size(); i++)
            if ((i % options.size.x / 32 + i / options.size.x / 32) & 1) mixed[i] = b[i];
        std::string file = recipe.name;
        std::replace(file.begin(), file.end(), '/', '-');
        writePicture(options.out + "/" + file + ".png", mixed, options.size);
    }
    json["validation_messages"] = context->validationMessages();
    return json;
}

ordered_json listDevices() {
    std::string why;
    ordered_json json = ordered_json::array();
    for (const PhysicalDevice& d : listVulkanDevices(why))
        json.push_back({{"index", d.index},
                        {"name", d.name},
                        {"type", d.type},
                        {"driver", d.driver},
                        {"api", d.api},
                        {"ray_tracing_pipeline", d.rayTracingPipeline},
                        {"refused", d.refused}});
    if (!why.empty()) json.push_back({{"refused", why}});
    return json;
}

Options parse(int argc, char** argv) {
    Options options;
    for (int i = 1; i < argc; i++) {
        std::string word = argv[i];
        auto value = [&] {
            if (++i >= argc) throw std::runtime_error(word + " wants a value");
            return std::string(argv[i]);
        };
        if (word == "--device") options.device = value();
        else if (word == "--scene") options.scene = value();
        else if (word == "--size") {
            if (std::sscanf(value().c_str(), "%ux%u", &options.size.x, &options.size.y) != 2)
                throw std::runtime_error("--size wants WxH");
        } else if (word == "--detail") options.detail = std::stof(value());
        else if (word == "--repetitions") options.repetitions = std::max(1u, static_cast<uint32_t>(std::stoul(value())));
        else if (word == "--out") options.out = value();
        else if (word == "--validation") options.validation = true;
        else if (word == "--statistics") options.statistics = true;
        else if (word == "--driver-rounding") options.driverRounding = true;
        else if (options.command.empty() && !word.starts_with("-")) options.command = word;
        else throw std::runtime_error("unknown option " + word);
    }
    return options;
}

int run(const Options& options) {
    ordered_json json;
    if (options.command == "rays") json = benchRays(options);
    else if (options.command == "frames") json = benchFrames(options);
    else if (options.command == "parity") json = benchParity(options);
    else if (options.command == "hybrid") json = benchTogether(options);
    else if (options.command == "effects") json = benchEffectCosts(options);
    else if (options.command == "reach") json = benchReach(options);
    else if (options.command == "switch") json = benchSwitches(options);
    else if (options.command == "start") json = benchStart(options);
    else if (options.command == "devices") json = listDevices();
    else
        throw std::runtime_error("command: '" + options.command +
                                 "'; allowed: rays frames hybrid effects reach switch parity start devices");
    std::cout << json.dump(2, ' ', false, ordered_json::error_handler_t::replace) << std::endl;
    return 0;
}

}  // namespace
}  // namespace heliograph

int main(int argc, char** argv) {
    try {
        return heliograph::run(heliograph::parse(argc, argv));
    } catch (const std::exception& error) {
        std::fprintf(stderr, "heliograph-bench: %s\n", error.what());
        return 1;
    }
}
