// tinygltf turns checked JSON into structs. It opens no file, decodes no base64 and reads no GLB here: its own code for
// these checks too little (its issues 363, 364, 372).
#include "server/scene/load/gltf_rules.h"

#include <fstream>  // tiny_gltf.h needs it and does not say so

#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_NO_FS
#include "server/scene/load/gltf_document.h"

#include "server/base/error.h"
#include "server/base/json_text.h"
#include "server/scene/load/file_folder.h"
#include "server/scene/load/gltf_accessor.h"
#include "server/scene/load/gltf_draco.h"
#include "server/scene/load/gltf_meshopt.h"

#include <cstring>
#include <map>

namespace heliograph {

using nlohmann::json;

namespace {

constexpr uint64_t DEEPEST_JSON = 64;
constexpr uint64_t MOST_JSON_VALUES = 8'000'000;  // about 32 bytes each once parsed

uint32_t wordAt(ByteSpan bytes, size_t offset) {
    uint32_t word;
    std::memcpy(&word, bytes.data() + offset, 4);
    return word;
}

/// The two parts of a glTF file.
struct Parts {
    ByteSpan json;
    ByteSpan binary;
    bool isBinary = false;
};

/// Splits a GLB container (glTF 2.0, chapter 4.4); text is all JSON.
Parts splitFile(ByteSpan bytes, const std::string& file, std::vector<std::string>& warnings) {
    Parts parts;
    if (bytes.size() < 4 || std::memcmp(bytes.data(), "glTF", 4) != 0) {
        parts.json = bytes;
        return parts;
    }
    parts.isBinary = true;
    if (bytes.size() < 12)
        throw InputError(file, "the GLB header is cut off after " + std::to_string(bytes.size()) + " bytes", "12 bytes");
    if (wordAt(bytes, 4) != 2) throw InputError(file, "GLB version " + std::to_string(wordAt(bytes, 4)), "2");
    const uint64_t length = wordAt(bytes, 8);
    if (length < 12 || length > bytes.size()) {
        throw InputError(file,
                         "GLB length " + std::to_string(length) + " in a file of " + std::to_string(bytes.size()) + " bytes",
                         "the file's size");
    }
    if (length < bytes.size())
        warnings.push_back(std::to_string(bytes.size() - length) + " bytes after the GLB's end were ignored");
    size_t chunk = 0;
    for (uint64_t at = 12; at < length; chunk++) {
        if (at + 8 > length) throw InputError(file, "a chunk header is cut off at byte " + std::to_string(at));
        const uint64_t size = wordAt(bytes, at);
        const uint32_t type = wordAt(bytes, at + 4);
        at += 8;
        if (at + size > length)
            throw InputError(file, "chunk " + std::to_string(chunk) + " of " + std::to_string(size) + " bytes is cut off");
        const ByteSpan content = bytes.subspan(at, size);
        constexpr uint32_t JSON = 0x4e4f534a, BIN = 0x004e4942;
        if (chunk == 0 && type != JSON) throw InputError(file, "the first chunk is not JSON");
        if (chunk == 0) parts.json = content;
        else if (type == BIN && chunk == 1) parts.binary = content;
        else if (type == BIN || type == JSON)
            throw InputError(file, "chunk " + std::to_string(chunk) + " is out of place", "JSON first, then BIN");
        else warnings.push_back("an unknown GLB chunk was ignored");
        at += size;
    }
    if (chunk == 0) throw InputError(file, "the GLB has no JSON chunk");
    return parts;
}

/// Depth and number of values, before anything is parsed.
void checkJsonText(ByteSpan text, const std::string& file) {
    const JsonExtent extent = jsonExtent({reinterpret_cast<const char*>(text.data()), text.size()}, DEEPEST_JSON);
    if (extent.depth > DEEPEST_JSON) {
        throw InputError(file, "JSON nested deeper than " + std::to_string(DEEPEST_JSON));
    }
    if (extent.values > MOST_JSON_VALUES) {
        throw InputError(file, std::to_string(extent.values) + " JSON values", "at most " + std::to_string(MOST_JSON_VALUES));
    }
}

json parseJson(ByteSpan text, const std::string& file) {
    checkJsonText(text, file);
    try {
        return json::parse(text.begin(), text.end());
    } catch (const json::exception& error) {
        std::string what = error.what();
        if (const size_t bracket = what.find("] "); bracket != std::string::npos) what = what.substr(bracket + 2);
        throw InputError(file, "no valid JSON: " + what.substr(0, 160));
    }
}

/// The document's bytes: buffers and images, from the file itself, from data URIs, from files beside it.
class Resources {
public:
    Resources(GltfDocument& document, const std::filesystem::path& path, const Parts& parts)
        : document_(document), folder_(path), parts_(parts) {}

