#include "server/viewer/messages.h"

#include "server/scene/framing.h"

#include "server/encode/video_encoder.h"
#include "server/pace/bottleneck.h"
#include "server/pace/quality_ladder.h"
#include "server/request/device_rows.h"
#include "server/request/effect_rules.h"
#include "server/base/version.h"

#include <algorithm>
#include <cmath>

namespace heliograph {

namespace {

using nlohmann::json;

json array(vec3 v) { return json::array({v.x, v.y, v.z}); }

template <typename AnyCamera>
json cameraJson(const AnyCamera& camera) {
    json fields = {{"position", array(camera.position)},
                   {"forward", array(camera.forward)},
                   {"up", array(camera.up)},
                   {"fieldOfView", camera.fieldOfView}};
    if constexpr (requires { camera.name; }) fields["name"] = camera.name;
    return fields;
}

/// Names from files may hold bytes that are no UTF-8; a browser closes the connection over those.
std::string text(const json& message) { return message.dump(-1, ' ', false, json::error_handler_t::replace); }

/// JSON has no infinity; figures that were never measured are 0.
double finite(double value) { return std::isfinite(value) ? value : 0.0; }

const char* codecWord(FrameCodec codec) {
    switch (codec) {
        case FrameCodec::vp9: return "vp9";
        case FrameCodec::h264: return "h264";
        default: return "jpeg";
    }
}

/// Those that this program makes.
json videos() {
    json names = json::array();
    if (videoBuilt(VideoCodec::vp9)) names.push_back("vp9");
    if (videoBuilt(VideoCodec::h264)) names.push_back("h264");
    return names;
}

/// What pictures are made smaller or worse for, and by how much.
json paceJson(const LineFigures& line, const ScaleFigures& scale) {
    const PaceFigures figures{scale.step > 0, line.level, line.lineDelay, line.viewerDelay, line.forLine};
    return {{"limit", wordOf(bottleneckOf(figures))},
            {"scale", scaleOf(scale.step + scaleStepsAt(line.level))},
            {"quality", line.quality},
            {"codec", codecWord(line.codec)},
            {"fullMs", 1e3 * finite(scale.fullSeconds)},
            {"roundTripMs", 1e3 * finite(line.roundTrip)},
            {"lineMs", 1e3 * finite(line.lineDelay)},
            {"viewerMs", 1e3 * finite(line.viewerDelay)},
            {"bytesPerSecond", finite(line.bytesPerSecond)}};
}

/// Who took part in a pass, who did not and why.
json partsJson(const ScheduleReport& report) {
    double total = 0.0;
    for (const DeviceReport& device : report.devices) total += device.cost;
    json parts = json::array();
    for (uint32_t d = 0; d < report.devices.size(); d++) {
        const DeviceReport& device = report.devices[d];
        double idle = 0.0;
        uint32_t workers = 0;
        for (const WorkerReport& worker : report.workers) {
            if (worker.device != d) continue;
            idle += report.idleShare(worker);
            workers++;
        }
        parts.push_back({{"device", device.name},
                         {"part", device.partWord()},
                         {"reason", device.part.reason},
                         {"mraysPerSecond", 1e-6 * finite(device.rate)},
                         {"share", total > 0.0 ? device.cost / total : 0.0},
                         {"idleShare", workers > 0 ? finite(idle / workers) : 1.0}});
    }
    return parts;
}

/// How the error goes on: nothing while that is not known.
json forecastJson(const ErrorForecast& forecast) {
    constexpr size_t STEPS = 3;
    if (forecast.samples == 0) return nullptr;
    json steps = json::array();
    for (double error : roundErrorsBelow(forecast.error, STEPS)) {
        const std::optional<double> samples = forecast.samplesUntil(error), seconds = forecast.secondsUntil(error);
        if (!samples) break;
        steps.push_back(
            {{"error", error}, {"samples", std::ceil(*samples)}, {"seconds", seconds ? json(finite(*seconds)) : json()}});
    }
    return {{"plateau", forecast.plateau}, {"steps", steps}};
}

/// What pictures of a moving view do without; nothing without a budget.
json autopilotJson(const AutopilotFigures& figures) {
    if (!(figures.budget > 0.0)) return nullptr;
    json steps = json::array();
    for (const AutopilotFigures::Step& step : figures.steps) {
        steps.push_back({{"setting", step.setting},
                         {"before", step.before},
                         {"after", step.after},
                         {"msWithout", 1e3 * finite(step.secondsWithout)}});
    }
    return {{"budgetMs", 1e3 * figures.budget},
            {"ms", 1e3 * finite(figures.seconds)},
            {"scale", scaleOf(figures.step)},
            {"steps", steps}};
}

/// The offered words of the setting `device` that mean a device of this row.
std::vector<std::string> wordsOf(const DeviceRow& row, const std::vector<std::string>& offered) {
    std::vector<std::string> words;
    for (const std::string& word : offered)
        if (deviceRow(word) == &row) words.push_back(word);
    return words;
}

}  // namespace

std::string helloMessage(uint32_t viewer, const std::string& view, const std::string& key,
                         const std::vector<SceneRecipe>& scenes, const std::vector<std::string>& devices,
                         const SettingCaps& caps) {
    json schema = cappedSchema(caps);
    for (json& row : schema) {
        if (row["name"] == "device") row["choices"] = devices;
    }
    json kinds = json::array();
    for (const DeviceRow& row : deviceRows())
        kinds.push_back({{"name", row.name},
                         {"words", wordsOf(row, devices)},
                         {"kind", row.kindWord},
                         {"side", row.sideWord},
                         {"bit", row.bit}});
    json offered = json::array();
    for (const SceneRecipe& scene : scenes) offered.push_back({{"name", scene.name}, {"description", scene.description}});
    return text({{"type", "hello"},
                 {"protocol", PROTOCOL_NAME},
                 {"server", programVersion()},
                 {"viewer", viewer},
                 {"view", view},
                 {"key", key},
                 {"schema", schema},
                 {"devices", kinds},
                 {"scenes", offered},
                 {"videos", videos()},
                 {"maxUnacked", MAX_UNACKED}});
}

std::string sceneLoadingMessage(const std::string& name, const std::string& what, double share) {
    return text({{"type", "scene"},
                 {"name", name},
                 {"state", "loading"},
                 {"what", what},
                 {"share", std::clamp(finite(share), 0.0, 1.0)}});
}

std::string sceneReadyMessage(const std::string& name, const Scene& scene, const std::vector<EffectReason>& reasons,
                              double aspect) {
    json cameras = json::array(), paths = json::array(), effects = json::array();
    for (const NamedCamera& camera : scene.cameras) cameras.push_back(cameraJson(camera));
    if (!cameras.empty()) cameras[0] = cameraJson(startCamera(scene, aspect));
    for (const CameraPath& path : scene.paths) paths.push_back(path.name);
    for (const EffectReason& row : reasons) {
        effects.push_back({{"name", row.name},
                           {"calledFor", row.calledFor},
                           {"choice", row.choice},
                           {"because", row.because},
                           {"setting", row.setting},
                           {"help", row.help},
                           {"simulated", row.simulated}});
    }
    json bounds = nullptr;
    if (!scene.bounds.empty()) bounds = {{"low", array(scene.bounds.low)}, {"high", array(scene.bounds.high)}};
    return text({{"type", "scene"},
                 {"name", name},
                 {"state", "ready"},
                 {"camera", cameras.empty() ? json() : cameras[0]},
                 {"cameras", cameras},
                 {"paths", paths},
                 {"variants", scene.variants.names},
                 {"variant", scene.variants.chosen ? json(*scene.variants.chosen) : json()},
                 {"bounds", bounds},
                 {"triangles", scene.triangleCount()},
                 {"instances", scene.instances.size()},
                 {"lights", scene.lights.size()},
                 {"warnings", scene.warnings},
                 {"effects", effects},
                 {"radius", scene.bounds.radius()}});
}

std::string sceneFailedMessage(const std::string& name, const std::string& why) {
    return text({{"type", "scene"}, {"name", name}, {"state", "failed"}, {"what", why}});
}

std::string settingsMessage(const json& values, std::optional<uint32_t> inputId) {
    json message = {{"type", "settings"}, {"values", values}};
    if (inputId) message["inputId"] = *inputId;
    return text(message);
}

std::string statsMessage(const ViewerStats& s) {
    json ms = {{"render", finite(s.ms.render)},
               {"develop", finite(s.ms.develop)},
               {"encode", finite(s.ms.encode)},
               {"queue", finite(s.ms.queue)},
               {"send", finite(s.ms.send)}};
    json message = {{"type", "stats"},
                    {"device", s.device},
                    {"framesPerSecond", finite(s.framesPerSecond)},
                    {"samples", s.samples},
                    {"targetSamples", s.targetSamples},
                    {"relativeError", finite(s.relativeError)},
                    {"forecast", forecastJson(s.forecast)},
                    {"refined", finite(s.refined)},
                    {"autoExposure", s.autoExposure ? json(*s.autoExposure) : json()},
                    {"rays", toJson(s.rays)},
                    {"mraysPerSecond", finite(s.mraysPerSecond)},
                    {"ms", ms},
                    {"overheadShare", finite(s.overheadShare)},
                    {"deviceShare", finite(s.deviceShare)},
                    {"tiles", s.tiles},
                    {"viewers", s.viewers},
                    {"watchers", s.watchers},
                    {"residentBytes", s.residentBytes},
                    {"nonfiniteSamples", s.nonfiniteSamples},
                    {"pace", paceJson(s.line, s.scale)},
                    {"autopilot", autopilotJson(s.autopilot)}};
    if (!s.pool.is_null()) message["pool"] = s.pool;
    if (!s.schedule.devices.empty()) {
        message["parts"] = partsJson(s.schedule);
        message["scheduler"] = {{"endLossMs", 1e3 * finite(s.schedule.endLoss())},
                                {"decisionMs", 1e3 * finite(s.schedule.decisionSeconds)},
                                {"batches", s.schedule.batches},
                                {"reissued", s.schedule.reissued}};
    }
    return text(message);
}

std::string errorsMessage(uint32_t frameId, const ErrorMap& errors) {
    json cells = json::array();
    for (float error : errors.cells) {
        cells.push_back(error < 0.0f ? json() : json(std::lround(1e4 * std::min(finite(static_cast<double>(error)), 100.0))));
    }
    return text({{"type", "errors"},
                 {"frameId", frameId},
                 {"width", errors.resolution.x},
                 {"height", errors.resolution.y},
                 {"cellWidth", errors.cellSize.x},
                 {"cellHeight", errors.cellSize.y},
                 {"cells", cells}});
}

std::string partitionMessage(uint32_t frameId, const Partition& p, const ScheduleReport& schedule) {
    constexpr char DIGITS[] = "0123456789abcdefghijklmnopqrstuvwxyz";
    std::string cells;
    for (uint8_t maker : p.makers) cells += maker < sizeof DIGITS - 1 ? DIGITS[maker] : '.';
    json workers = json::array();
    auto ms = [&](double at) { return 1e3 * finite(at - schedule.begin); };
    for (const WorkerReport& worker : schedule.workers) {
        json batches = json::array();
        for (const WorkerReport::Span& span : worker.batches) batches.push_back({ms(span.begin), ms(span.end), span.tiles});
        workers.push_back({{"device", schedule.devices[worker.device].name}, {"worker", worker.stream}, {"batches", batches}});
    }
    return text({{"type", "partition"},
                 {"frameId", frameId},
                 {"width", p.resolution.x},
                 {"height", p.resolution.y},
                 {"cellWidth", p.cellSize.x},
                 {"cellHeight", p.cellSize.y},
                 {"devices", p.devices},
                 {"cells", cells},
                 {"timeline", {{"ms", ms(schedule.end)}, {"workers", workers}}}});
}

std::string pathMessage(bool playing, const std::optional<FrameSummary>& result) {
    json message = {{"type", "path"}, {"playing", playing}};
    if (result) {
        message["result"] = {
            {"frames", result->frames},       {"msMean", finite(result->msMean)},   {"msMedian", finite(result->msMedian)},
            {"msP95", finite(result->msP95)}, {"fpsMean", finite(result->fpsMean)}, {"fpsMin", finite(result->fpsMin)}};
    }
    return text(message);
}

std::string effectCostsMeasuringMessage(double share) {
    return text({{"type", "effectCosts"}, {"state", "measuring"}, {"share", std::clamp(finite(share), 0.0, 1.0)}});
}

std::string effectCostsReadyMessage(const EffectCosts& costs) {
    json rows = json::array();
    for (const EffectCost& row : costs.rows) {
        rows.push_back({{"name", row.name},
                        {"onMs", finite(row.onMs)},
                        {"lowMs", finite(row.lowMs)},
                        {"highMs", finite(row.highMs)},
                        {"offMs", finite(row.offMs)},
                        {"raysOn", row.raysOn},
                        {"raysOff", row.raysOff}});
    }
    return text({{"type", "effectCosts"},
                 {"state", "ready"},
                 {"scene", costs.scene},
                 {"device", costs.device},
                 {"width", costs.size.x},
                 {"height", costs.size.y},
                 {"scale", finite(costs.scale)},
                 {"rows", rows}});
}

std::string effectCostsFailedMessage(const std::string& why) {
    return text({{"type", "effectCosts"}, {"state", "failed"}, {"what", why}});
}

std::string pickedMessage(uint32_t id, const std::optional<Picked>& picked) {
    json message = {{"type", "picked"}, {"id", id}, {"found", picked.has_value()}};
    if (!picked) return text(message);
    message["object"] = picked->object;
    message["material"] = picked->material;
    message["distance"] = finite(picked->distance);
    message["depth"] = finite(picked->depth);
    message["position"] = array(vec3(picked->position));
    message["normal"] = array(vec3(picked->normal));
    return text(message);
}

std::string resolutionMessage(uvec2 wanted, uvec2 given, uint32_t inputId) {
    const std::string words = "The picture has " + std::to_string(given.x) + " x " + std::to_string(given.y) + " pixels, not " +
                              std::to_string(wanted.x) + " x " + std::to_string(wanted.y) +
                              ": the memory for pictures of all viewers does not suffice.";
    return text({{"type", "resolution"},
                 {"wanted", {wanted.x, wanted.y}},
                 {"given", {given.x, given.y}},
                 {"text", words},
                 {"inputId", inputId}});
}

std::string watchingMessage(const std::string& view, bool drives, const Camera* camera, std::optional<uint32_t> inputId) {
    json message = {{"type", "watching"}, {"view", view}, {"drives", drives}};
    if (camera) message["camera"] = cameraJson(*camera);
    if (inputId) message["inputId"] = *inputId;
    return text(message);
}

std::string driveAskedMessage(uint32_t viewer) { return text({{"type", "driveAsked"}, {"viewer", viewer}}); }

std::string noticeMessage(const std::string& words) { return text({{"type", "notice"}, {"text", words}}); }

std::string endingMessage(std::chrono::milliseconds atMost) {
    return text({{"type", "notice"}, {"text", "The server ends."}, {"endsInMs", atMost.count()}});
}

std::string errorMessage(const std::string& words, const std::string& about, std::optional<uint32_t> inputId) {
    json message = {{"type", "error"}, {"message", words}, {"about", about}};
    if (inputId) message["inputId"] = *inputId;
    return text(message);
}

std::string pongMessage(double time) { return text({{"type", "pong"}, {"time", time}}); }

}  // namespace heliograph
