#pragma once
// EXT_meshopt_compression: buffer views, out of what meshoptimizer compressed. Private to server/scene.

#include "server/scene/load/gltf_document.h"

#include <nlohmann/json.hpp>

namespace heliograph {

/// Whether a buffer, as JSON, only stands for the size of what is compressed elsewhere: it has no data.
bool isFallbackBuffer(const nlohmann::json& buffer);
/// Whether a buffer view, as JSON, is compressed.
bool isMeshoptView(const nlohmann::json& view);

/// What the extension says of one buffer view, checked: counts, strides, modes and filters that libmeshoptimizer takes, bytes
/// inside their buffer, no more elements than these bytes can hold.
struct MeshoptView {
    enum class Mode { attributes, triangles, indices };
    enum class Filter { none, octahedral, quaternion, exponential };

    size_t view = 0;
    std::string where;  // for messages
    ByteSpan bytes;     // compressed
    size_t count = 0;
    size_t stride = 0;  // bytes of an element
    Mode mode = Mode::attributes;
    Filter filter = Filter::none;
};

/// The compressed views of a document whose buffers are read. Throws InputError; also if all views together are more than
/// 16 MiB and 64 bytes for each byte of the file, or 4 GiB.
std::vector<MeshoptView> meshoptViewsOf(const nlohmann::json& root, const GltfDocument& document);

/// Decodes the views on all cores; the model's views then lie in buffers that are added. Throws InputError.
void decodeMeshoptViews(std::span<const MeshoptView> views, GltfDocument& document);

}  // namespace heliograph