    void readBuffers(const json& root) {
        if (!root.contains("buffers")) return;
        size_t i = 0;
        for (const json& buffer : root["buffers"]) {
            const std::string at = "/buffers/" + std::to_string(i);
            const uint64_t length = buffer["byteLength"].get<uint64_t>();
            ByteSpan bytes;
            if (isFallbackBuffer(buffer)) {
                document_.buffers.emplace_back();
                i++;
                continue;
            }
            if (buffer.contains("uri")) {
                bytes = fromUri(buffer["uri"], at + "/uri", true);
            } else if (parts_.isBinary && i == 0 && !parts_.binary.empty()) {
                bytes = parts_.binary;
            } else {
                // Legal where nothing refers to it; a buffer view that does is refused.
                document_.warnings.push_back(at + " has no data: neither a uri nor the BIN chunk of a GLB");
                document_.buffers.emplace_back();
                i++;
                continue;
            }
            if (bytes.size() < length) {
                throw InputError(document_.at(at + "/byteLength"),
                                 std::to_string(length) + " for " + std::to_string(bytes.size()) + " bytes",
                                 "at most the bytes that are there");
            }
            document_.buffers.push_back(bytes.first(length));
            i++;
        }
    }

    void readImages(const json& root) {
        if (!root.contains("images")) return;
        size_t i = 0;
        for (const json& image : root["images"]) {
            const std::string at = "/images/" + std::to_string(i++);
            GltfImage entry;
            entry.name = document_.at(at);
            if (image.contains("bufferView")) {
                entry.bytes = document_.view(image["bufferView"].get<int>());
            } else if (image.contains("uri")) {
                readImage(entry, image["uri"], at + "/uri");
            } else {
                entry.fault = "no uri and no bufferView";
            }
            document_.images.push_back(std::move(entry));
        }
    }

private:
    /// An image that is missing, broken or out of the folder costs a texture.
    void readImage(GltfImage& entry, const std::string& uri, const std::string& at) {
        try {
            entry.bytes = fromUri(uri, at, false);
        } catch (const InputError& error) {
            if (total_ > 2 * MOST_FILE_BYTES) throw;
            const std::string what = error.what();
            entry.fault = what.substr(std::min(what.size(), error.field().size() + 2));
        }
    }

    ByteSpan fromUri(const std::string& uri, const std::string& at, bool isBuffer) {
        std::vector<uint8_t> bytes;
        if (sameButForCase(uri.substr(0, 5), "data:")) {
            const size_t comma = uri.find(',');
            if (comma == std::string::npos)
                throw InputError(document_.at(at), "a data URI without data", "data:<type>;base64,<data>");
            const std::string head = uri.substr(0, std::min(comma, size_t(200)));
            const std::string_view data = std::string_view(uri).substr(comma + 1);
            if (head.size() >= 7 && sameButForCase(head.substr(head.size() - 7), ";base64")) {
                const bool plain =
                    decodeBase64(data, bytes) || decodeBase64(withoutBlanks(percentDecoded(data, document_.at(at))), bytes);
                if (!plain) throw InputError(document_.at(at), "broken base64 data");
            } else {
                const std::string plain = percentDecoded(data, document_.at(at));
                bytes.assign(plain.begin(), plain.end());
            }
            if (isBuffer && head != "data:application/octet-stream;base64" && head != "data:application/gltf-buffer;base64")
                document_.warnings.push_back(at + ": media type '" + head.substr(5, 60) + "' of a buffer");
        } else {
            const std::filesystem::path path = folder_.resolve(percentDecoded(uri, document_.at(at)), document_.at(at));
            const auto known = files_.find(path);
            if (known != files_.end()) return known->second;
            bytes = readFile(path);
            total_ += bytes.size();
            if (total_ > 2 * MOST_FILE_BYTES) throw InputError(document_.at(at), "more than 4 GiB in all", "at most 4 GiB");
            document_.sourceBytes += bytes.size();
            document_.storage.push_back(std::move(bytes));
            return files_[path] = document_.storage.back();
        }
        document_.storage.push_back(std::move(bytes));
        return document_.storage.back();
    }

