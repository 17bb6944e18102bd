#pragma once
// KHR_draco_mesh_compression: the geometry of primitives, out of what Draco compressed. Private to server/scene.

#include "server/scene/load/gltf_document.h"

#include <nlohmann/json.hpp>

namespace heliograph {

/// Takes the indices away from compressed primitives whose accessor has no bytes: tinygltf refuses those, and what is decoded
/// brings its own.
void dropCompressedIndices(nlohmann::json& root);

/// Decodes, on all cores, every primitive that has no plain copy of its geometry; it then refers to accessors of its own, over
/// buffers that are added. Throws InputError for data that cannot be decoded, or of which there is more than 250,000 triangles
/// and 4 for each byte of the file.
void decodeDracoGeometry(GltfDocument& document);

}  // namespace heliograph
