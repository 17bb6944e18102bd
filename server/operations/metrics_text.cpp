#include "server/operations/metrics_text.h"

#include "server/base/clock.h"
#include "server/base/machine.h"
#include "server/base/version.h"

#include <prometheus/text_serializer.h>

#include <sys/resource.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace heliograph {

namespace {

using prometheus::ClientMetric;
using prometheus::MetricFamily;
using prometheus::MetricType;

constexpr const char* STAGE_NAMES[Metrics::STAGES] = {"input", "render", "develop", "encode", "send"};
constexpr const char* RAY_NAMES[] = {"primary", "shadow", "ambient_occlusion", "reflection", "refraction"};
static_assert(std::size(RAY_NAMES) == static_cast<size_t>(RayKind::count));

constexpr std::optional<CloseCode> CLOSE_CODES[] = {std::nullopt,
                                                    CloseCode::normal,
                                                    CloseCode::goingAway,
                                                    CloseCode::protocolError,
                                                    CloseCode::unsupportedData,
                                                    CloseCode::policyViolation,
                                                    CloseCode::messageTooBig,
                                                    CloseCode::serverError,
                                                    CloseCode::tryAgainLater,
                                                    CloseCode::unauthorized,
                                                    CloseCode::dismissed,
                                                    CloseCode::stalled};
constexpr unsigned REFUSAL_STATUSES[] = {400, 401, 403, 404, 405, 414, 421, 426, 429, 431, 503};
constexpr const char* LOAD_OUTCOMES[] = {"ready", "failed", "abandoned"};

/// Collects families.
class Families {
public:
    void gauge(const char* name, const char* help, double value) {
        open(name, help, MetricType::Gauge);
        sample({}, value);
    }
    void counter(const char* name, const char* help, double value) {
        open(name, help, MetricType::Counter);
        sample({}, value);
    }
    void open(const char* name, const char* help, MetricType type) { families_.push_back({name, help, type, {}}); }
    /// Of the family opened last.
    void sample(std::vector<ClientMetric::Label> labels, double value) {
        ClientMetric& metric = add(std::move(labels));
        const double finite = std::isfinite(value) ? value : 0.0;
        (families_.back().type == MetricType::Counter ? metric.counter.value : metric.gauge.value) = finite;
    }
    void histogram(std::vector<ClientMetric::Label> labels, const Histogram& of) {
        ClientMetric& metric = add(std::move(labels));
        const auto counts = of.cumulative();
        for (size_t i = 0; i < counts.size(); i++)
            metric.histogram.bucket.push_back({counts[i], i < Histogram::BOUNDS.size() ? Histogram::BOUNDS[i] : INFINITY});
        metric.histogram.sample_count = counts.back();
        metric.histogram.sample_sum = of.sum();
    }
    /// A counter by one label; `words` are there from the start, so that a rate knows their zero.
    void tally(const char* name, const char* help, const char* label, std::map<std::string, uint64_t> counts,
               const std::vector<std::string>& words) {
        open(name, help, MetricType::Counter);
        for (const std::string& word : words) counts.try_emplace(word, 0);
        for (const auto& [word, count] : counts) sample({{label, word}}, static_cast<double>(count));
    }
    std::vector<MetricFamily> take() { return std::move(families_); }

private:
    ClientMetric& add(std::vector<ClientMetric::Label> labels) {
        ClientMetric metric;
        metric.label = std::move(labels);
        return families_.back().metric.emplace_back(std::move(metric));
    }
    std::vector<MetricFamily> families_;
};

void addState(const ServerState& state, Families& out) {
    out.open("heliograph_build_info", "Version of the server.", MetricType::Gauge);
    out.sample({{"version", programVersion()}}, 1);
    out.gauge("heliograph_ready", "1 when the next viewer would see something at once, as /readyz.", state.ready);
    out.gauge("heliograph_viewers", "Viewers connected.", static_cast<double>(state.viewers));
    out.gauge("heliograph_viewers_limit", "Viewers that are let in.", static_cast<double>(state.mostViewers));
    out.gauge("heliograph_film_pixels", "Pixels of film granted to viewers.", static_cast<double>(state.filmPixels));
    out.gauge("heliograph_film_pixels_limit", "Pixels of film for all viewers.", static_cast<double>(state.mostFilmPixels));
    out.gauge("heliograph_views", "Views with a picture or somebody who looks, those kept for who may come back, too.",
              static_cast<double>(state.views));
    out.gauge("heliograph_picture_memory_bytes", "What the pictures of views and the bytes made of them may take.",
              static_cast<double>(state.pictureBytes));
    out.gauge("heliograph_picture_memory_limit_bytes", "The same for all viewers that fit.",
              static_cast<double>(state.mostPictureBytes));
    out.gauge("heliograph_resident_scenes", "Scenes ready to be rendered.", static_cast<double>(state.residentScenes));
    out.gauge("heliograph_scene_loads_waiting", "Scenes being loaded or waiting for that.",
              static_cast<double>(state.loadsWaiting));
    out.gauge("process_resident_memory_bytes", "Memory of the process.", static_cast<double>(state.residentBytes));
    out.gauge("process_open_fds", "Descriptors in use.", static_cast<double>(state.descriptors));
    out.gauge("process_max_fds", "Descriptors that the process may have.", static_cast<double>(state.mostDescriptors));
    out.gauge("process_threads", "Threads of the process.", static_cast<double>(state.threads));
    out.counter("process_cpu_seconds_total", "Processor time of all threads.", state.cpuSeconds);
    out.gauge("process_start_time_seconds", "When the process began, since 1970.", state.startTime);
}

void addCounts(const Metrics& metrics, Families& out) {
    const auto number = [](const std::atomic<uint64_t>& count) { return static_cast<double>(count.load()); };
    std::vector<std::string> closes, refusals{"token"}, loads(std::begin(LOAD_OUTCOMES), std::end(LOAD_OUTCOMES));
    for (const auto& code : CLOSE_CODES) closes.push_back(closeReason(code));
    for (unsigned status : REFUSAL_STATUSES) refusals.push_back(refusalReason(status));
    std::map<std::string, uint64_t> closed = metrics.closes.all();
    out.tally("heliograph_connections_closed_total", "Viewers that have gone, by reason.", "reason", closed, closes);
    out.tally("heliograph_connections_refused_total", "Connections turned away, by reason.", "reason", metrics.refusals.all(),
              refusals);
    out.tally("heliograph_scene_loads_total", "Scenes loaded, by outcome.", "outcome", metrics.loads.all(), loads);
    out.counter("heliograph_frames_sent_total", "Frames handed to sockets.", number(metrics.framesSent));
    out.counter("heliograph_frame_sent_bytes_total", "Bytes of those frames.", number(metrics.frameBytesSent));
    out.counter("heliograph_frames_replaced_total", "Encoded frames that a newer one replaced unsent.",
                number(metrics.framesReplaced));
    out.counter("heliograph_pictures_sent_total", "Pictures asked for and sent.", number(metrics.picturesSent));
    out.counter("heliograph_messages_refused_total", "Messages of viewers answered with an error.",
                number(metrics.messagesRefused));
    out.counter("heliograph_viewers_stalled_total", "Viewers closed because they acknowledged or took nothing.",
                number(closed[closeReason(CloseCode::stalled)]));
    out.counter("heliograph_nonfinite_samples_total", "Samples left out as NaN or infinite.", number(metrics.nonfiniteSamples));
    out.open("heliograph_rays_total", "Rays traced for frames that were shown, by kind.", MetricType::Counter);
    for (size_t i = 0; i < metrics.rays.size(); i++) out.sample({{"kind", RAY_NAMES[i]}}, number(metrics.rays[i]));
}

void addDevices(const Metrics& metrics, Families& out) {
    const std::map<std::string, DeviceCount> devices = metrics.devices.all();
    out.open("heliograph_device_tiles_total", "Tiles of frames that were shown, by device.", MetricType::Counter);
    for (const auto& [name, count] : devices) out.sample({{"device", name}}, static_cast<double>(count.tiles));
    out.open("heliograph_device_seconds_total", "Time of rendering frames that the device took part in.", MetricType::Counter);
    for (const auto& [name, count] : devices) out.sample({{"device", name}}, count.seconds);
    out.open("heliograph_device_set_aside_total", "How often the device failed and was set aside.", MetricType::Counter);
    for (const auto& [name, count] : devices) out.sample({{"device", name}}, static_cast<double>(count.setAside));
}

void addPool(const PoolState& pool, Families& out) {
    const auto number = [](uint64_t count) { return static_cast<double>(count); };
    out.gauge("heliograph_pool_connected", "1 while there is a line to the broker.", pool.connected);
    out.gauge("heliograph_pool_nodes", "Render nodes that are there.", number(pool.nodes));
    out.gauge("heliograph_pool_nodes_refused", "Render nodes that are there and may not render.", number(pool.refusedNodes));
    out.gauge("heliograph_pool_rays_per_second", "Rate of the nodes together, as measured while they worked.",
              pool.raysPerSecond);
    out.counter("heliograph_pool_tiles_total", "Tiles that nodes made for this server.", number(pool.tiles));
    out.counter("heliograph_pool_batches_total", "Batches that nodes were asked for.", number(pool.batches));
    out.counter("heliograph_pool_batches_lost_total", "Batches that a node left undone, so that others made the rest.",
                number(pool.lostBatches));
    out.counter("heliograph_pool_received_bytes_total", "Bytes of messages from the pool.", number(pool.receivedBytes));
    out.counter("heliograph_pool_sent_bytes_total", "Bytes of messages to the pool.", number(pool.sentBytes));
    out.counter("heliograph_pool_messages_unsound_total", "Messages dropped as damaged or none of the pool.",
                number(pool.unsoundMessages));
    out.counter("heliograph_pool_messages_late_total", "Messages for batches that were over.", number(pool.lateMessages));
}

void addTimes(const Metrics& metrics, Families& out) {
    out.open("heliograph_frame_stage_seconds", "Time of a frame by stage; render is one pass.", MetricType::Histogram);
    for (size_t i = 0; i < Metrics::STAGES; i++) out.histogram({{"stage", STAGE_NAMES[i]}}, metrics.stages[i]);
    out.open("heliograph_motion_to_photon_seconds", "Input to picture as viewers measured it.", MetricType::Histogram);
    out.histogram({}, metrics.motionToPhoton);
}

/// Entries of a folder of /proc.
uint64_t entriesOf(const char* folder) {
    std::error_code error;
    uint64_t count = 0;
    for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) count++;
    return count;
}

