#pragma once
// What a load test is to do: how many viewers, what their hands do, what their line is like, and what has to come out.
// Values and pure functions.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace heliograph::load {

/// What a viewer's hand does. `watch`: all look at the view of the first one, which orbits. `mixed` deals the others out in turn,
/// the attacker and those who watch apart.
enum class Script { orbit, path, walk, idle, settings, attacker, watch, mixed };
/// Throws InputError naming the known scripts.
Script scriptOf(const std::string& word);
const char* wordOf(Script script);

/// A viewer's line. Every value 0: no limit, nothing added.
struct NetworkProfile {
    std::string name = "none";
    double bytesPerSecond = 0.0;  // what the viewer reads at most; the rest waits in the kernel's buffers, as on a slow line
    double delay = 0.0;           // seconds, each way
    double stallEvery = 0.0;      // mean seconds between two times in which nothing arrives
    double stallSeconds = 0.0;    // how long those last
    double closeAfter = 0.0;      // mean seconds until the connection is cut without a goodbye; the viewer comes back
};
/// none, slow (2 Mbit/s, 50 ms round trip), latency (300 ms round trip), lossy (a stall of 0.25 s every second: what TCP
/// makes of lost packets), stalls (3 s every 8 s), close (cut after 3 s). Throws InputError naming them.
NetworkProfile networkOf(const std::string& name);

/// A figure that the run must reach, such as `p95_ms<=80`.
struct Requirement {
    std::string text;
    std::string figure;    // a key of figuresOf (load_report.h)
    std::string relation;  // <=, <, ==, >=, >
    double bound = 0.0;
    bool holds(double value) const;
};
/// Throws InputError for anything but FIGURE RELATION NUMBER.
Requirement requirementOf(const std::string& text);

struct LoadPlan {
    std::string url;  // ws:// or wss://
    std::string token;
    std::string scene;  // empty: the server's
    uint32_t viewers = 8;
    double seconds = 10.0;     // of steady load, after everybody had time to connect
    double rampSeconds = 0.0;  // over which the viewers come
    double inputsPerSecond = 30.0;
    uint32_t width = 320, height = 180;
    Script script = Script::orbit;
    NetworkProfile network;
    bool vp9 = false;  // pictures as a video; else JPEG
    uint32_t seed = 1;
    bool trustAnyCertificate = false;
};

/// What viewer `index` does under `plan` (deals out `mixed`; of those who watch the first drives).
Script scriptFor(const LoadPlan& plan, uint32_t index);

/// Scheme, host, port and path of ws[s]://HOST[:PORT][/PATH]; http[s]:// is read alike, and a missing path is /ws.
struct ServerAddress {
    bool tls = false;
    std::string host;
    int port = 80;
    std::string path;
};
/// Throws InputError.
ServerAddress addressOf(const std::string& url);

}  // namespace heliograph::load
