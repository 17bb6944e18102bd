#pragma once
// MTL materials as the kernel's. Private to server/scene.

#include "server/scene/load/image_loader.h"
#include "server/scene/build/scene_builder.h"
#include "server/scene/load/mtl_file.h"

#include <filesystem>
#include <map>

namespace heliograph {

class FileFolder;

/// A path that a file of `folder` (as its own file names it, may be empty) gives, as the scene's folder names it: with slashes, and
/// without steps that lead back.
std::string pathFrom(const std::string& folder, const std::string& reference);

/// Adds MTL materials and the images that they name. An image that is missing, broken or outside the OBJ file's folder is a
/// warning.
class ObjMaterials {
public:
    ObjMaterials(const FileFolder& folder, std::string file, SceneBuilder& builder)
        : folder_(folder), file_(std::move(file)), builder_(builder) {}

    /// Returns the builder's index.
    uint32_t add(const MtlMaterial& from);

private:
    uint32_t texture(const MtlMaterial& from, const std::string& key, bool srgb);
    uint32_t image(const std::string& folder, const std::string& name, bool srgb);
    std::filesystem::path find(const std::string& folder, const std::string& name) const;
    void setTransparency(const MtlMaterial& from, Material& to);
    void setTextures(const MtlMaterial& from, Material& to);

    const FileFolder& folder_;
    std::string file_;
    SceneBuilder& builder_;
    std::map<std::pair<std::string, bool>, uint32_t> images_;  // by folder and name; NO_INDEX: not readable
    ImageBudget budget_;
};

}  // namespace heliograph
