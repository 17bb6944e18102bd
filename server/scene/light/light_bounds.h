#pragma once
// What is known of several lights together: where they are, where to they shine, and how strong they are. Private to
// server/scene.

#include "server/scene/scene.h"

namespace heliograph {

using glm::dvec3;

/// All directions within `halfAngle` (radians, pi: all) of a unit axis.
struct DirectionCone {
    dvec3 axis{0.0, 1.0, 0.0};
    double halfAngle = 0.0;

    /// Grows to hold the other too. Conty Estevez & Kulla (2018), algorithm 1.
    void add(const DirectionCone& other);
};

struct LightBounds {
    dvec3 low{0.0};  // metres; of lights with an extent the whole of it
    dvec3 high{0.0};
    DirectionCone cone;      // of their axes; points have all directions
    double beyond = 0.0;     // radians away from the cone up to which they shine
    double intensity = 0.0;  // sum of luminances, as Light::intensity
    double reach = 0.0;      // metres from which on all are dark, infinite where one has no range

    dvec3 middle() const { return 0.5 * (low + high); }
    double radius() const { return 0.5 * glm::length(high - low); }
    void add(const LightBounds& other);
    /// What the light tree should have little of: intensity times the square of the radius times the directions' measure (the
    /// surface area orientation heuristic of Conty Estevez & Kulla, 2018, with balls for boxes: lights stand in planes and lines
    /// too).
    double cost() const;
};

/// Of a point, spot or quad; intensity 0 if it is dark. One with linear falloff counts as one that falls with the square and is
/// as strong at half its range, or at `sceneRadius` where it has none.
LightBounds boundsOf(const Light& light, double sceneRadius);

}  // namespace heliograph
