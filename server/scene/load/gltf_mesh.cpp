#include "server/scene/load/gltf_mesh.h"

#include "server/base/error.h"
#include "server/scene/load/gltf_accessor.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace heliograph {

namespace {

// Vertices and corners that a file may make whatever its size; more must be backed by bytes.
constexpr uint64_t FREE_ELEMENTS = 3'000'000;
constexpr uint64_t ELEMENTS_PER_BYTE = 4;
constexpr size_t MOST_UNUSED = 4;                  // vertices a corner
constexpr uint64_t DECODED_BYTES_PER_ELEMENT = 2;  // a corner of 4 bytes, once more where it is flat

/// Triangles from the corners of a strip, a fan or a list (glTF 2.0, chapter 3.7.2.1).
std::vector<uvec3> assemble(const std::vector<uint32_t>& c, int mode) {
    std::vector<uvec3> triangles;
    if (mode == TINYGLTF_MODE_TRIANGLES) {
        for (size_t i = 0; i + 2 < c.size(); i += 3) triangles.emplace_back(c[i], c[i + 1], c[i + 2]);
    } else if (mode == TINYGLTF_MODE_TRIANGLE_STRIP) {
        for (size_t i = 0; i + 2 < c.size(); i++) triangles.emplace_back(c[i], c[i + 1 + i % 2], c[i + 2 - i % 2]);
    } else {
        for (size_t i = 1; i + 1 < c.size(); i++) triangles.emplace_back(c[0], c[i], c[i + 1]);
    }
    return triangles;
}

template <typename V>
void readAll(const GltfAccessor& accessor, const std::vector<uint32_t>& vertices, bool normalized, V fill,
             std::vector<V>& out) {
    out.assign(vertices.size(), fill);
    tbb::parallel_for(tbb::blocked_range<size_t>(0, vertices.size(), 16384), [&](const tbb::blocked_range<size_t>& part) {
        for (size_t i = part.begin(); i < part.end(); i++)
            accessor.readFloats(vertices[i], V::length(), normalized, &out[i][0]);
    });
}

/// Which attributes are drawn, and how they may be stored.
struct AttributeRule {
    const char* name;
    int fewest;
    int most;               // components
    bool alwaysNormalized;  // integers are always shares of 1
};
constexpr AttributeRule POSITION{"POSITION", 3, 3, false};
constexpr AttributeRule NORMAL{"NORMAL", 3, 3, true};
constexpr AttributeRule TANGENT{"TANGENT", 4, 4, true};
constexpr AttributeRule TEXCOORD_0{"TEXCOORD_0", 2, 2, false};
constexpr AttributeRule TEXCOORD_1{"TEXCOORD_1", 2, 2, false};
constexpr AttributeRule COLOR_0{"COLOR_0", 3, 4, true};

bool knownAttribute(const std::string& name) {
    static const char* NAMES[] = {"POSITION", "NORMAL", "TANGENT", "TEXCOORD_0", "TEXCOORD_1", "COLOR_0"};
    if (name.rfind("_", 0) == 0) return true;  // the application's own
    return std::any_of(std::begin(NAMES), std::end(NAMES), [&](const char* known) { return name == known; });
}

}  // namespace

std::vector<uint32_t> takeUsed(std::vector<uint32_t>& corners, size_t vertexCount) {
    std::vector<uint32_t> vertices;
    if (vertexCount > MOST_UNUSED * corners.size()) {  // a table of all would be larger than the mesh
        vertices = corners;
        std::sort(vertices.begin(), vertices.end());
        vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
        if (!vertices.empty() && vertices.back() == NO_INDEX) vertices.pop_back();
        for (uint32_t& corner : corners) {
            if (corner != NO_INDEX)
                corner = static_cast<uint32_t>(std::lower_bound(vertices.begin(), vertices.end(), corner) - vertices.begin());
        }
        return vertices;
    }
    std::vector<uint32_t> numbers(vertexCount, NO_INDEX);
    for (const uint32_t corner : corners) {
        if (corner != NO_INDEX) numbers[corner] = 0;
    }
    for (size_t i = 0; i < vertexCount; i++) {
        if (numbers[i] == NO_INDEX) continue;
        numbers[i] = static_cast<uint32_t>(vertices.size());
        vertices.push_back(static_cast<uint32_t>(i));
    }
    for (uint32_t& corner : corners) {
        if (corner != NO_INDEX) corner = numbers[corner];
    }
    return vertices;
}

