#include "server/stream/picture_maker.h"

#include "server/base/clock.h"
#include "server/encode/exr_encoder.h"
#include "server/encode/jpeg_encoder.h"
#include "server/encode/png_encoder.h"
#include "server/encode/tone_map.h"

#include <algorithm>

namespace heliograph {

namespace {

constexpr uint32_t BAND_ROWS = 16;  // developed and coded at once: the floats stay in the cache

void develop(const FinishedFrame& frame, std::vector<vec4>& band, DisplayImage& display) {
    const Film& film = *frame.film;
    const uvec2 size = frame.size;
    const ToneMap toneMap(frame.view.settings.exposure + frame.sceneExposure,
                          static_cast<ToneCurve>(frame.view.settings.toneCurve));
    display.width = size.x;
    display.height = size.y;
    display.rgba.resize(static_cast<size_t>(size.x) * size.y * 4);
    band.resize(static_cast<size_t>(size.x) * BAND_ROWS);
    for (uint32_t row = 0; row < size.y; row += BAND_ROWS) {
        uint32_t end = std::min(row + BAND_ROWS, size.y);
        film.develop(row, end, band.data());
        toneMap.apply(band.data(), static_cast<size_t>(end - row) * size.x,
                      &display.rgba[static_cast<size_t>(row) * size.x * 4]);
    }
}

uint32_t micros(double seconds) { return static_cast<uint32_t>(std::clamp(seconds * 1e6, 0.0, 4.0e9)); }

/// What the header says of the frame, whatever it is encoded as.
void describe(const FinishedFrame& frame, FrameHeader& header) {
    header.kind = frame.picture ? FrameKind::picture : FrameKind::frame;
    header.flags = static_cast<uint8_t>((frame.view.moving ? FRAME_MOVING : 0) | (frame.final ? FRAME_FINAL : 0) |
                                        (frame.path ? FRAME_PATH : 0));
    header.inputId = frame.view.inputId;
    header.generation = frame.generation;
    header.size = frame.size;
    header.fullSize = frame.view.resolution;
    header.samples = frame.samples;
    header.renderMicros = micros(frame.figures.lastPassSeconds);
    header.inputMicros = micros(frame.inputSeconds);
    header.devices = frame.figures.devices;
}

}  // namespace

struct PictureMaker::Encoders {
    std::unique_ptr<Encoder> jpeg = makeJpegEncoder();
    std::unique_ptr<Encoder> png = makePngEncoder();
};

PictureMaker::PictureMaker() : encoders_(std::make_unique<Encoders>()) {}
PictureMaker::~PictureMaker() = default;

EncodedFrame PictureMaker::make(const FinishedFrame& frame, FrameHeader header) {
    EncodedFrame result;
    StopWatch watch;
    const double before = threadCpuSeconds();
    if (header.codec == FrameCodec::exr) frame.film->develop(pixels_);
    else develop(frame, pixels_, display_);
    header.relativeError = static_cast<float>(frame.film->relativeError());
    header.developMicros = micros(watch.seconds());
    watch.restart();
    if (header.codec == FrameCodec::exr) encodeExr(pixels_, frame.size, payload_);
    else if (header.codec == FrameCodec::png) encoders_->png->encode(display_, header.quality, payload_);
    else encoders_->jpeg->encode(display_, header.quality, payload_);
    header.payloadBytes = static_cast<uint32_t>(payload_.size());
    std::vector<uint8_t>& bytes = result.picture.bytes;
    bytes.reserve(SOCKET_HEADROOM + FRAME_HEADER_BYTES + payload_.size());
    bytes.resize(SOCKET_HEADROOM + FRAME_HEADER_BYTES);
    bytes.insert(bytes.end(), payload_.begin(), payload_.end());
    header.encodeMicros = micros(watch.seconds());
    result.coreSeconds = threadCpuSeconds() - before;

    describe(frame, header);
    writeFrameHeader(header, std::span(bytes).subspan<SOCKET_HEADROOM, FRAME_HEADER_BYTES>());
    result.picture.kind = header.kind;
    result.picture.frameId = header.frameId;
    result.picture.encoded = std::chrono::steady_clock::now();
    result.header = header;
    result.figures = frame.figures;
    result.order = frame.picture;
    result.targetSamples = frame.view.settings.samples;
    return result;
}

}  // namespace heliograph
