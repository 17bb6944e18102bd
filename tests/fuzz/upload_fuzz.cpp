// What a viewer says of the files that it uploads. What is accepted must lie within the upload, whatever a file system makes
// of it.

#include "server/uploads/manifest.h"
#include "tests/fuzz/fuzz.h"

#include <cstdio>
#include <cstdlib>

using namespace heliograph;

namespace {

void insist(bool holds, const char* what) {
    if (holds) return;
    std::fprintf(stderr, "an accepted upload: %s\n", what);
    std::abort();
}

bool staysWithin(const std::string& text) {
    const std::filesystem::path path(text);
    if (text.empty() || path.is_absolute() || text.find('\0') != std::string::npos) return false;
    const std::filesystem::path base = "/upload";
    const std::filesystem::path lands = (base / path).lexically_normal();
    return lands == base / path && std::mismatch(base.begin(), base.end(), lands.begin()).first == base.end() && lands != base;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    return fuzz::refusing([&] {
        UploadLimits limits;
        limits.bytes = 4096;
        limits.files = 20;
        const UploadManifest manifest = parseManifest({reinterpret_cast<const char*>(data), size}, limits);
        insist(!manifest.files.empty() && manifest.files.size() <= limits.files, "the number of files");
        insist(manifest.bytes() <= limits.bytes, "their bytes");
        bool named = false;
        for (const UploadManifest::File& file : manifest.files) {
            insist(staysWithin(file.path) && file.path.size() <= UPLOAD_PATH_BYTES, "a path that leaves it");
            named = named || file.path == manifest.scene;
        }
        insist(named, "a scene that is none of its files");
    });
}
