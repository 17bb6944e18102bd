#include "server/app/offered_scenes.h"

#include "server/base/error.h"
#include "server/base/log.h"

#include <algorithm>
#include <cctype>
#include <filesystem>

namespace heliograph {

namespace {

namespace fs = std::filesystem;

constexpr int DEEPEST = 4;  // folders within each other

bool isSceneFile(const fs::path& path) {
    std::string ending = path.extension().string();
    for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return ending == ".gltf" || ending == ".glb" || ending == ".obj";
}

UploadLimits limitsOf(const ServeOptions& options) {
    if (options.uploadMib > options.uploadQuotaMib)
        throw InputError("--upload-size", std::to_string(options.uploadMib) + " MiB",
                         "at most --upload-quota, " + std::to_string(options.uploadQuotaMib) + " MiB");
    UploadLimits limits{options.uploadMib << 20, options.uploadQuotaMib << 20, options.uploadFiles, options.uploadSeconds};
    limits.perAddress = options.uploadsPerAddress;
    limits.rate = options.uploadRateKib << 10;
    return limits;
}

/// Where the surroundings begin in SCENE+upload/ID/FILE.
size_t surroundingsOf(const std::string& name) {
    const size_t plus = name.rfind("+upload/");
    return plus != std::string::npos && isUploadName(std::string_view(name).substr(plus + 1)) ? plus : std::string::npos;
}

}  // namespace

std::map<std::string, std::string> sceneFilesIn(const std::string& folder) {
    std::map<std::string, std::string> files;
    std::error_code error;
    if (!fs::is_directory(folder, error)) throw InputError("--scenes", folder, "a folder that is there");
    auto at = fs::recursive_directory_iterator(folder, fs::directory_options::skip_permission_denied, error);
    for (; !error && at != fs::recursive_directory_iterator(); at.increment(error)) {
        const bool hidden = at->path().filename().string().starts_with(".");
        if (hidden || at->is_symlink() || at.depth() >= DEEPEST) at.disable_recursion_pending();
        if (hidden || at->is_symlink()) continue;
        if (!at->is_regular_file(error) || !isSceneFile(at->path())) continue;
        if (files.size() == MOST_SCENE_FILES) {
            log().warn("--scenes {}: only {} files are offered", folder, MOST_SCENE_FILES);
            break;
        }
        files[fs::relative(at->path(), folder).string()] = at->path().string();
    }
    if (error) throw InputError("--scenes", folder + ": " + error.message(), "a folder that can be read");
    return files;
}

OfferedScenes::OfferedScenes(const ServeOptions& options) : environment_(options.environment), list_(sceneRecipes()) {
    const auto recipe = std::ranges::find(list_, options.scene, &SceneRecipe::name);
    if (recipe != list_.end()) {
        std::rotate(list_.begin(), recipe, recipe + 1);
    } else {
        const SceneName first = sceneNameOf(options.scene, [](const std::string& name) {
            std::error_code error;
            return fs::exists(name, error);
        });
        const std::string name = fs::path(first.name).filename().string();
        files_[name] = first.name;
        list_.insert(list_.begin(), {name, "The file given at the start of the server"});
        if (!first.variant.empty()) list_.insert(list_.begin(), {name + "#" + first.variant, "Its look of that name"});
    }
    const std::map<std::string, std::string> more =
        options.scenes.empty() ? std::map<std::string, std::string>() : sceneFilesIn(options.scenes);
    for (const auto& [name, path] : more) {
        if (std::ranges::find(list_, name, &SceneRecipe::name) != list_.end()) continue;
        files_[name] = path;
        list_.push_back({name, "A file of the server's folder of scenes"});
    }
    if (!options.uploads.empty()) uploads_ = std::make_shared<UploadStore>(options.uploads, limitsOf(options));
}

bool OfferedScenes::opensToo(const std::string& name) const {
    if (!uploads_) return false;
    if (isUploadName(name) && surroundingsOf(name) == std::string::npos) return true;
    const size_t plus = surroundingsOf(name);
    if (plus == std::string::npos) return false;
    const std::string scene = name.substr(0, plus);
    return isUploadName(scene) || std::ranges::find(list_, scene, &SceneRecipe::name) != list_.end();
}

std::shared_ptr<const Scene> OfferedScenes::open(const std::string& name, const Progress& progress) const {
    const size_t plus = uploads_ ? surroundingsOf(name) : std::string::npos;
    if (plus == std::string::npos) return openWith(name, environment_, progress);
    const std::string image = name.substr(plus + 1);
    const std::optional<fs::path> file = uploads_->fileOf(image);
    if (!file || !isSurroundings(file->string())) throw InputError("scene.name", "no surroundings", "an HDR or EXR image");
    return openWith(name.substr(0, plus), file->string(), progress);
}

std::shared_ptr<const Scene> OfferedScenes::openWith(const std::string& name, const std::string& environment,
                                                     const Progress& progress) const {
    const auto isFile = [&](const std::string& base) {
        return files_.contains(base) || (uploads_ && isUploadName(base) && base.find('#') == std::string::npos);
    };
    const auto [base, variant] = sceneNameOf(name, isFile);
    const std::string look = variant.empty() ? "" : "#" + variant;
    const std::optional<fs::path> upload = uploads_ ? uploads_->fileOf(base) : std::nullopt;
    const auto file = files_.find(base);
    if (!upload) return openScene((file == files_.end() ? base : file->second) + look, environment, progress, true);
    try {
        return openScene(upload->string() + look, environment, progress, true);
    } catch (const InputError& error) {
        if (variant.empty()) uploads_->forget(name);  // else the look may be what is not there
        // Paths of the server's disk are nobody's business.
        std::string what = error.what();
        const std::string folder = upload->parent_path().string() + "/";
        for (size_t at; (at = what.find(folder)) != std::string::npos;) what.erase(at, folder.size());
        throw InputError("upload", what);
    }
}

}  // namespace heliograph
