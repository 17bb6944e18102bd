#include "server/scene/scene_source.h"

#include "server/base/error.h"
#include "server/scene/generate/generate.h"
#include "server/scene/gltf_loader.h"
#include "server/scene/image_loader.h"
#include "server/scene/obj_loader.h"
#include "server/scene/scene_builder.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>
#include <new>

namespace heliograph {

namespace {

namespace fs = std::filesystem;

std::string recipeNames() {
    std::string names;
    for (const SceneRecipe& recipe : sceneRecipes()) names += recipe.name + ", ";
    return names + "or a .gltf, .glb or .obj file";
}

std::string lowerExtension(const fs::path& path) {
    std::string extension = path.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(), [](unsigned char c) { return std::tolower(c); });
    return extension;
}

bool isRecipe(const std::string& name) {
    const std::vector<SceneRecipe>& recipes = sceneRecipes();
    return std::any_of(recipes.begin(), recipes.end(), [&](const SceneRecipe& recipe) { return recipe.name == name; });
}

void fill(const std::string& name, SceneBuilder& builder, const Progress& progress) {
    if (isRecipe(name)) {
        report(progress, "generating", 0.0);
        generateScene(name, builder);
        return;
    }
    const std::string shown = name.empty() ? "scene" : name.substr(0, 400);
    if (name.find('\0') != std::string::npos) throw InputError("scene", "a name with a NUL character", recipeNames());
    std::error_code error;
    const fs::path path(name);
    if (!fs::exists(path, error)) throw InputError(shown, "no such scene or file", recipeNames());
    const std::string extension = lowerExtension(path);
    if (extension == ".gltf" || extension == ".glb") {
        loadGltf(path, builder, progress);
    } else if (extension == ".obj") {
        loadObj(path, builder, progress);
    } else {
        throw InputError(shown, "unknown kind of file '" + extension + "'", recipeNames());
    }
}

void surround(const std::string& environment, SceneBuilder& builder, const Progress& progress) {
    if (environment.empty()) return;
    report(progress, "environment", 0.0);
    builder.setEnvironmentImage(builder.addImage(loadImage(environment, true)));
}

}  // namespace

const std::vector<SceneRecipe>& sceneRecipes() { return generatedRecipes(); }

std::shared_ptr<const Scene> openScene(const std::string& nameOrPath, const std::string& environment, const Progress& progress) {
    // Faults of the file that no check foresaw end here as errors of the file, too; what progress throws passes through.
    try {
        SceneBuilder builder(nameOrPath);
        fill(nameOrPath, builder, progress);
        surround(environment, builder, progress);
        return builder.finish(progress);
    } catch (const std::bad_alloc&) {
        throw InputError(nameOrPath, "the scene does not fit into memory", "a smaller scene");
    } catch (const std::length_error&) {
        throw InputError(nameOrPath, "the scene does not fit into memory", "a smaller scene");
    } catch (const nlohmann::json::exception& error) {
        throw InputError(nameOrPath, std::string("the file cannot be read: ") + error.what());
    } catch (const std::out_of_range& error) {
        throw InputError(nameOrPath, std::string("the file cannot be read: ") + error.what());
    } catch (const fs::filesystem_error& error) {
        throw InputError(nameOrPath, error.code().message());
    }
}

}  // namespace heliograph
