#include "server/scene/build/mesh_tangents.h"

#include <array>
#include <cmath>

namespace heliograph {

namespace {

using glm::dvec2;
using glm::dvec3;

dvec3 anyTangent(dvec3 normal) {
    const dvec3 axis = std::abs(normal.x) < 0.6 ? dvec3(1.0, 0.0, 0.0) : dvec3(0.0, 0.0, 1.0);
    return glm::normalize(axis - normal * glm::dot(axis, normal));
}

/// The sums of one vertex for one handedness.
struct TangentSum {
    dvec3 sum{0.0};
    bool used = false;
};

/// A triangle's texture frame: direction of growing u (zero if the coordinates have no area) and its handedness.
struct TextureFrame {
    dvec3 direction{0.0};
    bool mirrored = false;
};

class TangentMaker {
public:
    TangentMaker(MeshData& mesh, std::span<const Steering> materials) : mesh_(mesh), materials_(materials) {}

    void make() {
        sums_.assign(mesh_.positions.size(), {});
        mirrored_.resize(mesh_.indices.size());
        for (size_t i = 0; i < mesh_.indices.size(); i++) addTriangle(i);
        splitMirrored();
        mesh_.tangents.resize(mesh_.positions.size());
        for (size_t i = 0; i < mesh_.positions.size(); i++) mesh_.tangents[i] = tangentOf(i);
    }

private:
    const std::vector<vec2>& uvsOf(size_t triangle) const {
        const uint32_t material = mesh_.materials.empty() ? 0 : mesh_.materials[triangle];
        return materials_[material].uvSet == 1 ? mesh_.uv1 : mesh_.uv0;
    }

    TextureFrame frameOf(size_t triangle) const {
        TextureFrame frame;
        const std::vector<vec2>& uvs = uvsOf(triangle);
        if (uvs.empty()) return frame;
        const uvec3 t = mesh_.indices[triangle];
        const dvec3 edge1 = dvec3(mesh_.positions[t.y]) - dvec3(mesh_.positions[t.x]);
        const dvec3 edge2 = dvec3(mesh_.positions[t.z]) - dvec3(mesh_.positions[t.x]);
        const dvec2 uv1 = dvec2(uvs[t.y]) - dvec2(uvs[t.x]);
        const dvec2 uv2 = dvec2(uvs[t.z]) - dvec2(uvs[t.x]);
        const double area = uv1.x * uv2.y - uv1.y * uv2.x;
        // v grows downwards but a normal texture's green points up, so a picture that is not mirrored has negative
        // area.
        frame.mirrored = area > 0.0;
        if (area != 0.0) frame.direction = (edge1 * uv2.y - edge2 * uv1.y) * (area < 0.0 ? -1.0 : 1.0);
        return frame;
    }

    void addTriangle(size_t triangle) {
        const TextureFrame frame = frameOf(triangle);
        mirrored_[triangle] = frame.mirrored;
        const uvec3 t = mesh_.indices[triangle];
        for (int corner = 0; corner < 3; corner++) {
            const uint32_t vertex = t[corner];
            TangentSum& into = sums_[vertex][frame.mirrored ? 1 : 0];
            into.used = true;
            const dvec3 normal(mesh_.normals[vertex]);
            const dvec3 projected = frame.direction - normal * glm::dot(normal, frame.direction);
            const double length = glm::length(projected);
            if (length > 0.0) into.sum += projected / length * cornerAngle(t, corner);
        }
    }

    double cornerAngle(uvec3 t, int corner) const {
        const dvec3 origin(mesh_.positions[t[corner]]);
        const dvec3 a = dvec3(mesh_.positions[t[(corner + 1) % 3]]) - origin;
        const dvec3 b = dvec3(mesh_.positions[t[(corner + 2) % 3]]) - origin;
        return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
    }

