// Before the first input of a target that opens scenes: what is made once for all of them is no input's time.

#include "server/scene/load/scene_source.h"
#include "tests/fuzz/fuzz.h"

#include <string_view>

using namespace heliograph;

extern "C" int LLVMFuzzerInitialize(int*, char***) {
    constexpr std::string_view triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    const std::filesystem::path file =
        fuzz::asFile({reinterpret_cast<const uint8_t*>(triangle.data()), triangle.size()}, "first.obj");
    openScene(file.string());
    return 0;
}
