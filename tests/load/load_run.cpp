#include "tests/load/load_run.h"

#include "server/base/clock.h"

#include <libwebsockets.h>

#include <algorithm>
#include <cstring>
#include <optional>
#include <stdexcept>

namespace heliograph::load {

namespace {

constexpr double PATIENCE = 20.0;       // seconds until every viewer has to see the scene
constexpr double REST = 5.0;            // seconds in which the last input has to be shown
constexpr double RETRY = 0.5;           // seconds until a viewer who lost the connection comes back
constexpr double MOST_BUFFERED = 0.05;  // seconds of a slow line that we take from the kernel ahead of time

// What came from the server and has not arrived yet, or was said and has not left.
struct Delayed {
    double at = 0.0;
    bool binary = false;
    std::string bytes;
};

struct Line {
    LoadViewer* viewer = nullptr;
    ViewerResult* result = nullptr;
    lws* socket = nullptr;
    bool open = false;
    double connectAt = 0.0;
    double lineFreeAt = 0.0;
    double nextStall = 0.0, stalledUntil = 0.0;
    double closeAt = 0.0;
    bool paused = false;
    std::string incoming;
    std::deque<Delayed> arriving, leaving;
};

class Run {
public:
    Run(const LoadPlan& plan, const std::function<void(double, double, size_t)>& progress, const std::atomic<bool>& stop)
        : plan_(plan), address_(addressOf(plan.url)), progress_(progress), stop_(stop), random_(plan.seed) {}

    LoadResult run();
    int callback(lws* socket, lws_callback_reasons reason, Line* line, void* in, size_t length);

private:
    double now() const { return watch_.seconds(); }
    double about(double mean) { return mean * (0.5 + std::uniform_real_distribution<double>()(random_)); }
    void connect(Line& line);
    void receive(Line& line, const void* bytes, size_t length);
    int write(Line& line);
    void lost(Line& line);
    void tick(Line& line, bool inputs);
    void tickLine(Line& line, double time);
    void turn(bool inputs);
    size_t readyCount() const;
    void waitForAll();
    void rest();

