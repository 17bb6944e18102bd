#include "server/viewer/viewer.h"

#include "server/base/log.h"
#include "server/encode/video_encoder.h"
#include "server/viewer/messages.h"

#include <algorithm>

namespace heliograph {

namespace {

constexpr uint32_t FINAL_QUALITY = 92;    // least JPEG quality of the last frame of a view
constexpr uint32_t PICTURE_QUALITY = 95;  // of a JPEG that was asked for
constexpr uint32_t PART_PIXELS = 32768;  // of a part: some 60 KB, so that a new picture waits a quarter of a second at 2 Mbit/s

double secondsOf(Viewer::Clock::time_point time) { return std::chrono::duration<double>(time.time_since_epoch()).count(); }
double secondsNow() { return secondsOf(Viewer::Clock::now()); }

/// The video that the frame may be one of; jpeg: none.
FrameCodec videoOf(const FinishedFrame& frame, const ClientMessage& client) {
    const auto made = [&](VideoCodec codec) { return videoFits(codec, frame.size.x, frame.size.y); };
    const Videos ours = {made(VideoCodec::vp9), made(VideoCodec::h264)};
    switch (videoFor(static_cast<CodecSetting>(frame.view.settings.codec), ours, {client.vp9, client.h264})) {
        case CodecSetting::vp9: return FrameCodec::vp9;
        case CodecSetting::h264: return FrameCodec::h264;
        default: return FrameCodec::jpeg;
    }
}

bool stalledSince(std::optional<double> oldest, double now) {
    return oldest && now - *oldest > std::chrono::duration<double>(STALL_PAUSE).count();
}

void smooth(double& value, double newest) { value = value > 0.0 ? 0.8 * value + 0.2 * newest : newest; }

FrameCodec savedCodec(PictureFormat format) {
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

void Viewer::setClient(const ClientMessage& client) {
    {
        std::lock_guard lock(mutex_);
        client_ = client;
    }
    listener_.drained();
}

bool Viewer::visible() const {
    std::lock_guard lock(mutex_);
    return client_.visible;
}

Readiness Viewer::readiness() const {
    if (encoder_.busy()) return Readiness::busy;
    std::lock_guard lock(mutex_);
    if (!client_.visible) return Readiness::stalled;
    // In the socket another frame would replace it, and those that build on it would be of no use.
    if (video() && unwritten_) return stalledSince(line_.oldest(), secondsNow()) ? Readiness::stalled : Readiness::noCredit;
    if (line_.room(frameSeconds_, MAX_UNACKED)) return Readiness::ready;
    return stalledSince(line_.oldest(), secondsNow()) ? Readiness::stalled : Readiness::noCredit;
}

bool Viewer::nothingOnItsWay() const {
    if (encoder_.busy()) return false;
    std::lock_guard lock(mutex_);
    return line_.underWay() == 0 || stalledSince(line_.oldest(), secondsNow());
}

void Viewer::take(FinishedFrame frame, std::shared_ptr<SharedPictures> shared) {
    FrameHeader header;
    bool keep = false;
    {
        std::lock_guard lock(mutex_);
        still_.reset();
        keep = client_.exact && frame.final && !frame.picture && !frame.view.moving && frame.view.settings.exactAtRest;
        header.frameId = ++lastFrameId_;
        if (!frame.picture) line_.begin(header.frameId, secondsNow(), frame.view.moving);
        if (!frame.picture && frame.view.moving) smooth(frameSeconds_, frame.figures.lastPassSeconds);
        header.codec = codecOf(frame);
        const bool video = isVideo(header.codec);
        if (video || header.codec == FrameCodec::jpeg) header.quality = static_cast<uint8_t>(qualityOf(frame));
        if (video && std::exchange(keyWanted_, false)) header.flags = FRAME_KEY;
        if (!frame.picture) sentAs_ = header.codec;
        if (video) unwritten_ = true, shared.reset();
    }
    encoder_.encode(std::move(frame), header, keep, std::move(shared));
}

bool Viewer::refine() {
    if (encoder_.busy()) return false;
    FrameHeader header;
    std::shared_ptr<const StillPicture> still;
    uint32_t first, rows;
    {
        std::lock_guard lock(mutex_);
        if (!still_ || unwritten_ || !client_.visible || !line_.room(frameSeconds_, MAX_UNACKED)) return false;
        still = still_;
        first = stillRows_;
        const DisplayImage& image = still->shared->image;
        rows = std::min(std::max(PART_PIXELS / image.width, 1u), image.height - first);
        stillRows_ += rows;
        if (stillRows_ == image.height) still_.reset();
        header.frameId = ++lastFrameId_;
        line_.begin(header.frameId, secondsNow());
    }
    encoder_.encode(std::move(still), first, rows, header);
    return true;
}

/// With the lock held. While pictures change they may be a video, for who can decode one.
FrameCodec Viewer::codecOf(const FinishedFrame& frame) {
    if (frame.picture) return savedCodec(frame.picture->format);
    const auto setting = static_cast<CodecSetting>(frame.view.settings.codec);
    const FrameCodec video = videoOf(frame, client_);
    choosesCodec_ = setting == CodecSetting::automatic && frame.view.settings.adaptiveQuality && isVideo(video);
    if (!choosesCodec_) codec_.reset();
    const bool wanted = setting != CodecSetting::automatic || codec_.video();
    return wanted && (frame.view.moving || !frame.final) ? video : FrameCodec::jpeg;
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
        if (!frame->shared) {  // told by whose thread made it
            metrics_.stages[Metrics::develop].add(1e-6 * frame->header.developMicros);
            metrics_.stages[Metrics::encode].add(1e-6 * frame->header.encodeMicros);
        }
        std::lock_guard lock(mutex_);
        send(std::move(*frame));
    } else {
        {
            std::lock_guard lock(mutex_);
            line_.drop(frameId);  // it will never be acknowledged
            still_.reset();       // without one of its parts it is of no use
            keyWanted_ = true;
            if (video()) unwritten_ = false;
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
    } else if (frame.header.kind == FrameKind::part) {
        line_.sent(frame.header.frameId, frame.picture.bytes.size() - SOCKET_HEADROOM, secondsNow());
        metrics_.frameBytesSent += frame.picture.bytes.size() - SOCKET_HEADROOM;
        unwritten_ = true;
    } else {
        // Where a newer one was taken meanwhile, this picture is not the last.
        if (frame.header.frameId == lastFrameId_) still_ = std::move(frame.still);
        stillRows_ = 0;
        unwritten_ = true;
        if (frame.header.flags & FRAME_KEY) lastKey_ = frame.header.frameId;
        stats_.frameSent(frame);
        smooth(pictureSeconds_, frame.coreSeconds);
        line_.sent(frame.header.frameId, frame.picture.bytes.size() - SOCKET_HEADROOM, secondsNow());
        metrics_.framesSent++;
        metrics_.frameBytesSent += frame.picture.bytes.size() - SOCKET_HEADROOM;
        metrics_.stages[Metrics::input].add(1e-6 * frame.header.inputMicros);
        if (frame.errors) socket_->sendText(errorsMessage(frame.header.frameId, *frame.errors));
        if (frame.figures.partition)
            socket_->sendText(partitionMessage(frame.header.frameId, *frame.figures.partition, frame.figures.schedule));
    }
    if (std::optional<uint32_t> replaced = socket_->sendPicture(std::move(frame.picture))) {
        metrics_.framesReplaced++;
        keyWanted_ = true;
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
            this->queued(*queued, now);
        }
        if (message.undecodable && message.frameId >= lastKey_) keyWanted_ = true;
    }
    if (message.presentedMs && *message.presentedMs >= 0.0) metrics_.motionToPhoton.add(*message.presentedMs * 1e-3);
    listener_.drained();
}

/// With the lock held.
void Viewer::queued(const QueueDelay& delay, double now) {
    ladder_.seen(delay.total(), now);
    smooth(figures_.lineDelay, delay.line);
    smooth(figures_.viewerDelay, delay.viewer);
    if (choosesCodec_ && codec_.seen(ladder_.level(), figures_.lineDelay, figures_.viewerDelay, now)) ladder_.reset();
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
    if (kind == FrameKind::picture) return;
    {
        std::lock_guard lock(mutex_);
        unwritten_ = false;
        if (kind == FrameKind::frame) stats_.frameWritten(waitSeconds, writeSeconds);
        if (!still_ && !video()) return;
    }
    listener_.drained();
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
    stats.line.codec = sentAs_;
    stats.line.forLine = codec_.video();
    stats.line.quality = qualityAt(ladder_.level(), quality_);
    stats.line.roundTrip = line_.leastRoundTrip();
    stats.line.bytesPerSecond = line_.bytesPerSecond();
    return stats;
}

bool Viewer::statsChanged(Turns::Used used) const {
    std::lock_guard lock(mutex_);
    return stats_.changed(used);
}

}  // namespace heliograph
