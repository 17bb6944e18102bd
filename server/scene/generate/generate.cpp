#include "server/scene/generate/generate.h"

#include "server/base/text.h"
#include "server/base/error.h"

namespace heliograph {

namespace {

struct Entry {
    const char* name;
    const char* description;
    void (*fill)(SceneBuilder& builder);
};

constexpr Entry ENTRIES[] = {
#define SCENE(name, fill, description) {name, description, fill},
#include "server/scene/generate/scene_table.inc"
};

}  // namespace

const std::vector<SceneRecipe>& generatedRecipes() {
    static const std::vector<SceneRecipe> recipes = [] {
        std::vector<SceneRecipe> list;
        for (const Entry& entry : ENTRIES) list.push_back({entry.name, entry.description});
        return list;
    }();
    return recipes;
}

void generateScene(const std::string& name, SceneBuilder& builder) {
    for (const Entry& entry : ENTRIES) {
        if (entry.name == name) return entry.fill(builder);
    }
    throw InputError("scene", "no scene is called '" + name + "'",
                     joined(ENTRIES, ", ", [](const Entry& entry) { return std::string(entry.name); }));
}

}  // namespace heliograph