    const LoadPlan& plan_;
    ServerAddress address_;
    const std::function<void(double, double, size_t)>& progress_;
    const std::atomic<bool>& stop_;
    StopWatch watch_;
    std::minstd_rand random_;
    lws_context* context_ = nullptr;
    std::vector<Line> lines_;
    LoadResult result_;
    double told_ = 0.0;
};

int onEvent(lws* socket, lws_callback_reasons reason, void* user, void* in, size_t length) {
    auto* run = static_cast<Run*>(lws_context_user(lws_get_context(socket)));
    if (run == nullptr || user == nullptr) return 0;
    return run->callback(socket, reason, static_cast<Line*>(user), in, length);
}

void Run::connect(Line& line) {
    lws_client_connect_info info{};
    const std::string host = address_.host + ":" + std::to_string(address_.port);
    info.context = context_;
    info.address = address_.host.c_str();
    info.port = address_.port;
    info.path = address_.path.c_str();
    info.host = host.c_str();
    info.protocol = PROTOCOL_NAME;
    info.local_protocol_name = "load";
    info.userdata = &line;
    if (address_.tls) {
        info.ssl_connection = LCCSCF_USE_SSL;
        if (plan_.trustAnyCertificate)
            info.ssl_connection |= LCCSCF_ALLOW_SELFSIGNED | LCCSCF_SKIP_SERVER_CERT_HOSTNAME_CHECK | LCCSCF_ALLOW_INSECURE;
    }
    line.connectAt = now() + PATIENCE;
    line.socket = lws_client_connect_via_info(&info);
    if (line.socket == nullptr) lost(line);
}

void Run::lost(Line& line) {
    if (line.open) line.viewer->closed(now());
    line.open = line.paused = false;
    line.socket = nullptr;
    line.incoming.clear();
    line.arriving.clear();
    line.leaving.clear();
    line.connectAt = now() + RETRY;
}

int Run::callback(lws* socket, lws_callback_reasons reason, Line* line, void* in, size_t length) {
    switch (reason) {
        case LWS_CALLBACK_CLIENT_ESTABLISHED:
            line->socket = socket;
            line->open = line->result->admitted = true;
            line->lineFreeAt = now();
            line->nextStall = now() + about(plan_.network.stallEvery);
            line->closeAt = now() + about(plan_.network.closeAfter);
            line->viewer->opened(now());
            break;
        case LWS_CALLBACK_CLIENT_RECEIVE: receive(*line, in, length); break;
        case LWS_CALLBACK_CLIENT_WRITEABLE: return write(*line);
        case LWS_CALLBACK_CLIENT_CONNECTION_ERROR:
            // The server's refusal, or nobody there: the line below says which in the viewer's faults.
            line->result->refused++;
            lost(*line);
            break;
        case LWS_CALLBACK_CLIENT_CLOSED: lost(*line); break;
        default: break;
    }
    return 0;
}

void Run::receive(Line& line, const void* bytes, size_t length) {
    line.incoming.append(static_cast<const char*>(bytes), length);
    const double time = now();
    if (plan_.network.bytesPerSecond > 0.0) {
        line.lineFreeAt = std::max(line.lineFreeAt, time) + static_cast<double>(length) / plan_.network.bytesPerSecond;
        // What the line cannot take yet stays in the kernel, so that the server feels it.
        if (line.lineFreeAt > time + MOST_BUFFERED && !line.paused) {
            line.paused = true;
            lws_rx_flow_control(line.socket, 0);
        }
    }
    if (lws_remaining_packet_payload(line.socket) > 0 || !lws_is_final_fragment(line.socket)) return;
    const double at = std::max(time, plan_.network.bytesPerSecond > 0.0 ? line.lineFreeAt : time) + plan_.network.delay;
    line.arriving.push_back({at, lws_frame_is_binary(line.socket) != 0, std::move(line.incoming)});
    line.incoming.clear();
}

int Run::write(Line& line) {
    if (line.leaving.empty() || line.leaving.front().at > now()) return 0;
    std::vector<uint8_t> buffer(LWS_PRE + line.leaving.front().bytes.size());
    std::memcpy(buffer.data() + LWS_PRE, line.leaving.front().bytes.data(), line.leaving.front().bytes.size());
    const size_t size = line.leaving.front().bytes.size();
    line.leaving.pop_front();
    if (lws_write(line.socket, buffer.data() + LWS_PRE, size, LWS_WRITE_TEXT) < static_cast<int>(size)) return -1;
    if (!line.leaving.empty() && line.leaving.front().at <= now()) lws_callback_on_writable(line.socket);
    return 0;
}

void Run::tickLine(Line& line, double time) {
    const NetworkProfile& network = plan_.network;
    if (network.stallEvery > 0.0 && time > line.nextStall) {
        line.stalledUntil = time + network.stallSeconds;
        line.nextStall = line.stalledUntil + about(network.stallEvery);
    }
    const bool wait = time < line.stalledUntil || line.lineFreeAt > time + MOST_BUFFERED;
    if (wait != line.paused) {
        line.paused = wait;
        lws_rx_flow_control(line.socket, wait ? 0 : 1);
    }
    if (network.closeAfter > 0.0 && time > line.closeAt) {
        // As a cable that is pulled: no goodbye.
        lws_set_timeout(line.socket, PENDING_TIMEOUT_USER_OK, LWS_TO_KILL_ASYNC);
        line.closeAt = time + PATIENCE;
    }
}

void Run::tick(Line& line, bool inputs) {
    const double time = now();
    if (!line.open) {
        if (time >= line.connectAt) connect(line);
        return;
    }
    tickLine(line, time);
    while (line.open && !line.arriving.empty() && line.arriving.front().at <= time && time >= line.stalledUntil) {
        const Delayed message = std::move(line.arriving.front());
        line.arriving.pop_front();
        if (message.binary)
            line.viewer->takeBinary({reinterpret_cast<const uint8_t*>(message.bytes.data()), message.bytes.size()}, time);
        else line.viewer->takeText(message.bytes, time);
    }
    line.viewer->tick(time, inputs);
    line.viewer->watch(lines_.front().viewer->ownView());
    while (std::optional<std::string> message = line.viewer->nextMessage())
        line.leaving.push_back({time + plan_.network.delay, false, std::move(*message)});
    if (!line.leaving.empty() && line.leaving.front().at <= time) lws_callback_on_writable(line.socket);
}

size_t Run::readyCount() const {
    return std::count_if(lines_.begin(), lines_.end(), [](const Line& line) { return line.viewer->ready(); });
}

void Run::turn(bool inputs) {
    for (Line& line : lines_) tick(line, inputs);
    lws_service(context_, 0);
    if (now() - told_ < 0.5) return;
    told_ = now();
    if (progress_) progress_(now(), plan_.rampSeconds + plan_.seconds, readyCount());
}

void Run::waitForAll() {
    // Who was refused does not come back in time; the others' start does not wait for them.
    while (!stop_ && now() < plan_.rampSeconds + PATIENCE) {
        const bool all = std::all_of(lines_.begin(), lines_.end(),
                                     [](const Line& line) { return line.viewer->ready() || line.result->refused > 0; });
        if (all && now() >= plan_.rampSeconds) return;
        turn(true);
    }
}

void Run::rest() {
    const double end = now() + REST;
    const auto waiting = [](const Line& line) { return line.viewer->ready() && !line.viewer->rested(); };
    while (!stop_ && now() < end && std::any_of(lines_.begin(), lines_.end(), waiting)) turn(false);
    for (Line& line : lines_) line.result->restedInTime = line.viewer->rested();
}

void wake(lws_sorted_usec_list_t* timer);

struct Alarm {
    lws_sorted_usec_list_t timer{};
    lws_context* context = nullptr;
    void set() { lws_sul_schedule(context, 0, &timer, wake, 2 * LWS_US_PER_MS); }
};

// Nothing to do but to end lws_service's wait; the loop ticks by itself.
void wake(lws_sorted_usec_list_t* timer) { lws_container_of(timer, Alarm, timer)->set(); }

LoadResult Run::run() {
    static const lws_protocols protocols[] = {{"load", onEvent, 0, 65536, 0, nullptr, 0},
                                              {nullptr, nullptr, 0, 0, 0, nullptr, 0}};
    lws_set_log_level(LLL_ERR, nullptr);
    lws_context_creation_info info{};
    info.port = CONTEXT_PORT_NO_LISTEN;
    info.protocols = protocols;
    info.user = this;
    info.options = LWS_SERVER_OPTION_DO_SSL_GLOBAL_INIT;
    info.fd_limit_per_thread = plan_.viewers + 32;
    context_ = lws_create_context(&info);
    if (context_ == nullptr) throw std::runtime_error("the sockets cannot be set up");
    Alarm alarm;
    alarm.context = context_;
    alarm.set();

    result_.viewers.resize(plan_.viewers);
    lines_.resize(plan_.viewers);
    for (uint32_t i = 0; i < plan_.viewers; i++) {
        result_.viewers[i].viewer = std::make_unique<LoadViewer>(plan_, i);
        lines_[i].viewer = result_.viewers[i].viewer.get();
        lines_[i].result = &result_.viewers[i];
        lines_[i].connectAt = plan_.rampSeconds * i / plan_.viewers;
    }
    waitForAll();
    result_.begun = now();
    while (!stop_ && now() < result_.begun + plan_.seconds) turn(true);
    result_.seconds = now() - result_.begun;
    rest();
    lws_sul_cancel(&alarm.timer);
    for (Line& line : lines_) line.open = false;  // what ends now is our doing
    lws_context_destroy(context_);
    return std::move(result_);
}

}  // namespace

LoadResult runLoad(const LoadPlan& plan, const std::function<void(double, double, size_t)>& progress,
                   const std::atomic<bool>& stop) {
    return Run(plan, progress, stop).run();
}

}  // namespace heliograph::load
