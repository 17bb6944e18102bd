#include "server/uploads/manifest.h"

#include "server/base/error.h"
#include "server/base/json_text.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cctype>
#include <set>
#include <span>

namespace heliograph {

namespace {

using nlohmann::json;

constexpr std::string_view SCENES[] = {".gltf", ".glb", ".obj"};
constexpr std::string_view SURROUNDINGS[] = {".hdr", ".exr"};
constexpr std::string_view PARTS[] = {".bin", ".mtl", ".png", ".jpg", ".jpeg", ".webp", ".tga", ".bmp"};
constexpr size_t DEEPEST_JSON = 8;

/// For messages: JSON's quotes hide what terminals would act on.
std::string shown(std::string_view text) {
    return json(std::string(text.substr(0, 80))).dump(-1, ' ', true, json::error_handler_t::replace);
}

std::string small(std::string_view text) {
    std::string result(text);
    for (char& c : result) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return result;
}

bool endsWithOneOf(std::string_view path, std::span<const std::string_view> endings) {
    const std::string name = small(path);
    return std::ranges::any_of(endings, [&](std::string_view ending) { return name.ends_with(ending); });
}

void checkPath(const std::string& path) {
    const auto refuse = [&](const char* allowed) { throw InputError("file name", shown(path), allowed); };
    if (path.empty() || path.size() > UPLOAD_PATH_BYTES) refuse("1 to 200 bytes");
    const bool odd =
        std::ranges::any_of(path, [](unsigned char c) { return c < 0x20 || c == 0x7f || c == '\\' || c == ':' || c == '#'; });
    if (odd) refuse("no control characters, backslashes, colons or #");
    size_t depth = 0;
    for (size_t begin = 0; begin <= path.size(); depth++) {
        const size_t end = std::min(path.find('/', begin), path.size());
        if (end == begin || path[begin] == '.') refuse("a path within the upload, without hidden, empty, . and .. parts");
        begin = end + 1;
    }
    if (depth > UPLOAD_DEPTH + 1) refuse("at most 8 folders within each other");
    if (!endsWithOneOf(path, SCENES) && !endsWithOneOf(path, SURROUNDINGS) && !endsWithOneOf(path, PARTS))
        refuse("glTF, GLB, OBJ, MTL, bin, PNG, JPEG, WebP, TGA, BMP, HDR or EXR files; archives are to be unpacked first");
}

/// No path twice, and none that is another one's folder; on disks that tell no large letters from small ones, too.
void checkApart(const UploadManifest& manifest) {
    std::set<std::string> paths;
    for (const UploadManifest::File& file : manifest.files) {
        if (!paths.insert(small(file.path)).second) throw InputError("file name", shown(file.path), "each once");
    }
    for (const std::string& path : paths) {
        for (size_t at = path.find('/'); at != std::string::npos; at = path.find('/', at + 1)) {
            if (paths.contains(path.substr(0, at)))
                throw InputError("file name", shown(path), "no file that is another one's folder");
        }
    }
}

json parsed(std::string_view text) {
    if (jsonExtent(text, DEEPEST_JSON).depth > DEEPEST_JSON) throw InputError("upload", "a list nested too deep", "8 levels");
    json list = json::parse(text, nullptr, false);
    const bool good = list.is_object() && list.contains("files") && list["files"].is_array() && list.contains("scene") &&
                      list["scene"].is_string();
    if (!good)
        throw InputError("upload", "no list of files", "{\"scene\": PATH, \"files\": [{\"path\": PATH, \"bytes\": N}, ...]}");
    return list;
}

UploadManifest::File fileOf(const json& entry) {
    const bool good = entry.is_object() && entry.contains("path") && entry["path"].is_string() && entry.contains("bytes") &&
                      entry["bytes"].is_number_unsigned();
    if (!good) throw InputError("upload.files", "an entry without path or bytes", "{\"path\": PATH, \"bytes\": N}");
    return {entry["path"].get<std::string>(), entry["bytes"].get<uint64_t>()};
}

}  // namespace

uint64_t UploadManifest::bytes() const {
    uint64_t sum = 0;
    for (const File& file : files) sum += file.bytes;
    return sum;
}

bool isSurroundings(std::string_view path) { return endsWithOneOf(path, SURROUNDINGS); }

UploadManifest parseManifest(std::string_view text, const UploadLimits& limits) {
    const json list = parsed(text);
    const json& files = list["files"];
    if (files.empty() || files.size() > limits.files)
        throw InputError("upload", std::to_string(files.size()) + " files", "1 to " + std::to_string(limits.files));
    UploadManifest manifest;
    manifest.scene = list["scene"].get<std::string>();
    uint64_t left = limits.bytes;
    for (const json& entry : files) {
        manifest.files.push_back(fileOf(entry));
        const UploadManifest::File& file = manifest.files.back();
        checkPath(file.path);
        if (file.bytes > left)
            throw InputError("upload", "more than " + std::to_string(limits.bytes >> 20) + " MiB", "at most that");
        left -= file.bytes;
    }
    checkApart(manifest);
    if (std::ranges::find(manifest.files, manifest.scene, &UploadManifest::File::path) == manifest.files.end())
        throw InputError("upload.scene", shown(manifest.scene), "one of the files");
    if (!endsWithOneOf(manifest.scene, SCENES) && !isSurroundings(manifest.scene))
        throw InputError("upload.scene", shown(manifest.scene), "a glTF, GLB, OBJ, HDR or EXR file");
    return manifest;
}

}  // namespace heliograph
