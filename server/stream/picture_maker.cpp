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

}  // namespace

struct PictureMaker::Encoders {
    std::unique_ptr<Encoder> jpeg = makeJpegEncoder();
    std::unique_ptr<Encoder> png = makePngEncoder();
};

PictureMaker::PictureMaker() : encoders_(std::make_unique<Encoders>()) {}
PictureMaker::~PictureMaker() = default;

MakingCosts PictureMaker::make(const FinishedFrame& frame, FrameCodec codec, uint32_t quality, size_t front,
                               std::vector<uint8_t>& bytes) {
    MakingCosts costs;
    StopWatch watch;
    const double before = threadCpuSeconds();
    if (codec == FrameCodec::exr) frame.film->develop(pixels_);
    else develop(frame, pixels_, display_);
    costs.relativeError = frame.film->relativeError();
    costs.developSeconds = watch.seconds();
    watch.restart();
    if (codec == FrameCodec::exr) encodeExr(pixels_, frame.size, payload_);
    else if (codec == FrameCodec::png) encoders_->png->encode(display_, quality, payload_);
    else encoders_->jpeg->encode(display_, quality, payload_);
    bytes.resize(front);
    bytes.insert(bytes.end(), payload_.begin(), payload_.end());
    costs.encodeSeconds = watch.seconds();
    costs.coreSeconds = threadCpuSeconds() - before;
    return costs;
}

}  // namespace heliograph
