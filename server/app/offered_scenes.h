#pragma once
// Which scenes a server opens by which name: those that it makes, the operator's files, and what viewers bring.

#include "server/operations/serve_options.h"
#include "server/scene/load/scene_source.h"
#include "server/uploads/upload_store.h"

#include <map>

namespace heliograph {

class OfferedScenes {
public:
    /// Throws InputError for a folder that cannot be read. The scene of the options comes first.
    explicit OfferedScenes(const ServeOptions& options);

    const std::vector<SceneRecipe>& list() const { return list_; }
    const std::shared_ptr<UploadStore>& uploads() const { return uploads_; }
    /// A name that an upload may have: upload/ID/FILE, or SCENE+upload/ID/FILE for the surroundings of a scene.
    bool opensToo(const std::string& name) const;
    /// Throws InputError. An upload that turns out to be no scene goes.
    std::shared_ptr<const Scene> open(const std::string& name, const Progress& progress) const;

private:
    std::shared_ptr<const Scene> openWith(const std::string& name, const std::string& environment,
                                          const Progress& progress) const;

    const std::string environment_;
    std::vector<SceneRecipe> list_;
    std::map<std::string, std::string> files_;  // by name
    std::shared_ptr<UploadStore> uploads_;
};

/// The .gltf, .glb and .obj files of a folder and of its folders, at most MOST_SCENE_FILES, by their path within it, sorted;
/// hidden ones and links are left out. Throws InputError.
std::map<std::string, std::string> sceneFilesIn(const std::string& folder);

constexpr size_t MOST_SCENE_FILES = 500;

}  // namespace heliograph
