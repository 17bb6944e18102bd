#include "server/app/render_command.h"

#include "server/app/devices.h"
#include "server/app/pool_devices.h"
#include "server/app/frame_range.h"
#include "server/app/picture_target.h"
#include "server/base/clock.h"
#include "server/base/error.h"
#include "server/base/json_text.h"
#include "server/base/progress_bar.h"
#include "server/base/text.h"
#include "server/encode/exr_encoder.h"
#include "server/encode/jpeg_encoder.h"
#include "server/encode/png_encoder.h"
#include "server/encode/tone_map.h"
#include "server/film/stats.h"
#include "server/images/image_module.h"
#include "server/render/denoise_pass.h"
#include "server/render/frame_renderer.h"
#include "server/request/surroundings.h"
#include "server/scene/load/scene_source.h"

#include <iostream>
#include <memory>

namespace heliograph {

namespace {

constexpr uint32_t DEFAULT_SAMPLES = 16;

struct Milliseconds {
    double load = 0.0, build = 0.0, render = 0.0, denoise = 0.0;
};

struct RenderResult {
    std::string scene;
    std::string device;
    FrameRequest request;
    Milliseconds ms;
    FrameStats stats;
    float exposure = 0.0f;  // EV, all that made the last picture what it is
};

GivenSettings settingsOf(const RenderOptions& options) {
    GivenSettings given = givenSettings(options);
    if (options.samples) given.settings.set("samples", *options.samples);
    else if (!given.has("samples")) given.settings.samples = DEFAULT_SAMPLES;
    return given;
}

std::vector<uint8_t> encoded(const std::vector<vec4>& pixels, uvec2 size, PictureFormat format, const Settings& settings,
                             float exposure, bool fromFile) {
    std::vector<uint8_t> bytes;
    if (format == PictureFormat::exr) {
        encodeExr(pixels, size, bytes);
        return bytes;
    }
    DisplayImage image;
    const ToneMap toneMap(exposure, shownCurve(static_cast<ToneCurve>(settings.toneCurve), fromFile));
    toneMap.apply(pixels, size, image);
    std::unique_ptr<Encoder> encoder = format == PictureFormat::png ? makePngEncoder() : makeJpegEncoder();
    encoder->encode(image, settings.jpegQuality, bytes);
    return bytes;
}

nlohmann::ordered_json toJson(const RenderResult& r) {
    nlohmann::ordered_json tiles = nlohmann::ordered_json::object();
    for (const auto& [device, count] : r.stats.tiles) tiles[device] = count;
    nlohmann::ordered_json json = {{"scene", r.scene},
                                   {"device", r.device},
                                   {"width", r.request.resolution.x},
                                   {"height", r.request.resolution.y},
                                   {"samples", r.stats.samples},
                                   {"exposure", r.exposure},
                                   {"effects", effectNames(r.request.effects)},
                                   {"ms", {{"load", r.ms.load}, {"build", r.ms.build}, {"render", r.ms.render}}},
                                   {"rays", toJson(r.stats.rays)},
                                   {"tiles", tiles},
                                   {"nonfinite_samples", r.stats.nonfiniteSamples}};
    if (r.ms.denoise > 0.0) json["ms"]["denoise"] = r.ms.denoise;
    return json;
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

/// A scene on a device, and what all its pictures have in common.
class Studio {
public:
    Studio(const RenderOptions& options, const PictureTarget& target)
        : given_(settingsOf(options)), resolution_(renderedSize(parsedSize(options.size), given_.settings)), target_(target) {}

    void open(const RenderOptions& options, const Progress& progress) {
        DenoisePass::wanted({{}, given_.settings});  // if it is missing, that is said before any work
        StopWatch watch;
        scene_ = openScene(sceneName(options), options.environment, progress, choosesSurroundings(given_.settings));
        result_.ms.load = watch.milliseconds();
        const double aspect = double(resolution_.x) / resolution_.y;
        camera_ = chosenCamera(*scene_, options.camera, given_, "--camera", aspect);
        if (!options.previousCamera.empty()) {
            GivenSettings apart = given_;  // the picture keeps its own field of view
            previous_ = chosenCamera(*scene_, options.previousCamera, apart, "--previous-camera", aspect);
        }
        result_.scene = scene_->name;
    }

    void build(const RenderOptions& options, const Progress& progress) {
        StopWatch watch;
        device_ =
            options.broker.url.empty() ? makeRenderer(given_.settings) : makePoolRenderer(options.broker, options.poolNodes);
        device_->load(scene_, given_.settings, progress);
        result_.ms.build = watch.milliseconds();
        result_.device = device_->info().name;
    }

    const Scene& scene() const { return *scene_; }
    const Camera& camera() const { return camera_; }
    const std::optional<Camera>& previous() const { return previous_; }
    const GivenSettings& given() const { return given_; }

    /// Renders and writes one picture; its own time is in `ms.render`.
    const RenderResult& picture(const Camera& camera, const std::optional<Camera>& previous, uint32_t frame,
                                const Progress& progress) {
        result_.request = frameRequest(*scene_, camera, given_.settings, resolution_, ++generation_);
        result_.request.previousCamera = previous;
        result_.stats = renderFrame(*device_, result_.request, given_.settings.samples, film_, {}, progress);
        result_.ms.render = result_.stats.milliseconds;
        result_.exposure = shownExposure(film_, *scene_, result_.request);
        film_.develop(pixels_);
        denoise();
        target_.write(
            encoded(pixels_, film_.resolution(), target_.format(), given_.settings, result_.exposure, scene_->fromFile), frame);
        return result_;
    }
    /// As far as it is known.
    const RenderResult& result() const { return result_; }

private:
    void denoise() {
        if (given_.settings.denoiser == 0) return;
        if (!canDenoise(result_.request)) {
            if (generation_ == 1) std::cerr << "warning: not denoised, as the lens or motion blurs the picture\n";
            return;
        }
        const StopWatch watch;
        PassRenderer passes;
        PassFigures figures;
        ViewMemory view;
        const auto denoised = denoiser_.run(passes, {*device_, result_.request, film_, view},
                                            Film::WHITE * std::exp2(-result_.exposure), figures);
        if (!denoised) throw InputError("denoiser", "with raster previews", "off: they have no grain");
        pixels_ = *denoised;
        result_.ms.denoise = watch.milliseconds();
    }

    GivenSettings given_;
    const uvec2 resolution_;
    const PictureTarget& target_;
    RenderResult result_;
    std::shared_ptr<const Scene> scene_;
    Camera camera_;
    std::optional<Camera> previous_;
    std::unique_ptr<Renderer> device_;
    uint32_t generation_ = 0;
    Film film_;
    std::vector<vec4> pixels_;
    DenoisePass denoiser_;
};

void warn(const Scene& scene) {
    for (const std::string& warning : scene.warnings) std::cerr << "warning: " << oneLine(warning) << "\n";
}

int renderPicture(Studio& studio, const RenderOptions& options, std::ostream& out) {
    {
        ProgressBar bar;
        studio.open(options, bar.progress());
        studio.build(options, bar.progress());
        studio.picture(studio.camera(), studio.previous(), 0, bar.progress());
    }
    warn(studio.scene());
    if (options.json) out << dumped(toJson(studio.result()));
    else printForPeople(studio.result(), options.out, out);
    return 0;
}

/// What `render --path` did.
struct Batch {
    FrameRange range;
    uint32_t skipped = 0;  // were there already
    double milliseconds = 0.0;
    uint64_t nonfiniteSamples = 0;
    nlohmann::ordered_json frames = nlohmann::ordered_json::array();
};

/// Those of the range that are still to be made.
std::vector<uint32_t> wantedFrames(const FrameRange& range, const PictureTarget& target, bool resume) {
    std::vector<uint32_t> wanted;
    for (uint32_t frame = range.first; frame <= range.last; frame++)
        if (!resume || !target.isThere(frame)) wanted.push_back(frame);
    return wanted;
}

/// Makes the frames, telling after each how long the rest will take.
void renderFrames(Studio& studio, const RenderOptions& options, const PictureTarget& target, Batch& batch) {
    const CameraPath& path = chosenPath(studio.scene(), options.path);
    batch.range = options.frames.empty() ? wholePath(path, options.framesPerSecond) : parsedFrames(options.frames);
    const std::vector<uint32_t> wanted = wantedFrames(batch.range, target, options.resume);
    batch.skipped = batch.range.count() - static_cast<uint32_t>(wanted.size());
    if (wanted.empty()) return;
    ProgressBar bar;
    studio.build(options, bar.progress());
    StopWatch watch;
    const auto count = static_cast<uint32_t>(wanted.size());
    for (uint32_t done = 0; done < count; done++) {
        const uint32_t frame = wanted[done];
        const std::optional<double> left = secondsLeft(done, count, watch.milliseconds() / 1e3);
        const std::string what = "frame " + std::to_string(frame) + " (" + std::to_string(done + 1) + " of " +
                                 std::to_string(count) + ")" + (left ? ", " + durationText(*left) + " left" : "");
        auto within = [&](const std::string&, double share) { report(bar.progress(), what, (done + share) / count); };
        const auto at = [&](int64_t f) { return cameraAtFrame(path, f, options.framesPerSecond, studio.camera().fieldOfView); };
        const RenderResult& made = studio.picture(at(frame), at(static_cast<int64_t>(frame) - 1), frame, within);
        if (!bar.visible()) std::cerr << what << ": " << durationText(made.ms.render / 1e3) << "\n";
        batch.milliseconds += made.ms.render;
        batch.nonfiniteSamples += made.stats.nonfiniteSamples;
        batch.frames.push_back({{"frame", frame},
                                {"file", target.name(frame)},
                                {"ms", made.ms.render},
                                {"nonfinite_samples", made.stats.nonfiniteSamples}});
    }
}

int renderPath(Studio& studio, const RenderOptions& options, const PictureTarget& target, std::ostream& out) {
    Batch batch;
    {
        ProgressBar bar;
        studio.open(options, bar.progress());
    }
    renderFrames(studio, options, target, batch);
    warn(studio.scene());
    if (options.json) {
        nlohmann::ordered_json json = toJson(studio.result());
        for (const char* ofOne : {"rays", "tiles"}) json.erase(ofOne);
        json["ms"]["render"] = batch.milliseconds;
        json["nonfinite_samples"] = batch.nonfiniteSamples;
        json["path"] = options.path;
        json["frames_per_second"] = options.framesPerSecond;
        json["first"] = batch.range.first;
        json["last"] = batch.range.last;
        json["skipped"] = batch.skipped;
        json["frames"] = batch.frames;
        out << dumped(json);
        return 0;
    }
    out << options.out << ": frames " << batch.range.first << " to " << batch.range.last << " of " << options.path << ", "
        << batch.frames.size() << " rendered in " << durationText(batch.milliseconds / 1e3) << ", " << batch.skipped
        << " were there\n";
    if (batch.nonfiniteSamples > 0) out << batch.nonfiniteSamples << " samples were no numbers and are left out\n";
    return 0;
}

/// What goes together only with --path.
void checkTogether(const RenderOptions& options) {
    if (options.path.empty()) {
        if (!options.frames.empty()) throw InputError("--frames", "without --path", "both, or neither");
        if (options.resume) throw InputError("--resume", "without --path", "both, or neither");
        return;
    }
    if (!options.previousCamera.empty())
        throw InputError("--previous-camera", "with --path, where each frame has its own", "one of both");
    if (options.resume && options.out == "-") throw InputError("--resume", "with --out -", "files, of which some are there");
    if (!(options.framesPerSecond >= 0.01 && options.framesPerSecond <= 1000.0))
        throw InputError("--fps", std::to_string(options.framesPerSecond), "0.01 to 1000");
    if (!options.frames.empty()) parsedFrames(options.frames);
}

}  // namespace

int runRender(const RenderOptions& options, std::ostream& out) {
    checkTogether(options);
    const PictureTarget target(options.out, options.format, !options.path.empty());
    Studio studio(options, target);
    if (target.format() == PictureFormat::exr) imageModule();  // if it is missing, that is said before any work
    std::ostream& words = target.toStdout() ? std::cerr : out;
    return options.path.empty() ? renderPicture(studio, options, words) : renderPath(studio, options, target, words);
}

void addRenderCommand(CLI::App& app, std::function<int()>& run) {
    auto options = std::make_shared<RenderOptions>();
    CLI::App* command = app.add_subcommand("render", "Render a picture of a scene into a file");
    addSceneArgument(*command, *options);
    command
        ->add_option(
            "--out", options->out,
            "File to write: .png or .jpg as the viewer shows it, .exr the linear float values of the film; with --path a\n"
            "name with %d or %04d for the frame. - is standard output")
        ->type_name("FILE")
        ->required();
    command->add_option("--format", options->format, "png, exr or jpg, whatever the file is called")->type_name("NAME");
    command->add_option("--samples", options->samples, "Samples per pixel, 1 to 65536; without it 16")->type_name("N");
    addCameraOption(*command, *options);
    command
        ->add_option("--previous-camera", options->previousCamera,
                     "The scene's camera at which it was a frame ago, for motionBlur; without it the camera rests")
        ->type_name("NAME");
    command->add_option("--path", options->path, "Render frames along this camera path of the scene")->type_name("NAME");
    command->add_option("--frames", options->frames, "First and last frame; without it the whole path")
        ->type_name("FIRST:LAST");
    command->add_option("--fps", options->framesPerSecond, "Frames a second of the path's time")
        ->type_name("N")
        ->capture_default_str();
    command->add_flag("--resume", options->resume, "Leave frames alone whose file is there");
    addRenderOptions(*command, *options);
    addPoolOptions(*command, options->broker, false);
    command->add_option("--pool-nodes", options->poolNodes, "Render nodes of the pool to wait for")
        ->check(CLI::Range(0, 4096))
        ->type_name("N");
    addJsonOption(*command, *options);
    command->footer(
        "Examples:\n"
        "  heliograph render courtyard --out courtyard.png\n"
        "  heliograph render model.glb --out model.exr --size 1920x1080 --samples 256\n"
        "  heliograph render glass --out glass.jpg --set exposure=0.5 --set maxReflections=4\n"
        "  heliograph render courtyard --path Walk --frames 0:59 --out frame.%04d.exr --resume\n"
        "  heliograph render courtyard --camera 0,2,8:0,1,0:50 --out - > courtyard.png\n"
        "The same command writes the same file, whatever the number of threads and the size of the tiles.\n"
        "jpegQuality is the quality of a .jpg; renderScale makes the picture smaller than --size.\n\n" +
        settingsHelp());
    command->callback([&run, options] { run = [options] { return runRender(*options, std::cout); }; });
}

}  // namespace heliograph
