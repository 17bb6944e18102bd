#include "server/app/render_command.h"

#include "server/app/devices.h"
#include "server/base/output_file.h"
#include "server/base/progress_bar.h"
#include "server/base/clock.h"
#include "server/base/error.h"
#include "server/base/text.h"
#include "server/encode/exr_encoder.h"
#include "server/encode/jpeg_encoder.h"
#include "server/encode/png_encoder.h"
#include "server/encode/tone_map.h"
#include "server/images/image_module.h"
#include "server/render/frame_renderer.h"
#include "server/film/stats.h"
#include "server/scene/load/scene_source.h"

#include <iostream>
#include <memory>

namespace heliograph {

namespace {

constexpr uint32_t DEFAULT_SAMPLES = 16;

struct Milliseconds {
    double load = 0.0, build = 0.0, render = 0.0;
};

struct RenderResult {
    std::string scene;
    std::string device;
    FrameRequest request;
    Milliseconds ms;
    FrameStats stats;
};

enum class Format { png, exr, jpeg };

Format formatOf(const OutputFile& file) {
    std::string extension = file.extension();
    if (extension == "png") return Format::png;
    if (extension == "exr") return Format::exr;
    if (extension == "jpg" || extension == "jpeg") return Format::jpeg;
    throw InputError("--out " + file.path(), "unknown format '" + extension + "'", "a name that ends in .png, .exr or .jpg");
}

GivenSettings settingsOf(const RenderOptions& options) {
    GivenSettings given = givenSettings(options);
    if (options.samples) given.settings.set("samples", *options.samples);
    else if (!given.has("samples")) given.settings.samples = DEFAULT_SAMPLES;
    return given;
}

std::vector<uint8_t> encoded(const Film& film, Format format, const Settings& settings, float sceneExposure) {
    std::vector<vec4> pixels;
    film.develop(pixels);
    std::vector<uint8_t> bytes;
    if (format == Format::exr) {
        encodeExr(pixels, film.resolution(), bytes);
        return bytes;
    }
    DisplayImage image;
    const ToneMap toneMap(sceneExposure + settings.exposure, static_cast<ToneCurve>(settings.toneCurve));
    toneMap.apply(pixels, film.resolution(), image);
    std::unique_ptr<Encoder> encoder = format == Format::png ? makePngEncoder() : makeJpegEncoder();
    encoder->encode(image, settings.jpegQuality, bytes);
    return bytes;
}

nlohmann::ordered_json toJson(const RenderResult& r) {
    nlohmann::ordered_json tiles = nlohmann::ordered_json::object();
    for (const auto& [device, count] : r.stats.tiles) tiles[device] = count;
    return {{"scene", r.scene},
            {"device", r.device},
            {"width", r.request.resolution.x},
            {"height", r.request.resolution.y},
            {"samples", r.stats.samples},
            {"effects", effectNames(r.request.effects)},
            {"ms", {{"load", r.ms.load}, {"build", r.ms.build}, {"render", r.ms.render}}},
            {"rays", toJson(r.stats.rays)},
            {"tiles", tiles},
            {"nonfinite_samples", r.stats.nonfiniteSamples}};
}

void printForPeople(const RenderResult& r, const std::string& file, std::ostream& out) {
    double seconds = r.ms.render / 1e3;
    double rate = seconds > 0.0 ? static_cast<double>(r.stats.rays.total()) / seconds / 1e6 : 0.0;
    char line[256];
    std::snprintf(line, sizeof line, "%ux%u, %u samples per pixel on %s: load %.0f ms, build %.0f ms, render %.0f ms",
                  r.request.resolution.x, r.request.resolution.y, r.stats.samples, r.device.c_str(), r.ms.load, r.ms.build,
                  r.ms.render);
    out << file << ": " << r.scene << ", " << line << "\n";
    std::snprintf(line, sizeof line, "%llu rays, %.1f million a second", static_cast<unsigned long long>(r.stats.rays.total()),
                  rate);
    out << line << "\n";
    if (r.stats.nonfiniteSamples > 0) out << r.stats.nonfiniteSamples << " samples were no numbers and are left out\n";
}

}  // namespace

int runRender(const RenderOptions& options, std::ostream& out) {
    GivenSettings given = settingsOf(options);
    const uvec2 resolution = renderedSize(parsedSize(options.size), given.settings);
    const OutputFile file("--out", options.out);
    const Format format = formatOf(file);
    if (format == Format::exr) imageModule();  // if it is missing, that is said before any work

    RenderResult result;
    Film film;
    std::shared_ptr<const Scene> scene;
    {
        ProgressBar bar;
        StopWatch watch;
        scene = openScene(options.scene, options.environment, bar.progress());
        result.ms.load = watch.milliseconds();
        const Camera camera = chosenCamera(*scene, options.camera, given);
        std::optional<Camera> previous;
        if (!options.previousCamera.empty()) {
            GivenSettings apart = given;  // the picture keeps its own field of view
            previous = chosenCamera(*scene, options.previousCamera, apart, "--previous-camera");
        }

        watch.restart();
        std::unique_ptr<Renderer> device = makeRenderer(given.settings);
        device->load(scene, given.settings, bar.progress());
        result.ms.build = watch.milliseconds();

        result.request = frameRequest(*scene, camera, given.settings, resolution, 1);
        result.request.previousCamera = previous;
        result.stats = renderFrame(*device, result.request, given.settings.samples, film, {}, bar.progress());
        result.ms.render = result.stats.milliseconds;
        result.scene = scene->name;
        result.device = device->info().name;
    }
    file.write(encoded(film, format, given.settings, scene->exposure));
    for (const std::string& warning : scene->warnings) std::cerr << "warning: " << oneLine(warning) << "\n";
    if (options.json) out << toJson(result).dump(2, ' ', false, nlohmann::json::error_handler_t::replace) << "\n";
    else printForPeople(result, options.out, out);
    return 0;
}

void addRenderCommand(CLI::App& app, std::function<int()>& run) {
    auto options = std::make_shared<RenderOptions>();
    CLI::App* command = app.add_subcommand("render", "Render a picture of a scene into a file");
    addSceneArgument(*command, *options);
    command
        ->add_option("--out", options->out,
                     "File to write: .png or .jpg as the viewer shows it, .exr the linear float values of the film")
        ->type_name("FILE")
        ->required();
    command->add_option("--samples", options->samples, "Samples per pixel, 1 to 65536; without it 16")->type_name("N");
    addCameraOption(*command, *options);
    command
        ->add_option("--previous-camera", options->previousCamera,
                     "The scene's camera at which it was a frame ago, for motionBlur; without it the camera rests")
        ->type_name("NAME");
    addRenderOptions(*command, *options);
    addJsonOption(*command, *options);
    command->footer(
        "Examples:\n"
        "  heliograph render courtyard --out courtyard.png\n"
        "  heliograph render model.glb --out model.exr --size 1920x1080 --samples 256\n"
        "  heliograph render glass --out glass.jpg --set exposure=0.5 --set maxReflections=4\n"
        "The same command writes the same file, whatever the number of threads and the size of the tiles.\n"
        "jpegQuality is the quality of a .jpg; renderScale makes the picture smaller than --size.\n\n" +
        settingsHelp());
    command->callback([&run, options] { run = [options] { return runRender(*options, std::cout); }; });
}

}  // namespace heliograph
