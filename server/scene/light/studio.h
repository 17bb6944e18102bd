#pragma once
// Surroundings of our own as lat-long images, linear radiance: what a model from a file is seen in. Private to server/scene.

#include "server/scene/build/scene_builder.h"

namespace heliograph {

/// A photographer's studio: white walls, a darker floor, and soft boxes above, at both sides and behind. Neutral in colour.
/// Scaled so that a white surface that faces the default camera sends back 1.04: base colours come out as they are.
ImageData paintStudio();

/// A clear day: blue above, pale at the horizon, a hazy sun high on the right, ground as bright as dry grass.
ImageData paintClearDay();

}  // namespace heliograph
