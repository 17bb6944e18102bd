#pragma once
// A glTF file read and checked: the parsed model, the bytes of its buffers and where its images are. Private to
// server/scene.

#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_INCLUDE_STB_IMAGE
#define TINYGLTF_NO_INCLUDE_STB_IMAGE_WRITE
#include <tiny_gltf.h>

#include <filesystem>
#include <set>
#include <span>
#include <string>
#include <vector>

namespace heliograph {

using ByteSpan = std::span<const uint8_t>;

/// An image's file bytes; `fault` says why there are none.
struct GltfImage {
    std::string name;  // for messages: file and JSON pointer
    ByteSpan bytes;
    std::string fault;
};

/// Every index in `model` is in range, every buffer view lies inside its buffer, every accessor inside its view, and
/// the nodes form a forest. tinygltf's own buffers and images are empty: the bytes are in `buffers` and `images`.
struct GltfDocument {
    std::string file;
    tinygltf::Model model;
    std::vector<ByteSpan> buffers;
    std::vector<GltfImage> images;
    /// KHR_lights_punctual knows points alone: an extent is the light's `extras.radius`, metres; directional: the tangent of its
    /// angular radius. One per light, 0 where there is none.
    std::vector<float> lightRadii;
    std::vector<std::string> animations;  // names; tinygltf need not see the rest of them
    std::vector<std::string> warnings;
    uint64_t sourceBytes = 0;    // of the file and what it refers to, each once
    uint64_t decodedBytes = 0;   // of compressed geometry, bounded by sourceBytes
    std::set<int> inexactViews;  // decoded from lossy data: what an accessor says of their smallest and largest may differ

    /// Bytes of a buffer view.
    ByteSpan view(int bufferView) const;
    /// Makes `bytes` a buffer and a buffer view of the model; returns the view. They count as decodedBytes.
    int addDecoded(std::vector<uint8_t>&& bytes);
    /// "<file>: <JSON pointer>", for messages.
    std::string at(const std::string& pointer) const { return file + ": " + pointer; }

    std::vector<std::vector<uint8_t>> storage;  // what the spans point into
};

/// Reads .gltf or .glb, by content. Throws InputError.
GltfDocument readGltf(const std::filesystem::path& path);

}  // namespace heliograph
