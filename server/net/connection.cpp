#include "server/net/connection.h"

#include <algorithm>

namespace heliograph {

void Connection::sendText(std::string text) {
    {
        std::lock_guard lock(mutex_);
        if (gone_ || closing_) return;
        textBytes_ += text.size();
        if (textBytes_ > TEXT_WAITING) closing_ = Closing{CloseCode::stalled, "too much waits to be read"};
        else texts_.push_back(std::string(SOCKET_HEADROOM, '\0') + text);
    }
    wake_();
}

std::optional<uint32_t> Connection::sendPicture(OutgoingPicture picture) {
    std::optional<uint32_t> replaced;
    {
        std::lock_guard lock(mutex_);
        if (gone_ || closing_) return std::nullopt;
        if (picture.kind == FrameKind::picture) {
            if (pictures_.size() >= PICTURES_WAITING) closing_ = Closing{CloseCode::stalled, "too much waits to be read"};
            else pictures_.push_back(std::move(picture));
        } else {
            if (frame_) replaced = frame_->frameId;
            frame_ = std::move(picture);
        }
    }
    wake_();
    return replaced;
}

void Connection::close(CloseCode code, const std::string& reason) {
    {
        std::lock_guard lock(mutex_);
        if (gone_ || closing_) return;
        closing_ = Closing{code, reason};
    }
    wake_();
}

std::optional<Connection::Piece> Connection::nextPiece(std::chrono::steady_clock::time_point now) {
    std::unique_lock lock(mutex_);
    if (!current_ && !texts_.empty()) {
        text_ = std::move(texts_.front());
        texts_.pop_front();
        textBytes_ -= text_.size() - SOCKET_HEADROOM;
        auto* bytes = reinterpret_cast<uint8_t*>(text_.data());
        return Piece{{bytes + SOCKET_HEADROOM, text_.size() - SOCKET_HEADROOM}, true, true, true};
    }
    if (!current_ && closing_) return std::nullopt;
    if (!current_) {
        if (frame_) {
            current_ = std::exchange(frame_, std::nullopt);
        } else if (!pictures_.empty()) {
            current_ = std::move(pictures_.front());
            pictures_.pop_front();
        } else {
            return std::nullopt;
        }
        offset_ = SOCKET_HEADROOM;
        writing_ = 0.0;
        waited_ = std::chrono::duration<double>(now - current_->encoded).count();
        auto micros = static_cast<uint32_t>(std::clamp(waited_ * 1e6, 0.0, 4.0e9));
        stampSendTime(std::span(current_->bytes).subspan<SOCKET_HEADROOM, FRAME_HEADER_BYTES>(), micros);
    }
    size_t left = current_->bytes.size() - offset_;
    size_t count = std::min(left, PIECE_BYTES);
    Piece piece{std::span(current_->bytes).subspan(offset_, count), false, offset_ == SOCKET_HEADROOM, count == left};
    offset_ += count;
    return piece;
}

void Connection::pieceWritten(double seconds) {
    if (!current_) return;
    writing_ += seconds;
    if (offset_ < current_->bytes.size()) return;
    FrameKind kind = current_->kind;
    current_.reset();
    if (peer) peer->written(kind, waited_, writing_);
}

bool Connection::hasOutput() const {
    std::lock_guard lock(mutex_);
    return current_ || !texts_.empty() || frame_ || !pictures_.empty() || closing_;
}

std::optional<Connection::Closing> Connection::closing() const {
    std::lock_guard lock(mutex_);
    if (current_ || !texts_.empty()) return std::nullopt;
    return closing_;
}

std::optional<CloseCode> Connection::closeAsked() const {
    std::lock_guard lock(mutex_);
    return closing_ ? std::optional(closing_->code) : std::nullopt;
}

std::optional<CloseCode> Connection::receive(std::string_view piece, bool binary, bool last, double now) {
    if (binary) return CloseCode::unsupportedData;
    if (incoming_.size() + piece.size() > MESSAGE_LIMIT) return CloseCode::messageTooBig;
    if (!bytes_.take(static_cast<double>(piece.size()), now)) return CloseCode::policyViolation;
    incoming_ += piece;
    if (!last) return std::nullopt;
    if (!messages_.take(1.0, now)) return CloseCode::policyViolation;
    std::string message = std::exchange(incoming_, {});
    if (peer) peer->receive(message);
    return std::nullopt;
}

void Connection::disconnect() {
    std::lock_guard lock(mutex_);
    gone_ = true;
    texts_.clear();
    frame_.reset();
    pictures_.clear();
    current_.reset();
    closing_.reset();
}

}  // namespace heliograph
