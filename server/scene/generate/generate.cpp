#include "server/scene/generate/generate.h"

#include "server/base/error.h"
#include "server/scene/generate/scenes.h"

namespace heliograph {

namespace {

struct Entry {
    SceneRecipe recipe;
    void (*fill)(SceneBuilder& builder);
};

const std::vector<Entry>& entries() {
    static const std::vector<Entry> table = {
        {{"courtyard", "Two floors of arcades around a sunlit court with a fountain; textured stone, brick and tiles"},
         fillCourtyard},
        {{"cathedral", "A Gothic nave with ribbed vaults; sunlight through stained glass on a polished floor"},
         fillCathedral},
        {{"glass", "Drinking glasses, a teapot and a mirror torus knot on a tiled floor under an evening sky"},
         fillGlass},
        {{"cornell", "The classic box: red and green walls, two blocks, a glass ball and a mirror ball"}, fillCornell},
        {{"effects/soft-shadows", "A stage with columns under a shining ball and a shining panel"}, fillSoftShadows},
        {{"effects/hard-shadows", "The same stage under two point lights"}, fillHardShadows},
        {{"effects/depth-of-field", "Balls in a row towards small lamps, for a lens to blur"}, fillDepthOfField},
        {{"effects/fog", "A light behind a row of columns, for fog to show its shafts"}, fillFog},
        {{"effects/glossy", "Metal plates from smooth to rough that reflect glowing bars"}, fillGlossy},
        {{"effects/motion-blur", "Posts and balls for a camera to fly past"}, fillMotionBlur},
        {{"effects/indirect-light", "A room that is lit by its coloured walls"}, fillIndirectLight},
        {{"effects/small-mirror", "A matt court with one mirror that covers a hundredth of the picture"}, fillSmallMirror},
        {{"effects/no-mirror", "The same court with a matt plate for the mirror"}, fillNoMirror},
    };
    return table;
}

}  // namespace

const std::vector<SceneRecipe>& generatedRecipes() {
    static const std::vector<SceneRecipe> recipes = [] {
        std::vector<SceneRecipe> list;
        for (const Entry& entry : entries()) list.push_back(entry.recipe);
        return list;
    }();
    return recipes;
}

void generateScene(const std::string& name, SceneBuilder& builder) {
    std::string known;
    for (const Entry& entry : entries()) {
        if (entry.recipe.name == name) return entry.fill(builder);
        known += (known.empty() ? "" : ", ") + entry.recipe.name;
    }
    throw InputError("scene", "no scene is called '" + name + "'", known);
}

}  // namespace heliograph
