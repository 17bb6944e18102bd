#include "server/stream/viewer.h"

#include "server/base/log.h"
#include "server/stream/messages.h"

#include <algorithm>

namespace heliograph {

namespace {

constexpr uint32_t FINAL_QUALITY = 92;    // least JPEG quality of the last frame of a view
constexpr uint32_t PICTURE_QUALITY = 95;  // of a JPEG that was asked for

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
    if (flights_.size() < MAX_UNACKED) return Readiness::ready;
    return Clock::now() - flights_.front().since > STALL_PAUSE ? Readiness::stalled : Readiness::noCredit;
}

bool Viewer::nothingOnItsWay() const {
    if (encoder_.busy()) return false;
    std::lock_guard lock(mutex_);
    return flights_.empty() || Clock::now() - flights_.front().since > STALL_PAUSE;
}

void Viewer::take(FinishedFrame frame) {
    FrameHeader header;
    header.codec = frame.picture ? codecOf(frame.picture->format) : FrameCodec::jpeg;
    {
        std::lock_guard lock(mutex_);
        header.frameId = ++lastFrameId_;
        if (!frame.picture) flights_.push_back({header.frameId, Clock::now()});
        const uint32_t quality = frame.picture ? PICTURE_QUALITY : frame.final ? std::max(quality_, FINAL_QUALITY) : quality_;
        if (header.codec == FrameCodec::jpeg) header.quality = static_cast<uint8_t>(quality);
    }
    encoder_.encode(std::move(frame), header);
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
            landed(frameId);  // it will never be acknowledged
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
        pictureSeconds_ = pictureSeconds_ > 0.0 ? 0.8 * pictureSeconds_ + 0.2 * frame.coreSeconds : frame.coreSeconds;
        metrics_.framesSent++;
        metrics_.frameBytesSent += frame.picture.bytes.size() - SOCKET_HEADROOM;
        metrics_.stages[Metrics::input].add(1e-6 * frame.header.inputMicros);
        if (frame.figures.partition)
            socket_->sendText(partitionMessage(frame.header.frameId, *frame.figures.partition, frame.figures.schedule));
    }
    if (std::optional<uint32_t> replaced = socket_->sendPicture(std::move(frame.picture))) {
        metrics_.framesReplaced++;
        landed(*replaced);
    }
}

void Viewer::acknowledge(const AckMessage& message) {
    {
        std::lock_guard lock(mutex_);
        if (message.frameId > lastFrameId_) {
            throw InputError("ack.frameId", std::to_string(message.frameId), "at most " + std::to_string(lastFrameId_));
        }
        landed(message.frameId);
    }
    if (message.presentedMs && *message.presentedMs >= 0.0) metrics_.motionToPhoton.add(*message.presentedMs * 1e-3);
    listener_.drained();
}

/// The frame is not on its way any more; with the lock held. Pictures and frames acknowledged twice are not found, which is
/// fine.
void Viewer::landed(uint32_t frameId) {
    std::erase_if(flights_, [&](const Flight& flight) { return flight.frameId == frameId; });
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
        if (flights_.empty() || now - flights_.front().since <= STALL_CLOSE) return false;
        flights_.clear();  // closed once
    }
    metrics_.viewersStalled++;
    log().warn("viewer {}: nothing acknowledged for {} s, closed", number_, STALL_CLOSE.count());
    socket_->close(CloseCode::stalled, "frames were not acknowledged for 10 seconds");
    return true;
}

ViewerStats Viewer::takeStats(double seconds, Turns::Used used) {
    std::lock_guard lock(mutex_);
    return stats_.take(seconds, used);
}

}  // namespace heliograph
