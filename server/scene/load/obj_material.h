#pragma once
// MTL materials as the kernel's. Private to server/scene.

#include "server/scene/load/image_loader.h"
#include "server/scene/build/scene_builder.h"

#include <tiny_obj_loader.h>

#include <map>

namespace heliograph {

class FileFolder;

/// Adds MTL materials and the images that they name. An image that is missing or broken is a warning; one that leads
/// out of the folder an InputError.
class ObjMaterials {
public:
    ObjMaterials(const FileFolder& folder, std::string file, SceneBuilder& builder)
        : folder_(folder), file_(std::move(file)), builder_(builder) {}

    /// Returns the builder's index.
    uint32_t add(const tinyobj::material_t& from);

private:
    uint32_t texture(const std::string& name, const tinyobj::texture_option_t& options, bool srgb);
    uint32_t image(const std::string& name, bool srgb);
    void setTransparency(const tinyobj::material_t& from, Material& to);
    void setTextures(const tinyobj::material_t& from, Material& to);

    const FileFolder& folder_;
    std::string file_;
    SceneBuilder& builder_;
    std::map<std::pair<std::string, bool>, uint32_t> images_;  // NO_INDEX: not readable
    ImageBudget budget_;
};

}  // namespace heliograph
