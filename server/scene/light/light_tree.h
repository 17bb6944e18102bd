#pragma once
// A tree of a scene's lights, by which the kernel chooses some of many (shaders/kernel/effects/many_lights.glsl). Private to
// server/scene.

#include "server/scene/light/light_bounds.h"
#include "server/scene/scene.h"

#include <vector>

namespace heliograph {

/// What stands in a tree: a light, or a glowing triangle.
struct TreeLight {
    LightBounds bounds;
    uint32_t index = 0;
};

/// Where the words of light 0 begin, and how many a light has.
struct LightWords {
    uint32_t first = 0;
    uint32_t count = 0;
};

struct LightTree {
    uint32_t root = 0;             // its first word
    uint32_t levels = 0;           // choices from there to a light at most
    std::vector<uint32_t> trails;  // by index: the parts on the way to a light, LAMP_TRAIL_BITS a level, where all fit
};

/// Writes the tree of `lights` (at least one; reordered) behind the texels. A node has LIGHT_TREE_WIDTH parts of LIGHT_TREE_WORDS
/// words:
///   centre and radius of a ball about its lights;
///   axis of a cone about their directions and the cosine of its half angle (-1: all directions);
///   root of the sum of their radiant intensities over that of all, cosine of the angle beyond the cone up to which they
///   shine (-2: everywhere), the distance from which on all are dark, and where it leads (LIGHT_TREE_LEAF: to a light).
/// Parts without lights have strength 0. `mostLevels`: at least the logarithm of their number to base LIGHT_TREE_WIDTH.
LightTree writeLightTree(std::vector<uint32_t>& texels, std::vector<TreeLight>& lights, LightWords words, uint32_t mostLevels);

/// Where more than MOST_LISTED_LIGHTS lights have a place (points, spots and quads that shine), puts them behind all others in
/// Scene::lights, dark ones last, and writes the tree behind the scene's texels: first the lights, then the nodes. Else nothing
/// changes. Sets Environment::lightTree, lightTreeLevels and listedLights.
void appendLightTree(Scene& scene);

}  // namespace heliograph
