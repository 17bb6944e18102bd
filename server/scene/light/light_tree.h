#pragma once
// A tree of a scene's lights, by which the kernel chooses some of many (shaders/kernel/effects/many_lights.glsl). Private to
// server/scene.

#include "server/scene/scene.h"

namespace heliograph {

/// Where more than MOST_LISTED_LIGHTS lights have a place (points, spots and quads that shine), puts them behind all others in
/// Scene::lights, dark ones last, and writes the tree behind the scene's texels: first the lights, then the nodes. Else nothing
/// changes. A node has LIGHT_TREE_WIDTH parts of LIGHT_TREE_WORDS words:
///   centre and radius of a ball about its lights;
///   axis of a cone about their directions and the cosine of its half angle (-1: all directions);
///   root of the sum of their radiant intensities over that of the scene, cosine of the angle beyond the cone up to which they
///   shine (-2: everywhere), the distance from which on all are dark, and where it leads (LIGHT_TREE_LEAF: to a light).
/// Parts without lights have strength 0. Sets Environment::lightTree, lightTreeLevels and listedLights.
void appendLightTree(Scene& scene);

}  // namespace heliograph