    /// Gives the mirrored triangles of a vertex that has both kinds a copy of it.
    void splitMirrored() {
        const size_t count = mesh_.positions.size();
        std::vector<uint32_t> copies(count, NO_INDEX);
        for (size_t i = 0; i < count; i++) {
            if (!sums_[i][0].used || !sums_[i][1].used) continue;
            copies[i] = static_cast<uint32_t>(mesh_.positions.size());
            copyVertex(i);
            sums_.push_back({TangentSum{}, sums_[i][1]});
            sums_[i][1] = TangentSum{};
        }
        if (mesh_.positions.size() == count) return;
        for (size_t i = 0; i < mesh_.indices.size(); i++) {
            if (!mirrored_[i]) continue;
            for (int corner = 0; corner < 3; corner++) {
                const uint32_t copy = copies[mesh_.indices[i][corner]];
                if (copy != NO_INDEX) mesh_.indices[i][corner] = copy;
            }
        }
    }

    template <typename T>
    static void repeat(std::vector<T>& array, size_t index) {
        if (!array.empty()) array.push_back(T(array[index]));
    }

    void copyVertex(size_t index) {
        repeat(mesh_.positions, index);
        repeat(mesh_.normals, index);
        repeat(mesh_.uv0, index);
        repeat(mesh_.uv1, index);
        repeat(mesh_.colors, index);
    }

    vec4 tangentOf(size_t vertex) const {
        const bool mirrored = sums_[vertex][1].used;
        const dvec3 normal(mesh_.normals[vertex]);
        dvec3 tangent = sums_[vertex][mirrored ? 1 : 0].sum;
        tangent -= normal * glm::dot(normal, tangent);
        const double length = glm::length(tangent);
        tangent = length > 1e-12 ? tangent / length : anyTangent(normal);
        return vec4(vec3(tangent), mirrored ? -1.0f : 1.0f);
    }

    MeshData& mesh_;
    std::span<const Steering> materials_;
    std::vector<std::array<TangentSum, 2>> sums_;  // per vertex: plain and mirrored
    std::vector<bool> mirrored_;                   // per triangle
};

bool needsTangents(const MeshData& mesh, std::span<const Steering> materials) {
    if (mesh.materials.empty()) return !mesh.indices.empty() && materials[0].asked;
    uint32_t last = NO_INDEX;
    for (uint32_t material : mesh.materials) {
        if (material != last && materials[material].asked) return true;
        last = material;
    }
    return false;
}

/// Makes the file's own tangents unit length and orthogonal to the normal; replaces those that cannot be.
void repairTangents(MeshData& mesh) {
    for (size_t i = 0; i < mesh.tangents.size(); i++) {
        const dvec3 normal(mesh.normals[i]);
        dvec3 tangent(mesh.tangents[i].x, mesh.tangents[i].y, mesh.tangents[i].z);
        tangent -= normal * glm::dot(normal, tangent);
        const double length = glm::length(tangent);
        tangent = std::isfinite(length) && length > 1e-6 ? tangent / length : anyTangent(normal);
        mesh.tangents[i] = vec4(vec3(tangent), mesh.tangents[i].w < 0.0f ? -1.0f : 1.0f);
    }
}

}  // namespace

std::vector<Steering> steeringOf(const SceneDraft& draft) {
    std::vector<Steering> all;
    for (const Material& material : draft.scene.materials) {
        const MaterialLayers layers = material.layers == NO_INDEX ? MaterialLayers{} : draft.layers[material.layers];
        const bool brushed = layers.anisotropy > 0.0f;
        uint32_t texture = material.normalTexture;
        if (texture == NO_INDEX && brushed) texture = layers.anisotropyTexture;
        if (texture == NO_INDEX) texture = layers.coatNormalTexture;
        all.push_back({brushed || texture != NO_INDEX, texture == NO_INDEX ? 0 : draft.scene.textures[texture].uvSet});
    }
    return all;
}

void fillTangents(MeshData& mesh, std::span<const Steering> materials) {
    if (!needsTangents(mesh, materials)) {
        mesh.tangents.clear();
    } else if (!mesh.tangents.empty()) {
        repairTangents(mesh);
    } else {
        TangentMaker(mesh, materials).make();
    }
}

}  // namespace heliograph