/// When this process began: boot time and the 22nd field of /proc/self/stat, in clock ticks.
double processStart() {
    std::ifstream in("/proc/self/stat");
    std::string text((std::istreambuf_iterator<char>(in)), {});
    std::istringstream fields(text.substr(std::min(text.rfind(')') + 1, text.size())));
    std::string field;
    for (int i = 3; i <= 22; i++) fields >> field;
    std::ifstream boot("/proc/stat");
    for (std::string line; std::getline(boot, line);) {
        if (line.starts_with("btime "))
            return std::strtod(line.c_str() + 6, nullptr) +
                   std::strtod(field.c_str(), nullptr) / static_cast<double>(sysconf(_SC_CLK_TCK));
    }
    return 0.0;
}

}  // namespace

void readProcess(ServerState& state) {
    static const double start = processStart();
    rlimit limit{};
    getrlimit(RLIMIT_NOFILE, &limit);
    state.residentBytes = residentBytes();
    state.descriptors = entriesOf("/proc/self/fd");
    state.mostDescriptors = limit.rlim_cur;
    state.threads = entriesOf("/proc/self/task");
    state.cpuSeconds = processCpuSeconds();
    state.startTime = start;
}

std::string closeReason(std::optional<CloseCode> code) {
    if (!code) return "viewer_left";
    switch (*code) {
        case CloseCode::normal: return "normal";
        case CloseCode::goingAway: return "server_ends";
        case CloseCode::tryAgainLater: return "no_resources";
        case CloseCode::protocolError: return "protocol_error";
        case CloseCode::unsupportedData: return "binary_message";
        case CloseCode::policyViolation: return "too_many_messages";
        case CloseCode::messageTooBig: return "message_too_big";
        case CloseCode::serverError: return "server_error";
        case CloseCode::unauthorized: return "unauthorized";
        case CloseCode::dismissed: return "admin";
        case CloseCode::stalled: return "stalled";
        default: return "other";
    }
}

std::string refusalReason(unsigned status) {
    switch (status) {
        case 400: return "bad_request";
        case 401: return "unauthorized";
        case 403: return "origin";
        case 404: return "not_found";
        case 405: return "method";
        case 414:
        case 431: return "too_long";
        case 421: return "host";
        case 426: return "version";
        case 429: return "too_many";
        case 503: return "no_room";
        default: return "other";
    }
}

std::vector<MetricFamily> metricFamilies(const Metrics& metrics, const ServerState& state) {
    Families families;
    addState(state, families);
    addCounts(metrics, families);
    addDevices(metrics, families);
    addTimes(metrics, families);
    if (state.pool) addPool(*state.pool, families);
    return families.take();
}

std::string metricsText(const std::vector<MetricFamily>& families) {
    std::ostringstream out;
    prometheus::TextSerializer().Serialize(out, families);
    return out.str();
}

}  // namespace heliograph
