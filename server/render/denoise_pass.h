#pragma once
// The denoiser as a picture's last pass: renders the guides with the device, once a film, and filters.

#include "server/denoise/denoiser.h"
#include "server/denoise/oidn.h"
#include "server/render/pass_renderer.h"

#include <optional>

namespace heliograph {

/// Order as in the setting `denoiser`.
enum class DenoiserSetting : uint32_t { off, filter, oidn };

/// What it took.
struct DenoiseFigures {
    double guidesMs = 0.0;  // 0 where the film's guides were there already
    double filterMs = 0.0;  // with the way in and out
    double deviceMs = 0.0;  // of it on a device, by its own clock; 0: none has filtered
};

class DenoisePass {
public:
    /// Whether the request's pictures are filtered: it asks for it, and its effects let it. Throws InputError where Open Image
    /// Denoise is asked for and is not there.
    static bool wanted(const FrameRequest& request);
    /// Filters what the film holds of `picture`, whose request, film and renderer it takes, into linear RGB, row-major. `white`:
    /// radiance that is shown white, Film::WHITE at exposure 0. Nothing when
    /// `stop` was asked for first, or the device knows no guides (raster previews). Adds to `figures` what the
    /// guides took. Throws what PassRenderer does, and std::runtime_error for want of memory.
    std::shared_ptr<const std::vector<vec4>> run(PassRenderer& passes, const Pass& picture, double white, PassFigures& figures);
    const DenoiseFigures& took() const { return took_; }
    /// Lets go of its memory.
    void forget();

private:
    bool renderGuides(PassRenderer& passes, const Pass& picture, PassFigures& figures);
    void filter(const Pass& picture);

    std::unique_ptr<Film> guides_;
    std::optional<uint32_t> guidesOf_;  // generation of the film whose guides they are
    uint32_t generation_ = 0;
    DenoiseJob job_;
    ProcessorDenoiser processor_;
    std::unique_ptr<OidnDenoiser> oidn_;
    DenoiseFigures took_;
};

}  // namespace heliograph
