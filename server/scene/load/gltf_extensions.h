#pragma once
// The extensions of glTF: which ones are read, on which objects they may stand, and why others are not. Private to server/scene.

#include "server/scene/scene.h"

#include <span>
#include <string>
#include <vector>

namespace heliograph {

/// A row of the table of extensions.
struct GltfExtension {
    const char* name;
    const char* on;    // the array of the document whose objects may carry it; "" where it may stand elsewhere
    bool read;         // false: left out, and a file that requires it is refused
    const char* note;  // what is made of it, or why it is not read
};

std::span<const GltfExtension> gltfExtensions();
/// The row of that name, or null.
const GltfExtension* gltfExtension(const std::string& name);
/// Why a file's extension is not read: the row's note, or that nobody here knows it.
std::string whyNotRead(const std::string& name);
/// For inspect: what becomes of each of these.
std::vector<FileExtension> fileExtensions(std::span<const std::string> used);

}  // namespace heliograph
