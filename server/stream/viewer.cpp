#include "server/stream/viewer.h"

#include "server/base/log.h"
#include "server/stream/messages.h"

#include <algorithm>

namespace heliograph {

namespace {

constexpr uint32_t FINAL_QUALITY = 92;    // least JPEG quality of the last frame of a view
constexpr uint32_t PICTURE_QUALITY = 95;  // of a JPEG that was asked for

double secondsOf(Viewer::Clock::time_point time) { return std::chrono::duration<double>(time.time_since_epoch()).count(); }
double secondsNow() { return secondsOf(Viewer::Clock::now()); }

bool stalledSince(std::optional<double> oldest, double now) {
    return oldest && now - *oldest > std::chrono::duration<double>(STALL_PAUSE).count();
}

void smooth(double& value, double newest) { value = value > 0.0 ? 0.8 * value + 0.2 * newest : newest; }

FrameCodec codecOf(PictureFormat format) {
    switch (format) {
        case PictureFormat::exr: return FrameCodec::exr;
        case PictureFormat::jpg: return FrameCodec::jpeg;
        default: return FrameCodec::png;
    }
}

}  // namespace

Viewer::Viewer(uint32_t number, std::shared_ptr<ViewerSocket> socket, Metrics& metrics, ViewerListener& listener)
    : number_(number),
      socket_(std::move(socket)),
      metrics_(metrics),
      listener_(listener),
      encoder_([this](uint32_t frameId, std::optional<EncodedFrame> frame, const std::string& failure) {
          encoded(frameId, std::move(frame), failure);
      }) {}

void Viewer::setQuality(uint32_t quality) {
    std::lock_guard lock(mutex_);
    quality_ = quality;
}

Readiness Viewer::readiness() const {
    if (encoder_.busy()) return Readiness::busy;
    std::lock_guard lock(mutex_);
    if (line_.room(frameSeconds_, MAX_UNACKED)) return Readiness::ready;
    return stalledSince(line_.oldest(), secondsNow()) ? Readiness::stalled : Readiness::noCredit;
}

bool Viewer::nothingOnItsWay() const {
    if (encoder_.busy()) return false;
    std::lock_guard lock(mutex_);
    return line_.underWay() == 0 || stalledSince(line_.oldest(), secondsNow());
}

void Viewer::take(FinishedFrame frame) {
    FrameHeader header;
    header.codec = frame.picture ? codecOf(frame.picture->format) : FrameCodec::jpeg;
    {
        std::lock_guard lock(mutex_);
        header.frameId = ++lastFrameId_;
        if (!frame.picture) line_.begin(header.frameId, secondsNow(), frame.view.moving);
        if (!frame.picture && frame.view.moving) smooth(frameSeconds_, frame.figures.lastPassSeconds);
        if (header.codec == FrameCodec::jpeg) header.quality = static_cast<uint8_t>(qualityOf(frame));
    }
    encoder_.encode(std::move(frame), header);
}

/// With the lock held. The last frame of a view is a better one, unless the line is short of room.
uint32_t Viewer::qualityOf(const FinishedFrame& frame) {
    if (frame.picture) return PICTURE_QUALITY;
    if (!frame.view.settings.adaptiveQuality) ladder_.reset();
    if (!frame.final) return qualityAt(ladder_.level(), quality_);
    return ladder_.level() > 0 ? quality_ : std::max(quality_, FINAL_QUALITY);
}

uint32_t Viewer::coarser() const {
    std::lock_guard lock(mutex_);
    return scaleStepsAt(ladder_.level());
}

void Viewer::pinged(double roundTripSeconds) {
    std::lock_guard lock(mutex_);
    line_.pinged(roundTripSeconds, secondsNow());
}

void Viewer::encoded(uint32_t frameId, std::optional<EncodedFrame> frame, const std::string& failure) {
    if (frame) {
        metrics_.stages[Metrics::develop].add(1e-6 * frame->header.developMicros);
        metrics_.stages[Metrics::encode].add(1e-6 * frame->header.encodeMicros);
        std::lock_guard lock(mutex_);
        send(std::move(*frame));
    } else {
        {
            std::lock_guard lock(mutex_);
            line_.drop(frameId);  // it will never be acknowledged
        }
        listener_.encodingFailed(failure);
    }
    listener_.drained();
}

double Viewer::pictureSeconds() const {
    std::lock_guard lock(mutex_);
    return pictureSeconds_;
}

/// With the lock held.
void Viewer::send(EncodedFrame&& frame) {
    if (frame.order) {
        if (!pictureAwaited_ || frame.order->number != lastPicture_) return;  // given up, and told so
        pictureAwaited_ = false;
        metrics_.picturesSent++;
    } else {
        stats_.frameSent(frame);
        smooth(pictureSeconds_, frame.coreSeconds);
        line_.sent(frame.header.frameId, frame.picture.bytes.size() - SOCKET_HEADROOM, secondsNow());
        metrics_.framesSent++;
        metrics_.frameBytesSent += frame.picture.bytes.size() - SOCKET_HEADROOM;
        metrics_.stages[Metrics::input].add(1e-6 * frame.header.inputMicros);
        if (frame.figures.partition)
            socket_->sendText(partitionMessage(frame.header.frameId, *frame.figures.partition, frame.figures.schedule));
    }
    if (std::optional<uint32_t> replaced = socket_->sendPicture(std::move(frame.picture))) {
        metrics_.framesReplaced++;
        line_.drop(*replaced);
    }
}

void Viewer::acknowledge(const AckMessage& message) {
    {
        std::lock_guard lock(mutex_);
        if (message.frameId > lastFrameId_) {
            throw InputError("ack.frameId", std::to_string(message.frameId), "at most " + std::to_string(lastFrameId_));
        }
        const double now = secondsNow();
        const std::optional<double> shown = message.shownMs ? std::optional(*message.shownMs * 1e-3) : std::nullopt;
        // Pictures and frames that are acknowledged twice are not under way, which is fine.
        if (std::optional<QueueDelay> queued = line_.landed(message.frameId, now, shown); queued && queued->moving) {
            ladder_.seen(queued->total(), now);
            smooth(figures_.lineDelay, queued->line);
            smooth(figures_.viewerDelay, queued->viewer);
        }
    }
    if (message.presentedMs && *message.presentedMs >= 0.0) metrics_.motionToPhoton.add(*message.presentedMs * 1e-3);
    listener_.drained();
}

PictureOrder Viewer::orderPicture(PictureFormat format) {
    std::lock_guard lock(mutex_);
    if (pictureAwaited_) throw InputError("picture", "one is being made", "one at a time");
    pictureAwaited_ = true;
    return {++lastPicture_, format, number_};
}

bool Viewer::dropPicture() {
    std::lock_guard lock(mutex_);
    return std::exchange(pictureAwaited_, false);
}

void Viewer::written(FrameKind kind, double waitSeconds, double writeSeconds) {
    metrics_.stages[Metrics::send].add(waitSeconds);
    if (kind != FrameKind::frame) return;
    std::lock_guard lock(mutex_);
    stats_.frameWritten(waitSeconds, writeSeconds);
}

bool Viewer::closeIfStalled(Clock::time_point now) {
    {
        std::lock_guard lock(mutex_);
        const std::optional<double> oldest = line_.oldest();
        if (!oldest || secondsOf(now) - *oldest <= std::chrono::duration<double>(STALL_CLOSE).count()) return false;
        line_.dropAll();  // closed once
    }
    log().warn("viewer {}: nothing acknowledged for {} s, closed", number_, STALL_CLOSE.count());
    socket_->close(CloseCode::stalled, "frames were not acknowledged for 10 seconds");
    return true;
}

ViewerStats Viewer::takeStats(double seconds, Turns::Used used) {
    std::lock_guard lock(mutex_);
    ViewerStats stats = stats_.take(seconds, used);
    stats.line = figures_;
    stats.line.level = ladder_.level();
    stats.line.quality = qualityAt(ladder_.level(), quality_);
    stats.line.roundTrip = line_.leastRoundTrip();
    stats.line.bytesPerSecond = line_.bytesPerSecond();
    return stats;
}

}  // namespace heliograph
