#include "server/stream/metrics.h"
#include "server/base/version.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace heliograph {

namespace {

constexpr const char* STAGE_NAMES[Metrics::STAGES] = {"input", "render", "develop", "encode", "send"};

void head(const std::string& name, const char* type, const char* help, std::string& text) {
    text += "# HELP " + name + " " + help + "\n# TYPE " + name + " " + type + "\n";
}

void single(const std::string& name, const char* type, const char* help, uint64_t value, std::string& text) {
    head(name, type, help, text);
    text += name + " " + std::to_string(value) + "\n";
}

std::string shortest(double value) {
    std::ostringstream out;
    out.precision(12);
    out << value;
    return out.str();
}

}  // namespace

void Histogram::add(double seconds) {
    if (!std::isfinite(seconds)) return;
    size_t bucket = std::lower_bound(BOUNDS.begin(), BOUNDS.end(), seconds) - BOUNDS.begin();
    counts_[bucket].fetch_add(1, std::memory_order_relaxed);
    sum_.fetch_add(seconds, std::memory_order_relaxed);
}

void Histogram::write(const std::string& name, const std::string& labels, std::string& text) const {
    uint64_t count = 0;
    const std::string more = labels.empty() ? "" : labels + ",";
    for (size_t i = 0; i <= BOUNDS.size(); i++) {
        count += counts_[i].load(std::memory_order_relaxed);
        std::string bound = i < BOUNDS.size() ? shortest(BOUNDS[i]) : "+Inf";
        text += name + "_bucket{" + more + "le=\"" + bound + "\"} " + std::to_string(count) + "\n";
    }
    const std::string braces = labels.empty() ? "" : "{" + labels + "}";
    text += name + "_sum" + braces + " " + shortest(sum_.load(std::memory_order_relaxed)) + "\n";
    text += name + "_count" + braces + " " + std::to_string(count) + "\n";
}

std::string Metrics::text(size_t viewers, size_t scenes, uint64_t bytes) const {
    std::string out;
    head("heliograph_build_info", "gauge", "Version of the server.", out);
    out += std::string("heliograph_build_info{version=\"") + programVersion() + "\"} 1\n";
    single("heliograph_viewers", "gauge", "Viewers connected.", viewers, out);
    single("heliograph_resident_scenes", "gauge", "Scenes ready to be rendered.", scenes, out);
    single("heliograph_resident_memory_bytes", "gauge", "Memory of the process.", bytes, out);
    single("heliograph_frames_sent_total", "counter", "Frames handed to sockets.", framesSent, out);
    single("heliograph_frame_sent_bytes_total", "counter", "Bytes of those frames.", frameBytesSent, out);
    single("heliograph_frames_replaced_total", "counter", "Encoded frames that a newer one replaced unsent.", framesReplaced,
           out);
    single("heliograph_pictures_sent_total", "counter", "Pictures asked for and sent.", picturesSent, out);
    single("heliograph_messages_refused_total", "counter", "Messages of viewers answered with an error.", messagesRefused, out);
    single("heliograph_connections_refused_total", "counter", "Connections refused: origin, token, limit.", connectionsRefused,
           out);
    single("heliograph_viewers_stalled_total", "counter", "Viewers closed because they acknowledged nothing.", viewersStalled,
           out);
    single("heliograph_nonfinite_samples_total", "counter", "Samples left out as NaN or infinite.", nonfiniteSamples, out);
    head("heliograph_rays_total", "counter", "Rays traced for frames that were shown, by kind.", out);
    for (size_t i = 0; i < rays.size(); i++) {
        out += std::string("heliograph_rays_total{kind=\"") + RAY_WORDS[i] + "\"} " + std::to_string(rays[i]) + "\n";
    }
    head("heliograph_frame_stage_seconds", "histogram", "Time of a frame by stage; render is one pass.", out);
    for (size_t i = 0; i < STAGES; i++) {
        stages[i].write("heliograph_frame_stage_seconds", std::string("stage=\"") + STAGE_NAMES[i] + "\"", out);
    }
    head("heliograph_motion_to_photon_seconds", "histogram", "Input to picture as viewers measured it.", out);
    motionToPhoton.write("heliograph_motion_to_photon_seconds", "", out);
    return out;
}

}  // namespace heliograph
