#pragma once
// Analytic shapes as a scene's instances hold them (shaders/kernel/effects/shapes.glsl), for those who are not the kernel.

#include "server/scene/scene.h"

namespace heliograph {

inline bool isShape(const Instance& instance) { return (instance.flags & INSTANCE_SHAPE) != 0; }
inline uint32_t shapeKindOf(const Instance& instance) { return instance.flags / SHAPE_KIND & 3u; }
inline uint32_t shapeOpacityOf(const Instance& instance) { return instance.flags / SHAPE_OPACITY & 3u; }

/// "sphere", "cylinder", "disc" or "plane".
const char* shapeName(uint32_t kind);
/// A box in the world, wider by more than what rounds a ray's way into the shape.
Bounds shapeBounds(const Instance& shape);
/// Unit normal, outwards (of a disc or plane: upwards in its own space), at a point of the surface.
glm::dvec3 shapeNormal(const Instance& shape, glm::dvec3 point);
/// Whether a closed shape has the point inside; false for those that are not closed.
bool holdsPoint(const Instance& shape, glm::dvec3 point);

}  // namespace heliograph
