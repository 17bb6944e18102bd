// How models from the web look at once, at default settings as the page has them: looks [options] [FILE...]
//   --size WxH, --samples N     320x180, 16
//   --out FOLDER                a picture of each, as a PNG
//   --sheet FILE                all of them on one sheet
//   --set NAME=VALUE            as of the other commands
// A row per model of ../shared/scenes/gltf, or of the files given: how much of the picture's tighter side its object takes, how
// many of its pixels lie on the picture's edge, the share of them that is white, the mean of their codes and that of its base
// colours. The last line is `N passed, N failed`, as ./check counts it. A camera that the file brings is its author's: its
// framing is told, not judged.

#include "server/device/embree/embree_device.h"
#include "server/encode/png_encoder.h"
#include "server/encode/tone_map.h"
#include "server/film/exposure.h"
#include "server/render/frame_renderer.h"
#include "server/request/surroundings.h"
#include "server/scene/framing.h"
#include "server/scene/load/scene_source.h"
#include "server/scene/material_layers.h"
#include "tests/support/direct_renderer.h"
#include "tests/support/places.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <optional>

namespace heliograph {
namespace {

namespace fs = std::filesystem;

constexpr double LEAST_FILL = 75.0, MOST_FILL = 92.0;  // per cent of the tighter side
constexpr double MOST_WHITE = 4.0;                     // per cent of the object's pixels
constexpr double LEAST_MEAN = 0.25, MOST_MEAN = 0.6;   // of the object's codes, 0..1
constexpr float COAT_REFLECTS = 0.092f;  // Fresnel's reflectance at index 1.5, its mean over a hemisphere by the cosine
constexpr double DARKEST = 0.6;          // of the base colours' own mean, that a model may be; no brighter than that
constexpr uint8_t WHITE = 253;           // least code of all channels of a white pixel

struct Options {
    uvec2 size{320, 180};
    uint32_t samples = 16;
    std::string out, sheet;
    Settings settings;
    std::vector<std::string> files;
};

struct Look {
    std::string name;
    DisplayImage image;
    std::vector<bool> object;  // by pixel: a surface is seen in its middle
    bool ownCamera = false;
    std::optional<float> exposure;
    double base = 0.0;  // mean code of the object's base colours, 0..1