GltfMeshReader::GltfMeshReader(const GltfDocument& document, SceneBuilder& builder)
    : document_(document),
      builder_(builder),
      mostElements_(FREE_ELEMENTS + ELEMENTS_PER_BYTE * document.sourceBytes +
                    document.decodedBytes / DECODED_BYTES_PER_ELEMENT) {}

void GltfMeshReader::account(uint64_t elements, const std::string& pointer) {
    elements_ += elements;
    if (elements_ > mostElements_) {
        throw InputError(document_.at(pointer), std::to_string(elements_) + " vertices and corners so far",
                         "at most " + std::to_string(mostElements_) + " for a file of this size");
    }
}

std::vector<uint32_t> GltfMeshReader::cornersOf(const tinygltf::Primitive& primitive, size_t vertexCount,
                                                const std::string& pointer) {
    std::vector<uint32_t> corners;
    if (primitive.indices < 0) {
        account(vertexCount, pointer);
        corners.resize(vertexCount);
        std::iota(corners.begin(), corners.end(), 0u);
        return corners;
    }
    const GltfAccessor accessor(document_, primitive.indices);
    const int type = accessor.componentType();
    const bool isIndex = type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE || type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
                         type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
    if (accessor.components() != 1 || !isIndex || accessor.normalized()) {
        throw InputError(document_.at(pointer + "/indices"),
                         std::to_string(accessor.components()) + " components of type " + std::to_string(type),
                         "one component of type 5121, 5123 or 5125, not normalized");
    }
    account(accessor.count(), pointer);
    corners.resize(accessor.count());
    for (size_t i = 0; i < corners.size(); i++) {
        const uint32_t index = accessor.readIndex(i);
        corners[i] = index < vertexCount ? index : NO_INDEX;  // dropped and counted by the builder
    }
    return corners;
}

MeshData GltfMeshReader::read(const tinygltf::Primitive& primitive, const std::vector<double>& weights,
                              const std::string& pointer) {
    MeshData mesh;
    const int mode = primitive.mode < 0 ? TINYGLTF_MODE_TRIANGLES : primitive.mode;
    if (mode < TINYGLTF_MODE_TRIANGLES) {
        builder_.warn("points and lines are not drawn");
        return mesh;
    }
    const auto position = primitive.attributes.find("POSITION");
    if (position == primitive.attributes.end()) {
        builder_.warn(pointer + " has no POSITION: not drawn");
        return mesh;
    }
    const GltfAccessor positions(document_, position->second);
    const size_t vertexCount = positions.count();
    std::vector<uint32_t> corners = cornersOf(primitive, vertexCount, pointer);
    if (mode == TINYGLTF_MODE_TRIANGLES ? corners.size() % 3 != 0 || corners.empty() : corners.size() < 3)
        builder_.warn(pointer + " has " + std::to_string(corners.size()) + " corners: the last ones make no triangle");

    // Only what is used is read: files may share one large array among many primitives.
    std::vector<uint32_t> vertices = takeUsed(corners, vertexCount);
    account(vertices.size(), pointer);
    mesh.indices = assemble(corners, mode);
    if (!primitive.attributes.count("NORMAL")) {
        // Without normals the specification asks for flat shading: no two triangles share a vertex.
        std::vector<uint32_t> flat;
        for (uvec3& t : mesh.indices) {
            for (int k = 0; k < 3; k++) {
                if (t[k] == NO_INDEX) continue;
                flat.push_back(vertices[t[k]]);
                t[k] = static_cast<uint32_t>(flat.size() - 1);
            }
        }
        account(flat.size(), pointer);
        vertices = std::move(flat);
    }
    readAttributes(primitive, vertices, mesh, pointer);
    const tinygltf::Accessor& bounds = document_.model.accessors[static_cast<size_t>(position->second)];
    if (bounds.minValues.size() != 3 || bounds.maxValues.size() != 3) builder_.warn(pointer + ": POSITION has no min and max");
    applyMorphs(primitive, weights, vertices, mesh);
    return mesh;
}

