#pragma once
// Linear radiance to display codes: exposure, a tone curve, sRGB, rounded. A code lies at most 0.6 from the exact value (0.5 of
// it is the rounding) and is the same on every machine.

#include "server/encode/encoder.h"
#include "server/kernel/kernel_types.h"

#include <array>
#include <memory>

namespace heliograph {

/// Order as in the setting `toneCurve`.
enum class ToneCurve : uint32_t {
    automatic,  // what shownCurve makes of it
    neutral,  // Khronos PBR Neutral: Lalish, "Khronos PBR Neutral Tone Mapper" (2024). Below 0.8 the colour less the 0.04 that
              // a dielectric surface reflects of white surroundings, above it compressed, and paler the brighter
    filmic,   // K. Narkowicz, "ACES Filmic Tone Mapping Curve" (2016): x (2.51 x + 0.03) / (x (2.43 x + 0.59) + 0.14), clipped;
              // each channel by itself
    aces,     // S. Hill's fit of ACES' RRT and sRGB ODT (BakingLab, 2016), clipped: bright colours turn paler, as on film
    linear,   // clips at 1
};

/// The curve for pictures of a scene. automatic: neutral for a model from a file, whose base colours its author chose to be
/// seen; filmic for the scenes that come along, which were lit under it.
ToneCurve shownCurve(ToneCurve asked, bool fromFile);

/// sRGB coding of a linear value in [0, 1] (IEC 61966-2-1), in [0, 1].
double srgbCode(double linear);
/// What the curve makes of exposed radiance (not negative), linear, in [0, 1]. `curve`: any but automatic.
glm::dvec3 toneCurveColor(ToneCurve curve, glm::dvec3 radiance);

/// Immutable; may be used by several threads at once.
class ToneMap {
public:
    /// `exposure` in stops: radiance is multiplied by 2^exposure. `curve`: any but automatic.
    ToneMap(float exposure, ToneCurve curve);
    /// Codes `count` pixels (rgb used, w ignored) as RGBA8 with alpha 255. Values that are negative or no number become 0.
    void apply(const vec4* pixels, size_t count, uint8_t* rgba) const;
    /// The whole picture.
    void apply(const std::vector<vec4>& pixels, uvec2 resolution, DisplayImage& image) const;

    struct Table;

private:
    float scale_;
    ToneCurve curve_;
    std::shared_ptr<const Table> table_;
};

}  // namespace heliograph
