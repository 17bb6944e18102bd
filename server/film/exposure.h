#pragma once
// Automatic exposure: how bright a picture is, and what brings it to mid grey.

#include "server/film/film.h"

#include <optional>

namespace heliograph {

inline constexpr float MID_GREY = 0.18f;
/// Limits of an automatic exposure, EV: a night sky, and the sun on snow in candela per square metre.
inline constexpr float LEAST_EXPOSURE = -20.0f, MOST_EXPOSURE = 12.0f;

/// Exposure in EV that brings the film's log-average luminance to MID_GREY, within the limits: Reinhard et al., "Photographic
/// Tone Reproduction for Digital Images" (2002), section 3. Of the middle eight tenths of the pixels, so that neither a lamp
/// nor a shadow decides. `backdrop`: plain radiance behind everything, which does not count; black never does. Nothing where
/// no pixel is left. Reads at most 65,536 pixels, whole rows.
std::optional<float> meteredExposure(const Film& film, const std::optional<vec3>& backdrop = {});

}  // namespace heliograph
