#include "server/render/denoise_pass.h"

#include "server/base/clock.h"
#include "server/base/error.h"
#include "server/base/machine.h"
#include "server/request/device_rows.h"

#include <new>
#include <stdexcept>
#include <utility>

namespace heliograph {

namespace {

/// As for films (film_pool.h): beside them, before any of it is taken.
void checkRoom(uvec2 size) {
    constexpr uint64_t LARGE = 1 << 20, BYTES = 144;  // pixels; of a pixel at most
    const uint64_t pixels = uint64_t{size.x} * size.y;
    if (pixels > LARGE && !areAddressesLeft(pixels * BYTES + ROOM_FOR_DRIVERS)) throw std::bad_alloc();
}

}  // namespace

bool DenoisePass::wanted(const FrameRequest& request) {
    const auto setting = static_cast<DenoiserSetting>(request.settings.denoiser);
    if (setting == DenoiserSetting::off || !canDenoise(request)) return false;
    if (setting == DenoiserSetting::oidn) OidnLibrary::get();
    return true;
}

std::shared_ptr<const std::vector<vec4>> DenoisePass::run(PassRenderer& passes, const Pass& picture, double white,
                                                          PassFigures& figures) {
    took_ = {};
    if (picture.renderer.infoFor(picture.request.settings).drawsWhole) return nullptr;
    try {
        checkRoom(picture.film.resolution());
        if (!renderGuides(passes, picture, figures)) return nullptr;
        const StopWatch watch;
        job_.take(picture.film, *guides_, static_cast<float>(white));
        filter(picture);
        job_.giveBack();
        took_.filterMs = watch.milliseconds();
        took_.deviceMs = 1e3 * job_.deviceSeconds;
        return std::make_shared<const std::vector<vec4>>(std::exchange(job_.light, {}));
    } catch (const std::bad_alloc&) {
        forget();
        const uvec2 size = picture.film.resolution();
        throw std::runtime_error("no memory to denoise " + std::to_string(size.x) + " x " + std::to_string(size.y) + " pixels");
    }
}

void DenoisePass::forget() {
    guides_.reset();
    guidesOf_.reset();
    job_ = {};
    processor_ = ProcessorDenoiser();
    oidn_.reset();
}

bool DenoisePass::renderGuides(PassRenderer& passes, const Pass& picture, PassFigures& figures) {
    if (guides_ && guidesOf_ == picture.film.generation() && guides_->resolution() == picture.film.resolution()) return true;
    guidesOf_.reset();
    const FrameRequest request = guideRequest(picture.request, ++generation_);
    if (!guides_) guides_ = std::make_unique<Film>();
    guides_->reset(picture.film.resolution(), generation_);
    ViewMemory view;  // guides cost what no picture costs
    PassFigures own;
    const StopWatch watch;
    if (!passes.renderBeside({picture.renderer, request, *guides_, view, 0, picture.stop, {}, picture.urgency}, own))
        return false;
    took_.guidesMs = watch.milliseconds();
    figures.rays.add(own.rays);
    figures.coreSeconds += own.coreSeconds;
    if ((own.devices & deviceBit(device_name::raster)) != 0) return false;
    guidesOf_ = picture.film.generation();
    return true;
}

void DenoisePass::filter(const Pass& picture) {
    if (static_cast<DenoiserSetting>(picture.request.settings.denoiser) == DenoiserSetting::oidn) {
        if (!oidn_) oidn_ = std::make_unique<OidnDenoiser>();
        oidn_->run(job_);
        return;
    }
    try {
        if (picture.renderer.denoise(picture.request.settings, job_)) return;
    } catch (const DeviceMemoryError&) {  // there may be some on this side
    }
    processor_.run(job_);
}

}  // namespace heliograph
