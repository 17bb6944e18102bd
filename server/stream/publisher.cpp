#include "server/stream/publisher.h"

#include <algorithm>

namespace heliograph {

namespace {

uint32_t micros(double seconds) { return static_cast<uint32_t>(std::clamp(seconds * 1e6, 0.0, 4.0e9)); }

FrameHeader headerOf(const Publisher::Order& order, const MakingCosts& costs, size_t payloadBytes) {
    const FinishedFrame& frame = order.frame;
    FrameHeader header;
    header.kind = frame.kind == FinishedFrame::Kind::frame ? FrameKind::frame : FrameKind::picture;
    header.codec = order.codec;
    header.flags = static_cast<uint8_t>((frame.view.moving ? FRAME_MOVING : 0) | (frame.final ? FRAME_FINAL : 0) |
                                        (frame.path ? FRAME_PATH : 0));
    header.quality = order.codec == FrameCodec::jpeg ? static_cast<uint8_t>(order.quality) : 0;
    header.frameId = order.frameId;
    header.inputId = frame.view.inputId;
    header.generation = frame.generation;
    header.size = frame.size;
    header.fullSize = frame.view.resolution;
    header.samples = frame.samples;
    header.relativeError = static_cast<float>(costs.relativeError);
    header.renderMicros = micros(frame.figures.lastPassSeconds);
    header.developMicros = micros(costs.developSeconds);
    header.encodeMicros = micros(costs.encodeSeconds);
    header.inputMicros = micros(frame.inputSeconds);
    header.payloadBytes = static_cast<uint32_t>(payloadBytes);
    header.devices = frame.figures.devices;
    return header;
}

}  // namespace

Publisher::Publisher(Done done) : done_(std::move(done)), thread_([this] { run(); }) {}

void Publisher::finish() {
    orders_.close();
    if (thread_.joinable()) thread_.join();
}

void Publisher::publish(Order order) {
    busy_.store(true, std::memory_order_release);
    orders_.put(std::move(order));
}

void Publisher::run() {
    while (std::optional<Order> order = orders_.wait()) {
        std::optional<Published> published;
        std::string failure;
        try {
            published = make(*order);
        } catch (const std::exception& e) {
            failure = e.what();
        }
        uint32_t frameId = order->frameId;
        order.reset();  // the film is free for the next pass
        busy_.store(false, std::memory_order_release);
        done_(frameId, std::move(published), failure);
    }
}

Published Publisher::make(const Order& order) {
    Published result;
    std::vector<uint8_t>& bytes = result.picture.bytes;
    const size_t front = SOCKET_HEADROOM + FRAME_HEADER_BYTES;
    result.costs = maker_.make(order.frame, order.codec, order.quality, front, bytes);
    result.header = headerOf(order, result.costs, bytes.size() - front);
    writeFrameHeader(result.header, std::span(bytes).subspan<SOCKET_HEADROOM, FRAME_HEADER_BYTES>());
    result.picture.kind = result.header.kind;
    result.picture.frameId = order.frameId;
    result.picture.encoded = std::chrono::steady_clock::now();
    result.figures = order.frame.figures;
    result.targetSamples = order.frame.view.settings.samples;
    return result;
}

}  // namespace heliograph
