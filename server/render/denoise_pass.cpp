#include "server/render/denoise_pass.h"

#include "server/base/clock.h"
#include "server/base/error.h"
#include "server/request/device_rows.h"

#include <new>
#include <stdexcept>

namespace heliograph {

bool DenoisePass::wanted(const FrameRequest& request) {
    const auto setting = static_cast<DenoiserSetting>(request.settings.denoiser);
    if (setting == DenoiserSetting::off || !canDenoise(request)) return false;
    if (setting == DenoiserSetting::oidn) OidnLibrary::get();
    return true;
}

std::shared_ptr<const std::vector<vec4>> DenoisePass::run(PassRenderer& passes, const Pass& picture, double white,
                                                          PassFigures& figures) {
    took_ = {};
    try {
        if (!renderGuides(passes, picture, figures)) return nullptr;
        const StopWatch watch;
        job_.take(picture.film, guides_, static_cast<float>(white));
        filter(picture);
        took_.filterMs = watch.milliseconds();
        took_.deviceMs = 1e3 * job_.deviceSeconds;
        if (!shown_ || shown_.use_count() > 1) shown_ = std::make_shared<std::vector<vec4>>();
        shown_->swap(job_.light);
        return shown_;
    } catch (const std::bad_alloc&) {
        forget();
        const uvec2 size = picture.film.resolution();
        throw std::runtime_error("no memory to denoise " + std::to_string(size.x) + " x " + std::to_string(size.y) + " pixels");
    }
}

void DenoisePass::forget() {
    guides_.reset(uvec2(0), 0);
    guidesOf_.reset();
    job_ = {};
    shown_.reset();
    processor_ = ProcessorDenoiser();
    oidn_.reset();
}

bool DenoisePass::renderGuides(PassRenderer& passes, const Pass& picture, PassFigures& figures) {
    if (guidesOf_ == picture.film.generation() && guides_.resolution() == picture.film.resolution()) return true;
    guidesOf_.reset();
    const FrameRequest request = guideRequest(picture.request, ++generation_);
    guides_.reset(picture.film.resolution(), generation_);
    ViewMemory view;  // guides cost what no picture costs
    PassFigures own;
    const StopWatch watch;
    if (!passes.renderBeside({picture.renderer, request, guides_, view, 0, picture.stop, {}, picture.urgency}, own))
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
    } else if (!picture.renderer.denoise(picture.request.settings, job_)) {
        processor_.run(job_);
    }
}

}  // namespace heliograph
