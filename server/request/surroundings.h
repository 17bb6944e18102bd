#pragma once
// What stands around a scene in a picture, and how the picture's brightness is chosen. Pure functions.

#include "server/request/effects.h"
#include "server/scene/scene.h"

#include <optional>

namespace heliograph {

/// The surroundings that the settings choose, turned and scaled, with what is seen of them behind the scene. Throws InputError
/// where the scene was opened without those.
Environment environmentFor(const Scene& scene, const Settings& settings);

/// The effects of a picture: `called` for by the scene (effectsOf), as far as the settings allow them and choose surroundings
/// that need them.
EffectSet effectsUnder(const Scene& scene, EffectSet called, const Settings& settings);

/// The sun as the settings place it: a directional light with an extent. Its azimuth 0 is +Z, 90 degrees is +X.
Light sunOf(const Settings& settings);

/// Radiance of what a camera sees behind the scene, the mean of an image.
vec3 backdropOf(const Scene& scene, const Settings& settings);
/// The same; nothing where it is not one colour.
std::optional<vec3> plainBackdrop(const Scene& scene, const Settings& settings, EffectSet effects);

/// Whether the brightness of a view's pictures is chosen by the picture: where the setting says so, and by itself for a file
/// whose own lights may have any unit.
bool exposesViews(const Settings& settings, const Scene& scene);
/// The same for commands: only where the setting says so.
bool exposesPictures(const Settings& settings);

}  // namespace heliograph
