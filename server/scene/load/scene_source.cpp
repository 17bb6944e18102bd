#include "server/scene/load/scene_source.h"

#include "server/base/error.h"
#include "server/scene/generate/generate.h"
#include "server/scene/load/gltf_loader.h"
#include "server/scene/load/image_loader.h"
#include "server/scene/load/obj_loader.h"
#include "server/scene/build/scene_builder.h"

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <new>
#include <stdexcept>

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

void checkNoVariant(const std::string& variant) {
    if (!variant.empty()) throw InputError("variant", "'" + variant.substr(0, 80) + "'", "none: only glTF files have variants");
}

bool isRecipe(const std::string& name) {
    const std::vector<SceneRecipe>& recipes = sceneRecipes();
    return std::any_of(recipes.begin(), recipes.end(), [&](const SceneRecipe& recipe) { return recipe.name == name; });
}

bool isSceneOrFile(const std::string& name) {
    std::error_code error;
    return isRecipe(name) || (name.find('\0') == std::string::npos && fs::exists(name, error));
}

void fill(const std::string& text, SceneBuilder& builder, const Progress& progress) {
    const auto [name, variant] = sceneNameOf(text, isSceneOrFile);
    if (isRecipe(name)) {
        checkNoVariant(variant);
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
    builder.setFromFile();
    if (extension == ".gltf" || extension == ".glb") {
        loadGltf(path, builder, progress, variant);
    } else if (extension == ".obj") {
        checkNoVariant(variant);
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

SceneName sceneNameOf(const std::string& text, const std::function<bool(const std::string&)>& isName) {
    if (isName(text)) return {text, {}};
    for (size_t at = text.find('#'); at != std::string::npos; at = text.find('#', at + 1)) {
        if (isName(text.substr(0, at))) return {text.substr(0, at), text.substr(at + 1)};
    }
    return {text, {}};
}

const std::vector<SceneRecipe>& sceneRecipes() { return generatedRecipes(); }

std::shared_ptr<const Scene> openScene(const std::string& nameOrPath, const std::string& environment, const Progress& progress,
                                       bool offers) {
    // Faults of the file that no check foresaw end here as errors of the file, too; what progress throws passes
    // through.
    std::atomic<bool> abandoned{false};  // progress may be called from worker threads
    const Progress watched = [&](const std::string& what, double share) {
        try {
            report(progress, what, share);
        } catch (...) {
            abandoned = true;
            throw;
        }
    };
    try {
        SceneBuilder builder(nameOrPath);
        builder.offerSurroundings(offers);
        fill(nameOrPath, builder, watched);
        surround(environment, builder, watched);
        return builder.finish(watched);
    } catch (const InputError&) {
        throw;
    } catch (const std::bad_alloc&) {
        throw InputError(nameOrPath, "the scene does not fit into memory", "a smaller scene");
    } catch (const std::length_error&) {
        throw InputError(nameOrPath, "the scene does not fit into memory", "a smaller scene");
    } catch (const std::exception& error) {
        if (abandoned) throw;
        const std::string what = error.what();
        throw InputError(nameOrPath, "the scene cannot be read: " + what.substr(0, std::min(what.find('\n'), size_t(200))));
    }
}

}  // namespace heliograph