void GltfMeshReader::readAttributes(const tinygltf::Primitive& primitive, const std::vector<uint32_t>& vertices, MeshData& mesh,
                                    const std::string& pointer) {
    const size_t count = GltfAccessor(document_, primitive.attributes.at("POSITION")).count();
    const auto read = [&](const AttributeRule& rule, auto fill, auto& out) {
        const auto found = primitive.attributes.find(rule.name);
        if (found == primitive.attributes.end()) return;
        const GltfAccessor accessor(document_, found->second);
        const std::string where = document_.at(pointer + "/attributes/" + rule.name);
        if (accessor.components() < rule.fewest || accessor.components() > rule.most || accessor.isMatrix())
            throw InputError(where, std::to_string(accessor.components()) + " components",
                             std::to_string(rule.fewest) + " to " + std::to_string(rule.most));
        if (accessor.count() != count)
            throw InputError(where, std::to_string(accessor.count()) + " elements",
                             std::to_string(count) + ", as POSITION has");
        readAll(accessor, vertices, rule.alwaysNormalized, fill, out);
    };
    read(POSITION, vec3(0.0f), mesh.positions);
    read(NORMAL, vec3(0.0f), mesh.normals);
    read(TANGENT, vec4(0.0f), mesh.tangents);
    read(TEXCOORD_0, vec2(0.0f), mesh.uv0);
    read(TEXCOORD_1, vec2(0.0f), mesh.uv1);
    read(COLOR_0, vec4(1.0f), mesh.colors);
    if (mesh.normals.empty()) mesh.tangents.clear();  // tangents belong to normals (glTF 2.0, chapter 3.7.2.1)
    for (const auto& [name, accessor] : primitive.attributes) {
        if (knownAttribute(name)) continue;
        const bool skin = name.rfind("JOINTS_", 0) == 0 || name.rfind("WEIGHTS_", 0) == 0;
        builder_.warn(skin ? "skins are not played: the scene is shown at rest"
                           : "attribute " + name.substr(0, 40) + " is not drawn");
    }
}

void GltfMeshReader::applyMorphs(const tinygltf::Primitive& primitive, const std::vector<double>& weights,
                                 const std::vector<uint32_t>& vertices, MeshData& mesh) {
    if (primitive.targets.empty()) return;
    builder_.warn("morph targets are not played: the scene is shown at rest");
    const size_t count = GltfAccessor(document_, primitive.attributes.at("POSITION")).count();
    const auto add = [&](size_t target, const char* name, std::vector<vec3>& values) {
        const auto found = primitive.targets[target].find(name);
        if (found == primitive.targets[target].end() || values.empty()) return;
        if (found->second < 0 || static_cast<size_t>(found->second) >= document_.model.accessors.size()) return;
        const GltfAccessor accessor(document_, found->second);
        if (accessor.components() != 3 || accessor.count() != count) {
            builder_.warn("a morph target does not fit its mesh: ignored");
            return;
        }
        for (size_t i = 0; i < vertices.size(); i++) {
            vec3 delta(0.0f);
            accessor.readFloats(vertices[i], 3, false, &delta[0]);
            values[i] += delta * static_cast<float>(weights[target]);
        }
    };
    if (!weights.empty() && weights.size() != primitive.targets.size())
        builder_.warn("a mesh has " + std::to_string(weights.size()) + " weights for " +
                      std::to_string(primitive.targets.size()) + " morph targets");
    for (size_t i = 0; i < primitive.targets.size() && i < weights.size(); i++) {
        if (weights[i] == 0.0) continue;
        account(vertices.size(), "/meshes");
        add(i, "POSITION", mesh.positions);
        add(i, "NORMAL", mesh.normals);
    }
}

}  // namespace heliograph
