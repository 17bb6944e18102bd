#include "server/viewer/picture_maker.h"

#include "server/base/clock.h"
#include "server/encode/exr_encoder.h"
#include "server/encode/jpeg_encoder.h"
#include "server/encode/png_encoder.h"
#include "server/encode/tone_map.h"
#include "server/encode/video_encoder.h"

#include <algorithm>

namespace heliograph {

namespace {

constexpr uint32_t BAND_ROWS = 16;  // developed and coded at once: the floats stay in the cache

/// A picture that is saved may wait: only its own thread works on it.
StripeThreads threadsFor(const FinishedFrame& frame) { return frame.picture ? StripeThreads::own : StripeThreads::all; }

/// Returns the processor time that other threads spent on it.
double develop(const FinishedFrame& frame, DisplayImage& display) {
    const Film& film = *frame.film;
    const uvec2 size = frame.size;
    const ToneMap toneMap(frame.view.settings.exposure + frame.sceneExposure + frame.autoExposure.value_or(0.0f),
                          shownCurve(static_cast<ToneCurve>(frame.view.settings.toneCurve), frame.fromFile));
    display.width = size.x;
    display.height = size.y;
    display.rgba.resize(static_cast<size_t>(size.x) * size.y * 4);
    const vec4* denoised = frame.denoised ? frame.denoised->data() : nullptr;
    return forEachStripe((size.y + BAND_ROWS - 1) / BAND_ROWS, threadsFor(frame), [&](uint32_t i) {
        thread_local std::vector<vec4> band;
        band.resize(static_cast<size_t>(size.x) * BAND_ROWS);
        const uint32_t row = i * BAND_ROWS, end = std::min(row + BAND_ROWS, size.y);
        if (!denoised) film.develop(row, end, band.data());
        toneMap.apply(denoised ? denoised + static_cast<size_t>(row) * size.x : band.data(),
                      static_cast<size_t>(end - row) * size.x, &display.rgba[static_cast<size_t>(row) * size.x * 4]);
    });
}

uint32_t micros(double seconds) { return static_cast<uint32_t>(std::clamp(seconds * 1e6, 0.0, 4.0e9)); }

/// What the header says of the frame, whatever it is encoded as.
void describe(const FinishedFrame& frame, FrameHeader& header) {
    header.kind = frame.picture ? FrameKind::picture : FrameKind::frame;
    header.flags = static_cast<uint8_t>((header.flags & FRAME_KEY) | (frame.view.moving ? FRAME_MOVING : 0) |
                                        (frame.final ? FRAME_FINAL : 0) | (frame.errorReached ? FRAME_ERROR_REACHED : 0) |
                                        (frame.path ? FRAME_PATH : 0) | (frame.denoised ? FRAME_DENOISED : 0));
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
    std::unique_ptr<Encoder> jpeg = makeJpegEncoder(StripeThreads::all);
    std::unique_ptr<Encoder> savedJpeg = makeJpegEncoder(StripeThreads::own);
    std::unique_ptr<Encoder> png = makePngEncoder();
    std::unique_ptr<VideoEncoder> video;  // as long as pictures are sent as one
    FrameCodec videoCodec = FrameCodec::vp9;

    /// The one of that codec: another one's pictures were of another video.
    VideoEncoder& videoOf(FrameCodec codec) {
        if (!video || videoCodec != codec)
            video = makeVideoEncoder(codec == FrameCodec::h264 ? VideoCodec::h264 : VideoCodec::vp9);
        videoCodec = codec;
        return *video;
    }
};

void PictureMaker::rest() {
    encoders_->jpeg->rest();
    encoders_->savedJpeg->rest();
    pixels_ = {};
    display_ = {};
    made_ = {};
}

PictureMaker::PictureMaker() : encoders_(std::make_unique<Encoders>()) {}
PictureMaker::~PictureMaker() = default;

/// What was developed.
void PictureMaker::encode(const FinishedFrame& frame, const PictureKey& key, MadePicture& made) {
    switch (key.codec) {
        case FrameCodec::exr: return encodeExr(pixels_, frame.size, made.payload);
        case FrameCodec::png: encoders_->png->encode(display_, key.quality, made.payload); return;
        case FrameCodec::vp9:
        case FrameCodec::h264: {
            VideoEncoder& video = encoders_->videoOf(key.codec);
            if (key.beginsVideo) video.wantKey();
            made.helpSeconds += video.encode(display_, key.quality, made.payload);
            made.keyPicture = video.key();
            return;
        }
        case FrameCodec::jpeg:
            if (frame.view.moving && !frame.picture) encoders_->video.reset();  // pictures are no video any more
            made.helpSeconds +=
                (frame.picture ? encoders_->savedJpeg : encoders_->jpeg)->encode(display_, key.quality, made.payload);
    }
}

/// Develops and encodes.
void PictureMaker::paint(const FinishedFrame& frame, const PictureKey& key, bool several, MadePicture& made) {
    StopWatch watch;
    made.helpSeconds = 0.0;
    made.keyPicture = false;
    if (key.codec == FrameCodec::exr && frame.denoised) pixels_ = *frame.denoised;
    else if (key.codec == FrameCodec::exr) frame.film->develop(pixels_);
    else made.helpSeconds = develop(frame, display_);
    made.relativeError = static_cast<float>(frame.film->relativeError());
    made.developSeconds = watch.seconds();
    watch.restart();
    encode(frame, key, made);
    made.encodeSeconds = watch.seconds();
    made.still.reset();
    if (!key.keep) return;
    auto still = std::make_shared<StillPicture::Shared>();
    still->several = several;
    still->image = std::move(display_);
    made.still = std::move(still);
}

EncodedFrame PictureMaker::make(const FinishedFrame& frame, FrameHeader header, bool keep, SharedPictures* shared) {
    EncodedFrame result;
    const double before = threadCpuSeconds();
    const PictureKey key{header.codec, header.quality, keep, (header.flags & FRAME_KEY) != 0};
    std::shared_ptr<const MadePicture> ofAll;
    if (shared) {
        result.shared = true;
        ofAll = shared->get(key, [&] {
            result.shared = false;
            MadePicture made;
            paint(frame, key, true, made);
            return made;
        });
    } else {
        paint(frame, key, false, made_);
    }
    const MadePicture& made = ofAll ? *ofAll : made_;
    header.relativeError = made.relativeError;
    header.flags = made.keyPicture ? FRAME_KEY : 0;
    header.developMicros = micros(made.developSeconds);
    header.encodeMicros = micros(made.encodeSeconds);
    describe(frame, header);
    result.header = header;
    finish(result, made.payload, 0);
    result.coreSeconds = threadCpuSeconds() - before + (result.shared ? 0.0 : made.helpSeconds);
    writeFrameHeader(result.header, std::span(result.picture.bytes).subspan<SOCKET_HEADROOM, FRAME_HEADER_BYTES>());
    result.figures = frame.figures;
    result.order = frame.picture;
    result.targetSamples = frame.view.settings.samples;
    result.forecast = frame.forecast;
    result.refined = frame.refined;
    result.autoExposure = frame.autoExposure;
    if (frame.view.settings.showError && !frame.picture) result.errors = frame.film->errorMap(uvec2(CELL_SIZE));
    if (made.still) result.still = std::make_shared<StillPicture>(StillPicture{made.still, result.header});
    return result;
}

/// Puts the payload behind room for the header and the place of a part.
void PictureMaker::finish(EncodedFrame& result, std::span<const uint8_t> payload, size_t placeBytes) {
    result.header.payloadBytes = static_cast<uint32_t>(payload.size());
    std::vector<uint8_t>& bytes = result.picture.bytes;
    bytes.reserve(SOCKET_HEADROOM + FRAME_HEADER_BYTES + placeBytes + payload.size());
    bytes.resize(SOCKET_HEADROOM + FRAME_HEADER_BYTES + placeBytes);
    bytes.insert(bytes.end(), payload.begin(), payload.end());
    result.picture.kind = result.header.kind;
    result.picture.frameId = result.header.frameId;
    result.picture.encoded = std::chrono::steady_clock::now();
}

EncodedFrame PictureMaker::makePart(const StillPicture& still, uint32_t firstRow, uint32_t rows, FrameHeader header) {
    EncodedFrame result;
    StopWatch watch;
    const double before = threadCpuSeconds();
    const DisplayImage& image = still.shared->image;
    const auto encode = [&] {
        const size_t rowBytes = static_cast<size_t>(image.width) * 4;
        const auto from = image.rgba.begin() + static_cast<ptrdiff_t>(firstRow * rowBytes);
        display_.width = image.width;
        display_.height = rows;
        display_.rgba.assign(from, from + static_cast<ptrdiff_t>(rows * rowBytes));
        std::vector<uint8_t> payload;
        encoders_->png->encode(display_, 0, payload);
        return payload;
    };
    std::shared_ptr<const std::vector<uint8_t>> ofAll;
    if (still.shared->several) ofAll = still.shared->parts.get(firstRow, encode);
    else made_.payload = encode();
    result.header = still.header;
    result.header.kind = FrameKind::part;
    result.header.codec = FrameCodec::png;
    result.header.quality = 0;
    result.header.frameId = header.frameId;
    result.header.developMicros = result.header.renderMicros = result.header.inputMicros = 0;
    result.header.encodeMicros = micros(watch.seconds());
    finish(result, ofAll ? *ofAll : made_.payload, PART_PLACE_BYTES);
    result.coreSeconds = threadCpuSeconds() - before;
    writePartHeader(result.header, {{0, firstRow}, {image.width, rows}},
                    std::span(result.picture.bytes).subspan<SOCKET_HEADROOM, FRAME_HEADER_BYTES + PART_PLACE_BYTES>());
    return result;
}

}  // namespace heliograph
