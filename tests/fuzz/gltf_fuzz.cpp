// glTF as text.

#include "server/scene/load/scene_source.h"
#include "tests/fuzz/fuzz.h"

using namespace heliograph;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    const std::filesystem::path file = fuzz::asFile({data, size}, "scene.gltf");
    return fuzz::refusing([&] { openScene(file.string()); });
}
