// Wavefront OBJ; the bytes after the first NUL, if any, are its material file m.mtl.

#include "server/scene/load/scene_source.h"
#include "tests/fuzz/fuzz.h"

#include <algorithm>

using namespace heliograph;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    const uint8_t* end = std::find(data, data + size, uint8_t(0));
    if (end != data + size) fuzz::asFile({end + 1, data + size}, "m.mtl");
    else std::filesystem::remove(fuzz::scratch() / "m.mtl");
    const std::filesystem::path file = fuzz::asFile({data, end}, "scene.obj");
    return fuzz::refusing([&] { openScene(file.string()); });
}