    GltfDocument& document_;
    FileFolder folder_;
    const Parts& parts_;
    std::map<std::filesystem::path, ByteSpan> files_;  // each is read once
    uint64_t total_ = 0;                               // bytes of them
};

/// Buffer views end inside their buffers.
void checkViews(const json& root, const GltfDocument& document) {
    if (!root.contains("bufferViews")) return;
    size_t i = 0;
    for (const json& view : root["bufferViews"]) {
        const size_t index = i++;
        if (isMeshoptView(view)) continue;
        const uint64_t offset = view.contains("byteOffset") ? view["byteOffset"].get<uint64_t>() : 0;
        const uint64_t length = view["byteLength"].get<uint64_t>();
        const uint64_t size = document.buffers[view["buffer"].get<size_t>()].size();
        if (offset > size || length > size - offset) {
            throw InputError(document.at("/bufferViews/" + std::to_string(index)),
                             "bytes " + std::to_string(offset) + " to " + std::to_string(offset + length),
                             "at most byte " + std::to_string(size) + ", the end of the buffer's data");
        }
    }
}

std::vector<float> lightRadiiOf(const json& root) {
    std::vector<float> radii;
    const json::json_pointer lights("/extensions/KHR_lights_punctual/lights");
    if (!root.contains(lights) || !root[lights].is_array()) return radii;
    const json::json_pointer radius("/extras/radius");
    for (const json& light : root[lights])
        radii.push_back(light.contains(radius) && light[radius].is_number() ? light[radius].get<float>() : 0.0f);
    return radii;
}

std::vector<std::string> animationsOf(const json& root) {
    std::vector<std::string> names;
    if (!root.contains("animations")) return names;
    for (const json& animation : root["animations"]) names.push_back(animation.value("name", ""));
    return names;
}

/// Removes what tinygltf need not see (bytes, and what is not drawn), so that its structs stay small.
void strip(json& value, int depth = 0) {
    if (value.is_object()) {
        value.erase("extras");
        if (depth == 0) {
            for (const char* name : {"buffers", "images", "animations"}) value.erase(name);
        }
    }
    if (!value.is_structured()) return;
    for (json& child : value) strip(child, depth + 1);
}

/// Indices of a primitive whose accessor has no buffer view: all zero, or sparse. The specification allows them, tinygltf does not.
struct BareIndices {
    size_t mesh, primitive;
    int accessor;
};

std::vector<BareIndices> takeBareIndices(json& root) {
    std::vector<BareIndices> taken;
    if (!root.contains("meshes") || !root.contains("accessors")) return taken;
    for (size_t m = 0; m < root["meshes"].size(); m++) {
        json& primitives = root["meshes"][m]["primitives"];
        for (size_t p = 0; p < primitives.size(); p++) {
            if (!primitives[p].contains("indices")) continue;
            const int accessor = primitives[p]["indices"].get<int>();
            if (root["accessors"][static_cast<size_t>(accessor)].contains("bufferView")) continue;
            taken.push_back({m, p, accessor});
            primitives[p].erase("indices");
        }
    }
    return taken;
}

void parseModel(json& root, GltfDocument& document) {
    const std::vector<BareIndices> bare = takeBareIndices(root);
    const std::string text = root.dump();
    tinygltf::TinyGLTF parser;
    std::string error, warning;
    const bool parsed = parser.LoadASCIIFromString(&document.model, &error, &warning, text.data(),
                                                   static_cast<unsigned int>(text.size()), "", tinygltf::NO_REQUIRE);
    for (std::string* message : {&error, &warning}) {
        if (const size_t end = message->find('\n'); end != std::string::npos) message->resize(end);
        if (message->size() > 200) message->resize(200);
    }
    if (!parsed) throw InputError(document.file, error.empty() ? "the file cannot be parsed" : error);
    for (const BareIndices& one : bare) document.model.meshes[one.mesh].primitives[one.primitive].indices = one.accessor;
}

}  // namespace

ByteSpan GltfDocument::view(int bufferView) const {
    const tinygltf::BufferView& view = model.bufferViews.at(static_cast<size_t>(bufferView));
    return buffers.at(static_cast<size_t>(view.buffer)).subspan(view.byteOffset, view.byteLength);
}

int GltfDocument::addDecoded(std::vector<uint8_t>&& bytes) {
    decodedBytes += bytes.size();
    storage.push_back(std::move(bytes));
    buffers.push_back(storage.back());
    tinygltf::BufferView view;
    view.buffer = static_cast<int>(buffers.size() - 1);
    view.byteLength = storage.back().size();
    model.bufferViews.push_back(std::move(view));
    return static_cast<int>(model.bufferViews.size() - 1);
}

GltfDocument readGltf(const std::filesystem::path& path) {
    GltfDocument document;
    document.file = path.string();
    document.storage.push_back(readFile(path));
    const ByteSpan bytes = document.storage.front();
    document.sourceBytes = bytes.size();
    const Parts parts = splitFile(bytes, document.file, document.warnings);
    json root = parseJson(parts.json, document.file);
    checkGltfJson(root, document.file, document.warnings);
    document.animations = animationsOf(root);
    if (!document.animations.empty()) document.warnings.push_back("animations are not played: the scene is shown at rest");
    Resources resources(document, path, parts);
    resources.readBuffers(root);
    checkViews(root, document);
    const std::vector<MeshoptView> compressed = meshoptViewsOf(root, document);
    json images = json::object();
    if (root.contains("images")) images["images"] = std::move(root["images"]);
    document.lightRadii = lightRadiiOf(root);
    strip(root);
    dropCompressedIndices(root);
    parseModel(root, document);
    root = nullptr;
    decodeMeshoptViews(compressed, document);
    decodeDracoGeometry(document);
    checkAccessors(document);
    resources.readImages(images);
    return document;
}

}  // namespace heliograph
