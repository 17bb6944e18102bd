// Compares two devices on the same request, pixel by pixel: parity [options] [SCENE...]
//   --device D      the device that is compared with embree (vulkan:0; `embree`: its own watertight mode,
//                   which shows how many pixels hang on the rounding of edges); --size WxH, --samples N, --ao, --set NAME=VALUE
//   --checkerboard  every other tile from the other device
//   --out FOLDER    pictures of both devices and of the difference where a scene fails, or always with --pictures
//   --robust        embree traces watertight
//   --packets       embree traces in packets instead of ray by ray
//   --bar P         share of pixels (per cent) that may differ by more than 1/255 (else by scene, see rows())
// A row per scene; the last line is `N passed, N failed`, as ./check counts it. Without SCENE: all of rows() that are here.

#include "server/device/embree/embree_device.h"
#include "server/device/vulkan/trace/vulkan_device.h"
#include "server/encode/png_encoder.h"
#include "tests/support/direct_renderer.h"
#include "server/scene/load/scene_source.h"
#include "tests/support/effect_views.h"
#include "tests/support/places.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>

namespace heliograph {
namespace {

/// What a comparison must reach.
struct Bars {
    double identical = 0.0;  // least share of bit-identical pixels, per cent
    double offPixels = 0.2;  // greatest share of pixels that differ by more than 1/255, per cent
    double psnr = 50.0;      // dB
};
constexpr Bars OWN{99.5, 0.002, 0.0};  // scenes of ours have no coincident surfaces
constexpr Bars FOREIGN{0.0, 0.2, 50.0};

constexpr const char* KINDS[] = {"primary", "shadow", "ambient occlusion", "reflection", "refraction"};

struct Row {
    std::string scene;
    Bars bars;
    std::vector<std::string> set = {};  // beside those of the command line
};

std::vector<Row> rows() {
    std::vector<Row> all;
    for (const char* own : {"cornell", "glass", "courtyard", "cathedral"}) all.push_back({own, OWN});
    for (const test::EffectView& view : test::effectViews()) all.push_back({view.scene, OWN, view.set});
    const std::string shared = sharedScenes().string();
    for (const char* path :
         {"glass/GlassPack.obj", "sponza-dabrovic/sponza.obj", "sibenik/sibenik.obj", "gltf/DamagedHelmet", "gltf/Duck",
          "gltf/AlphaBlendModeTest", "gltf/AttenuationTest", "gltf/bio_15_transmission", "gltf/bio_01_alpha_mask",
          "gltf/BoxVertexColors", "gltf/NormalTangentTest", "gltf/TextureTransformTest", "gltf/CesiumMilkTruck",
          "gltf/bio_02_node_hierarchy", "gltf/bio_04_lights"}) {
        std::filesystem::path file = std::filesystem::path(shared) / path;
        if (std::filesystem::is_directory(file)) {
            for (const auto& entry : std::filesystem::recursive_directory_iterator(file))
                if (entry.path().extension() == ".gltf" || entry.path().extension() == ".glb") {
                    file = entry.path();
                    break;
                }
        }
        if (std::filesystem::is_regular_file(file)) all.push_back({file.string(), FOREIGN});
    }
    return all;
}

struct Options {
    std::string device = "0";
    uvec2 size{640, 360};
    uint32_t samples = 1;
    bool occlusion = false;
    bool checkerboard = false;
    bool pictures = false;
    bool packets = false;
    bool robust = false;
    std::string out;
    double bar = -1.0;
    std::vector<std::string> set;
    std::vector<std::string> scenes;
};

struct Comparison {
    uint64_t pixels = 0, identical = 0, off = 0, nonfinite = 0;
    double psnr = 0.0;
    uvec2 worst{0, 0};
    float greatest = 0.0f;
};

Comparison compare(const std::vector<vec4>& a, const std::vector<vec4>& b, uint32_t width) {
    Comparison c;
    c.pixels = a.size();
    double squares = 0.0;
    for (size_t i = 0; i < a.size(); i++) {
        if (std::memcmp(&a[i], &b[i], 3 * sizeof(float)) == 0) c.identical++;
        vec3 d = glm::abs(glm::clamp(vec3(a[i]), 0.0f, 1.0f) - glm::clamp(vec3(b[i]), 0.0f, 1.0f));
        float most = std::max(std::max(d.x, d.y), d.z);
        squares += glm::dot(d, d);
        if (most > 1.0f / 255.0f) c.off++;
        if (most > c.greatest) {
            c.greatest = most;
            c.worst = {static_cast<uint32_t>(i % width), static_cast<uint32_t>(i / width)};
        }
    }
    double mse = squares / (3.0 * static_cast<double>(a.size()));
    c.psnr = mse > 0.0 ? -10.0 * std::log10(mse) : 999.0;
    return c;
}

/// Gives every other tile to each of two devices.
class Checkerboard : public Device {
public:
    Checkerboard(Device& a, Device& b) : a_(a), b_(b) {}
    DeviceInfo info() const override { return {"checkerboard", "", "", 1}; }
    void load(std::shared_ptr<const Scene>, const Settings&, const Progress&) override {}
    void render(const FrameRequest& request, std::span<const Tile> tiles, const TileSink& sink, std::stop_token stop) override {
        std::vector<Tile> parts[2];
        for (const Tile& tile : tiles) parts[(tile.origin.x / 32 + tile.origin.y / 32) & 1].push_back(tile);
        a_.render(request, parts[0], sink, stop);
        b_.render(request, parts[1], sink, stop);
    }

private:
    Device& a_;
    Device& b_;
};

void writePicture(const std::string& path, const std::vector<vec4>& pixels, uvec2 size) {
    DisplayImage image{size.x, size.y, {}};
    for (const vec4& p : pixels) {
        for (int i = 0; i < 3; i++) {
            float x = std::clamp(p[i], 0.0f, 1.0f);
            x = x <= 0.0031308f ? 12.92f * x : 1.055f * std::pow(x, 1.0f / 2.4f) - 0.055f;
            image.rgba.push_back(static_cast<uint8_t>(255.0f * x + 0.5f));
        }
        image.rgba.push_back(255);
    }
    std::vector<uint8_t> bytes;
    makePngEncoder()->encode(image, 100, bytes);
    std::ofstream(path, std::ios::binary).write(reinterpret_cast<const char*>(bytes.data()), static_cast<long>(bytes.size()));
}

std::vector<vec4> render(Device& device, const FrameRequest& request, const Options& options, FrameStats& stats) {
    Film film;
    stats = renderFrame(device, request, options.samples, film);
    std::vector<vec4> pixels;
    film.develop(pixels);
    return pixels;
}

std::string label(const Row& row) {
    std::filesystem::path path(row.scene);
    return path.has_extension() ? path.stem().string() : row.scene;
}

bool runRow(const Row& row, const Options& options, Device& embree, Device& other) {
    auto scene = openScene(row.scene);
    Settings settings;
    settings.ambientOcclusion = options.occlusion;
    settings.aoSamples = 4;
    settings.robust = options.robust;
    settings.primaryPackets = options.packets;
    settings.secondaryPackets = options.packets;
    for (const std::string& text : row.set) settings.setFromText(text);
    for (const std::string& text : options.set) settings.setFromText(text);
    embree.load(scene, settings, {});
    other.load(scene, settings, {});
    // A camera on a scene's axis of symmetry looks through pixel centres along whole edges, and which of two neighbours a
    // ray on their common edge meets is open. So it is turned a little.
    Camera camera = cameraFrom(scene->cameras.front());
    camera.forward += vec3(0.00317f, 0.00171f, -0.00233f);
    FrameRequest request = frameRequest(*scene, camera, settings, options.size, 1);
    // As if the camera had stepped aside since the frame before, for motion blur.
    request.previousCamera = request.camera;
    request.previousCamera->position += vec3(0.04f, 0.02f, 0.03f) * scene->bounds.radius();
    FrameStats first, second;
    std::vector<vec4> a = render(embree, request, options, first);
    Checkerboard both(embree, other);
    if (options.device == "embree") request.settings.robust = !options.robust;
    std::vector<vec4> b = render(options.checkerboard ? both : other, request, options, second);
    Comparison c = compare(a, b, options.size.x);
    double identical = 100.0 * static_cast<double>(c.identical) / static_cast<double>(c.pixels);
    double off = 100.0 * static_cast<double>(c.off) / static_cast<double>(c.pixels);
    double bar = options.bar >= 0.0 ? options.bar : row.bars.offPixels;
    bool good = off <= bar && c.psnr >= row.bars.psnr && (options.bar >= 0.0 || identical >= row.bars.identical);
    std::printf(
        "%-6s %-24s %9llu triangles  identical %7.3f %%  over 1/255 %5llu px %8.4f %%  psnr %6.1f dB  rays %llu / %llu"
        "  ms %.0f / %.0f",
        good ? "ok" : "FAILED", label(row).c_str(), static_cast<unsigned long long>(scene->triangleCount()), identical,
        static_cast<unsigned long long>(c.off), off, c.psnr, static_cast<unsigned long long>(first.rays.total()),
        static_cast<unsigned long long>(second.rays.total()), first.milliseconds, second.milliseconds);
    for (size_t kind = 0; kind < first.rays.by.size(); kind++)
        if (first.rays.by[kind] != second.rays.by[kind])
            std::printf("  %s %llu / %llu", KINDS[kind], static_cast<unsigned long long>(first.rays.by[kind]),
                        static_cast<unsigned long long>(second.rays.by[kind]));
    if (!good) std::printf("  worst %.3f at (%u, %u)", c.greatest, c.worst.x, c.worst.y);
    std::printf("\n");
    std::fflush(stdout);
    if (!options.out.empty() && (!good || options.pictures)) {
        std::filesystem::create_directories(options.out);
        std::string name = label(row);
        std::replace(name.begin(), name.end(), '/', '-');
        std::string base = options.out + "/" + name;
        writePicture(base + "-embree.png", a, options.size);
        writePicture(base + (options.checkerboard ? "-checkerboard.png" : "-other.png"), b, options.size);
        std::vector<vec4> difference(a.size());
        for (size_t i = 0; i < a.size(); i++) difference[i] = glm::abs(a[i] - b[i]) * 16.0f;
        writePicture(base + "-difference.png", difference, options.size);
    }
    return good;
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
        else if (word == "--size") {
            if (std::sscanf(value().c_str(), "%ux%u", &options.size.x, &options.size.y) != 2)
                throw std::runtime_error("--size wants WxH");
        } else if (word == "--samples") options.samples = static_cast<uint32_t>(std::stoul(value()));
        else if (word == "--set") options.set.push_back(value());
        else if (word == "--ao") options.occlusion = true;
        else if (word == "--checkerboard") options.checkerboard = true;
        else if (word == "--robust") options.robust = true;
        else if (word == "--packets") options.packets = true;
        else if (word == "--pictures") options.pictures = true;
        else if (word == "--out") options.out = value();
        else if (word == "--bar") options.bar = std::stod(value());
        else if (word.starts_with("--")) throw std::runtime_error("unknown option " + word);
        else options.scenes.push_back(word);
    }
    return options;
}

int run(const Options& options) {
    std::vector<Row> all = rows();
    if (!options.scenes.empty()) {
        std::vector<Row> chosen;
        for (const std::string& scene : options.scenes) {
            Row row{scene, std::filesystem::path(scene).has_extension() ? FOREIGN : OWN};
            for (const Row& known : all)
                if (label(known) == scene) row = known;
            chosen.push_back(row);
        }
        all = chosen;
    }
    std::unique_ptr<Device> embree = makeEmbreeDevice();
    std::unique_ptr<Device> other = options.device == "embree" ? makeEmbreeDevice() : makeVulkanDevice(options.device);
    std::printf("embree against %s (%s), %ux%u, %u samples\n", other->info().name.c_str(), other->info().details.c_str(),
                options.size.x, options.size.y, options.samples);
    int passed = 0, failed = 0;
    for (const Row& row : all) {
        try {
            (runRow(row, options, *embree, *other) ? passed : failed)++;
        } catch (const std::exception& error) {
            std::printf("FAILED %-24s %s\n", label(row).c_str(), error.what());
            failed++;
        }
    }
    std::printf("%d passed, %d failed\n", passed, failed);
    return failed == 0 && passed > 0 ? 0 : 1;
}

}  // namespace
}  // namespace heliograph

int main(int argc, char** argv) {
    try {
        return heliograph::run(heliograph::parse(argc, argv));
    } catch (const std::exception& error) {
        std::fprintf(stderr, "parity: %s\n", error.what());
        return 2;
    }
}
