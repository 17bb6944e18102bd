#pragma once
// What the server says in `heliograph.v1`: each function makes the text of one control message (docs/reference/protocol.md).

#include "server/request/effect_rules.h"
#include "server/request/picked.h"
#include "server/request/setting_caps.h"
#include "server/net/protocol.h"
#include "server/loop/effect_meter.h"
#include "server/loop/view_pace.h"
#include "server/film/film.h"
#include "server/film/partition.h"
#include "server/pace/error_forecast.h"
#include "server/schedule/schedule_report.h"
#include "server/loop/path_run.h"
#include "server/film/tile.h"
#include "server/scene/load/scene_source.h"

#include <chrono>
#include <map>

namespace heliograph {

/// Figures of one viewer over about the last half second. Milliseconds are means per frame sent.
/// What lies between server and eye, as it was measured.
struct LineFigures {
    double roundTrip = 0.0;               // seconds, the least of the last ten
    double bytesPerSecond = 0.0;          // the most that was delivered; no more than was sent
    double lineDelay = 0.0;               // seconds that pictures of a moving view queue on the line
    double viewerDelay = 0.0;             // and take longer in the viewer than they must
    uint32_t level = 0;                   // of the quality ladder
    uint32_t quality = 0;                 // JPEG quality while the view moves
    FrameCodec codec = FrameCodec::jpeg;  // of the last picture
    bool forLine = false;                 // pictures of a changing view are a video, as JPEG was too large for the line
};

struct ViewerStats {
    std::string device;  // that made the last frame
    double framesPerSecond = 0.0;
    uint32_t samples = 0;
    uint32_t targetSamples = 0;
    double relativeError = 1.0;
    ErrorForecast forecast;
    double refined = 1.0;               // part of the picture that still gets samples on the way to the error target
    std::optional<float> autoExposure;  // EV, where the picture chooses it
    RayCounts rays;                     // of the last pass
    double mraysPerSecond = 0.0;
    struct Milliseconds {
        double render = 0, develop = 0, encode = 0, queue = 0, send = 0;
    } ms;
    double overheadShare = 0.0;             // of the processor time: develop, encode, send against tracing; 0..1
    double deviceShare = 0.0;               // of the time that the device worked for anybody, 0..1
    std::map<std::string, uint64_t> tiles;  // by device; at rest those of the last frames
    size_t viewers = 0;
    size_t watchers = 0;            // of the view, beside who drives it
    uint64_t residentBytes = 0;     // of the server
    uint64_t nonfiniteSamples = 0;  // since the viewer connected
    ScheduleReport schedule;        // of the last pass of hybrid; else without devices
    LineFigures line;
    ScaleFigures scale;
    AutopilotFigures autopilot;
    nlohmann::ordered_json pool;  // what the server says of its render nodes; null: it has none
};

/// `devices`: the words of the setting `device` that the schema shall offer.
/// `view`: the id of the viewer's own view. `key`: of its seats, SeatKeys::own.
std::string helloMessage(uint32_t viewer, const std::string& view, const std::string& key,
                         const std::vector<SceneRecipe>& scenes, const std::vector<std::string>& devices,
                         const SettingCaps& caps = {});
std::string sceneLoadingMessage(const std::string& name, const std::string& what, double share);
/// `aspect`: width over height of the viewer's picture, for which its first camera is framed.
std::string sceneReadyMessage(const std::string& name, const Scene& scene, const std::vector<EffectReason>& reasons,
                              double aspect);
std::string sceneFailedMessage(const std::string& name, const std::string& why);
/// `inputId` names the message that this answers, if any.
std::string settingsMessage(const nlohmann::json& values, std::optional<uint32_t> inputId);
std::string statsMessage(const ViewerStats& stats);
/// Where in a frame the error is.
std::string errorsMessage(uint32_t frameId, const ErrorMap& errors);
/// Who made which part of a frame.
std::string partitionMessage(uint32_t frameId, const Partition& partition, const ScheduleReport& schedule);
std::string pathMessage(bool playing, const std::optional<FrameSummary>& result);
std::string effectCostsMeasuringMessage(double share);
std::string effectCostsReadyMessage(const EffectCosts& costs);
std::string effectCostsFailedMessage(const std::string& why);
/// What is under a place of the picture; nothing where there is none.
std::string pickedMessage(uint32_t id, const std::optional<Picked>& picked);
/// The picture is smaller than the viewer wanted, as the memory for pictures does not suffice.
std::string resolutionMessage(uvec2 wanted, uvec2 given, uint32_t inputId);
/// What the viewer looks at, and whether it drives or watches it. `camera`: of the view, for who drives from now on; may be null.
/// `inputId` names the message that this answers, if any.
std::string watchingMessage(const std::string& view, bool drives, const Camera* camera, std::optional<uint32_t> inputId);
/// A viewer that watches wants to drive; told to who does.
std::string driveAskedMessage(uint32_t viewer);
std::string noticeMessage(const std::string& text);
/// A notice that the server ends, at the latest after that time.
std::string endingMessage(std::chrono::milliseconds atMost);
std::string errorMessage(const std::string& text, const std::string& about, std::optional<uint32_t> inputId);
std::string pongMessage(double time);

}  // namespace heliograph
