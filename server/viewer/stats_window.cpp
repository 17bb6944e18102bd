#include "server/viewer/stats_window.h"

#include <algorithm>

namespace heliograph {

void StatsWindow::frameSent(const EncodedFrame& frame) {
    if (frames_++ == 0) last_.tiles.clear();
    passes_ += frame.figures.passes;
    render_ += frame.figures.renderSeconds;
    rays_ += frame.figures.rays.total();
    develop_ += 1e-6 * frame.header.developMicros;
    encode_ += 1e-6 * frame.header.encodeMicros;
    service_ += frame.coreSeconds;
    // A device that works elsewhere takes no processor time here; its wall time stands for it.
    tracing_ += frame.figures.coreSeconds > 0.0 ? frame.figures.coreSeconds : frame.figures.renderSeconds;
    queue_ += 1e-6 * frame.header.inputMicros;
    last_.samples = frame.header.samples;
    last_.targetSamples = frame.targetSamples;
    last_.relativeError = frame.header.relativeError;
    last_.forecast = frame.forecast;
    last_.refined = frame.refined;
    last_.autoExposure = frame.autoExposure;
    if (frame.figures.passes > 0) {
        last_.rays = frame.figures.lastRays;
        last_.schedule = frame.figures.schedule;
    }
    if (!frame.figures.tiles.empty()) last_.device.clear();
    for (const auto& [device, count] : frame.figures.tiles) {
        last_.tiles[device] += count;
        last_.device += (last_.device.empty() ? "" : " + ") + device;
    }
    last_.nonfiniteSamples += frame.figures.nonfiniteSamples;
}

void StatsWindow::frameWritten(double waitSeconds, double writeSeconds) {
    sent_++;
    service_ += writeSeconds;
    send_ += waitSeconds;
}

ViewerStats StatsWindow::take(double seconds, Turns::Used used) {
    last_.framesPerSecond = seconds > 0.0 ? frames_ / seconds : 0.0;
    double all = used.all - usedBefore_.all;
    // Of another view than before where the viewer has gone to one.
    last_.deviceShare = all > 0.0 ? std::clamp((used.own - usedBefore_.own) / all, 0.0, 1.0) : 0.0;
    usedBefore_ = used;
    if (frames_ > 0) {
        const double ms = 1000.0 / frames_;
        // Of one pass: a frame at rest may hold many.
        if (passes_ > 0) last_.ms.render = 1000.0 * render_ / passes_;
        last_.ms.develop = ms * develop_;
        last_.ms.encode = ms * encode_;
        last_.ms.queue = ms * queue_;
        if (sent_ > 0) last_.ms.send = 1000.0 * send_ / sent_;
        if (tracing_ > 0.0) last_.overheadShare = service_ / (tracing_ + service_);
        if (render_ > 0.0) last_.mraysPerSecond = static_cast<double>(rays_) / render_ * 1e-6;
    }
    frames_ = passes_ = sent_ = 0;
    render_ = develop_ = encode_ = queue_ = send_ = tracing_ = service_ = 0.0;
    rays_ = 0;
    return last_;
}

bool StatsWindow::changed(Turns::Used used) const {
    return frames_ > 0 || sent_ > 0 || used.own != usedBefore_.own || last_.framesPerSecond > 0.0 || last_.deviceShare > 0.0;
}

}  // namespace heliograph
