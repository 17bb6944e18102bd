#pragma once
// The arrays of a scene that devices read, and whether what they say of each other is so. Private to server/pool.

#include "server/scene/scene.h"

namespace heliograph {

#ifdef __GLIBCXX__
static_assert(sizeof(Scene) == 1640,
              "Scene has changed: if pictures depend on a new member, scene_parts.cpp has to carry it to the nodes");
#endif

/// Calls `visit` with each array, in the order in which they are sent.
template <typename AnyScene, typename Visit>
void forSceneArrays(AnyScene& scene, Visit visit) {
    visit(scene.positions);
    visit(scene.attributes);
    visit(scene.tangents);
    visit(scene.triangles);
    visit(scene.meshes);
    visit(scene.instances);
    visit(scene.materials);
    visit(scene.textures);
    visit(scene.images);
    visit(scene.imageLevels);
    visit(scene.texels);
    visit(scene.lights);
    visit(scene.offered);
}

/// Throws PoolMessageError where an index points out of the array that it is of.
void checkSceneArrays(const Scene& scene);

}  // namespace heliograph
