#pragma once
// What a viewer says of the files that it uploads, before their bytes come. Pure.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace heliograph {

struct UploadLimits {
    uint64_t bytes = 256ull << 20;   // of one upload
    uint64_t quota = 1024ull << 20;  // bytes of all that lie there
    size_t files = 1000;             // of one upload
    uint64_t seconds = 600;          // that one may take
    size_t perAddress = 2;           // of MOST_AT_ONCE; at one time
    uint64_t rate = 8 << 10;         // bytes a second that have to come, over each `window`
    double window = 20.0;            // seconds
};

constexpr size_t MANIFEST_BYTES = 512 * 1024;
constexpr size_t UPLOAD_PATH_BYTES = 200;
constexpr size_t UPLOAD_DEPTH = 8;  // folders within each other

struct UploadManifest {
    struct File {
        std::string path;  // '/' separates; within the upload
        uint64_t bytes = 0;
    };
    std::vector<File> files;
    std::string scene;  // the path to be opened: .gltf, .glb or .obj, or an image of surroundings
    uint64_t bytes() const;
};

/// {"scene": "a/b.gltf", "files": [{"path": "a/b.gltf", "bytes": 12}, ...]}. Throws InputError that names the file: a path that
/// is absolute, has "..", ".", empty or hidden parts, control characters, backslashes or colons, or is too long or deep; a path
/// that comes twice, also where letters differ in size alone, or is another one's folder; a kind of file that scenes are not
/// made of; too many files or bytes; a scene that is not among them or cannot be opened.
UploadManifest parseManifest(std::string_view text, const UploadLimits& limits);

/// An image that stands for surroundings: .hdr or .exr.
bool isSurroundings(std::string_view path);

}  // namespace heliograph
