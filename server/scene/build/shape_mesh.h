#pragma once
// Analytic shapes between the builder and the kernel's instances: what stands for them where triangles are wanted (the raster
// preview, boxes, the default camera), and the space in which they are met. Private to server/scene.

#include "server/scene/build/scene_draft.h"
#include "server/scene/build/transform.h"

namespace heliograph {

/// A shape of size one (effects/shapes.glsl) in triangles; at least two.
MeshData shapeMesh(ShapeForm form, uint32_t material);

/// A shape as the draft has it; the box is of its triangles, in the world.
struct PlacedShape {
    const PlacedMesh* source = nullptr;
    Placement placement;
    Bounds bounds;
};

/// Grows the scene's bounds and farthestSurface. A scene is as large as what can be seen as a whole: no plane, and no ball that is ground
/// to the rest, makes it larger.
void growByShapes(Scene& scene, std::span<const PlacedShape> shapes, std::span<const PlacedShape> planes);

/// What an instance of a shape holds.
struct ShapeSpace {
    Placement placement;
    uint32_t flags = INSTANCE_SHAPE;  // and SHAPE_*, without the opacity
    vec3 extra{0.0f};                 // fourth column of toObject

    vec3 anchor() const { return vec3(0.0f, (flags & SHAPE_POLE) != 0 ? 1.0f : 0.0f, 0.0f); }  // from the middle
};

/// `placement` takes the shape of size one to the world and has an inverse. `reach`: half side of a plane, metres.
ShapeSpace shapeSpaceOf(ShapeForm form, const Placement& placement, double reach);

}  // namespace heliograph