    uint32_t count() const { return static_cast<uint32_t>(std::count(object.begin(), object.end(), true)); }
};

/// The first glTF file in each folder.
std::vector<std::string> sharedModels() {
    std::vector<std::string> files;
    const fs::path folder = sharedScenes() / "gltf";
    if (!fs::is_directory(folder)) return files;
    for (const auto& model : fs::directory_iterator(folder)) {
        std::vector<std::string> found;
        for (const auto& entry : fs::recursive_directory_iterator(model.path()))
            if (entry.path().extension() == ".gltf" || entry.path().extension() == ".glb")
                found.push_back(entry.path().string());
        std::sort(found.begin(), found.end());
        if (!found.empty()) files.push_back(found.front());
    }
    std::sort(files.begin(), files.end());
    return files;
}

double codeOf(const uint8_t* rgb) { return (0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]) / 255.0; }

/// What the object's base colours look like by themselves: every surface unlit, no curve. A clear coat whitens what is under it
/// by what its glass reflects of even light.
double baseOf(const Scene& scene, const Look& look, const Camera& camera, const Options& options, Device& device) {
    auto unlit = std::make_shared<Scene>(scene);
    for (Material& material : unlit->materials) {
        material.flags |= MATERIAL_UNLIT;
        material.emission = vec4(0.0f);
        const float coat = COAT_REFLECTS * layersOf(scene, material).coat;
        material.baseColor = vec4(glm::mix(vec3(material.baseColor), vec3(1.0f), coat), material.baseColor.w);
    }
    Settings settings;
    device.load(unlit, settings, {});
    test::DirectRenderer renderer(device);
    Film film;
    renderFrame(renderer, frameRequest(*unlit, camera, settings, options.size, 1), 1, film);
    std::vector<vec4> pixels;
    film.develop(pixels);
    DisplayImage image;
    ToneMap(0.0f, ToneCurve::linear).apply(pixels, options.size, image);
    double sum = 0.0;
    for (size_t i = 0; i < look.object.size(); i++) sum += look.object[i] ? codeOf(&image.rgba[i * 4]) : 0.0;
    return look.count() > 0 ? sum / look.count() : 0.0;
}

Look lookOf(const std::string& file, const Options& options) {
    static const std::unique_ptr<Device> device = makeEmbreeDevice();
    const std::shared_ptr<const Scene> scene = openScene(file);
    const double aspect = double(options.size.x) / options.size.y;
    const Camera camera = checkedCamera(cameraFrom(startCamera(*scene, aspect)));
    device->load(scene, options.settings, {});
    test::DirectRenderer renderer(*device);
    const FrameRequest request = frameRequest(*scene, camera, options.settings, options.size, 1);
    Film film;
    renderFrame(renderer, request, options.samples, film);

    Look look;
    look.name = fs::path(file).stem().string();
    look.ownCamera = scene->cameras.front().name != "default";
    if (exposesViews(options.settings, *scene))
        look.exposure = meteredExposure(film, plainBackdrop(*scene, options.settings, request.effects));
    std::vector<vec4> pixels;
    film.develop(pixels);
    const float exposure = options.settings.exposure + scene->exposure + look.exposure.value_or(0.0f);
    const ToneMap map(exposure, shownCurve(static_cast<ToneCurve>(options.settings.toneCurve), scene->fromFile));
    map.apply(pixels, options.size, look.image);
    for (uint32_t y = 0; y < options.size.y; y++) {
        for (uint32_t x = 0; x < options.size.x; x++) {
            const ViewRay ray = viewRay(camera, aspect, (x + 0.5) / options.size.x, (y + 0.5) / options.size.y);
            look.object.push_back(device->depthAlong(ray).depth.has_value());
        }
    }
    look.base = baseOf(*scene, look, camera, options, *device);
    return look;
}

struct Figures {
    double fill = 0.0;  // per cent of the tighter side
    uint32_t cut = 0;
    double white = 0.0;  // per cent
    double mean = 0.0;
};

Figures figuresOf(const Look& look) {
    Figures f;
    const uint32_t width = look.image.width, height = look.image.height;
    uvec2 low(width, height), high(0);
    uint32_t white = 0;
    double sum = 0.0;
    for (uint32_t y = 0; y < height; y++) {
        for (uint32_t x = 0; x < width; x++) {
            const size_t i = static_cast<size_t>(y) * width + x;
            if (!look.object[i]) continue;
            low = glm::min(low, uvec2(x, y));
            high = glm::max(high, uvec2(x + 1, y + 1));
            f.cut += x == 0 || y == 0 || x + 1 == width || y + 1 == height ? 1 : 0;
            const uint8_t* rgb = &look.image.rgba[i * 4];
            white += std::min({rgb[0], rgb[1], rgb[2]}) >= WHITE ? 1 : 0;
            sum += codeOf(rgb);
        }
    }
    if (look.count() == 0) return f;
    f.fill = 100.0 * std::max(double(high.x - low.x) / width, double(high.y - low.y) / height);
    f.white = 100.0 * white / look.count();
    f.mean = sum / look.count();
    return f;
}

/// What is out of bounds, or "".
std::string faultsOf(const Look& look, const Figures& f) {
    std::string faults;
    const auto fault = [&](bool wrong, const char* what) {
        if (wrong) faults += std::string(faults.empty() ? "" : ", ") + what;
    };
    fault(!look.ownCamera && (f.fill < LEAST_FILL || f.fill > MOST_FILL), "size");
    fault(!look.ownCamera && f.cut > 0, "cut");
    fault(f.white > MOST_WHITE, "white");
    // A white model is bright and a black one dark: light may not make more or much less of them than their authors did.
    const bool dark = f.mean<std::min(LEAST_MEAN, DARKEST * look.base), bright = f.mean> std::max(MOST_MEAN, look.base);
    fault(dark || bright, dark ? "too dark" : "too bright");
    return faults;
}

void writePng(const DisplayImage& image, const fs::path& file) {
    std::vector<uint8_t> bytes;
    makePngEncoder()->encode(image, 0, bytes);
    std::ofstream(file, std::ios::binary).write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
}

void writeSheet(const std::vector<Look>& looks, const std::string& file) {
    constexpr uint32_t COLUMNS = 6;
    if (looks.empty()) return;
    const uint32_t w = looks.front().image.width, h = looks.front().image.height;
    const auto rows = static_cast<uint32_t>((looks.size() + COLUMNS - 1) / COLUMNS);
    DisplayImage sheet;
    sheet.width = COLUMNS * w;
    sheet.height = rows * h;
    sheet.rgba.assign(static_cast<size_t>(sheet.width) * sheet.height * 4, 255);
    for (size_t i = 0; i < looks.size(); i++)
        for (uint32_t y = 0; y < h; y++)
            std::memcpy(&sheet.rgba[((i / COLUMNS * h + y) * size_t(sheet.width) + i % COLUMNS * w) * 4],
                        &looks[i].image.rgba[size_t(y) * w * 4], size_t(w) * 4);
    writePng(sheet, file);
}

Options parsed(int argc, char** argv) {
    Options options;
    for (int i = 1; i < argc; i++) {
        const std::string word = argv[i];
        const auto value = [&] { return i + 1 < argc ? std::string(argv[++i]) : std::string(); };
        if (word == "--size") std::sscanf(value().c_str(), "%ux%u", &options.size.x, &options.size.y);
        else if (word == "--samples") options.samples = static_cast<uint32_t>(std::stoul(value()));
        else if (word == "--out") options.out = value();
        else if (word == "--sheet") options.sheet = value();
        else if (word == "--set") options.settings.setFromText(value());
        else options.files.push_back(word);
    }
    return options;
}

int compare(const Options& options) {
    const std::vector<std::string> files = options.files.empty() ? sharedModels() : options.files;
    if (files.empty()) std::printf("no models: %s is not there\n", (sharedScenes() / "gltf").c_str());
    if (!options.out.empty()) fs::create_directories(options.out);
    uint32_t passed = 0, failed = 0;
    std::vector<Look> looks;
    std::printf("%-32s %6s %5s %7s %6s %6s %8s\n", "model", "fill %", "cut", "white %", "mean", "base", "exposure");
    for (const std::string& file : files) {
        Look look = lookOf(file, options);
        if (look.count() == 0) {
            std::printf("%-32s nothing to see\n", look.name.c_str());
            continue;
        }
        const Figures f = figuresOf(look);
        const std::string faults = faultsOf(look, f);
        (faults.empty() ? passed : failed)++;
        std::printf("%-32s %6.1f %5u %7.2f %6.3f %6.3f %8s%s%s\n", look.name.c_str(), f.fill, f.cut, f.white, f.mean, look.base,
                    look.exposure ? std::to_string(*look.exposure).substr(0, 6).c_str() : "",
                    look.ownCamera ? " own camera" : "", faults.empty() ? "" : ("  FAILED: " + faults).c_str());
        if (!options.out.empty()) writePng(look.image, fs::path(options.out) / (look.name + ".png"));
        if (!options.sheet.empty()) looks.push_back(std::move(look));
    }
    if (!options.sheet.empty()) writeSheet(looks, options.sheet);
    std::printf("%u passed, %u failed\n", passed, failed);
    return failed > 0 ? 1 : 0;
}

}  // namespace
}  // namespace heliograph

int main(int argc, char** argv) {
    try {
        return heliograph::compare(heliograph::parsed(argc, argv));
    } catch (const std::exception& error) {
        std::cerr << error.what() << "\n";
        return 1;
    }
}
