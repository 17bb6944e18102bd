#include "server/scene/build/mesh_prepare.h"

#include "server/scene/build/mesh_tangents.h"
#include "server/scene/build/transform.h"

#include <algorithm>
#include <cmath>

namespace heliograph {

namespace {

// Beyond this, squared lengths and areas leave the range of float.
constexpr float LARGEST_COORDINATE = 1e18f;

bool usable(vec3 p) {
    return std::abs(p.x) <= LARGEST_COORDINATE && std::abs(p.y) <= LARGEST_COORDINATE &&
           std::abs(p.z) <= LARGEST_COORDINATE;  // false for NaN
}

template <typename T>
void checkLength(std::vector<T>& array, size_t wanted, MeshReport& report) {
    if (array.empty() || array.size() == wanted) return;
    array.clear();
    report.badArrays++;
}

void checkArrays(MeshData& mesh, MeshReport& report) {
    const size_t count = mesh.positions.size();
    checkLength(mesh.normals, count, report);
    checkLength(mesh.uv0, count, report);
    checkLength(mesh.uv1, count, report);
    checkLength(mesh.tangents, count, report);
    checkLength(mesh.colors, count, report);
    checkLength(mesh.materials, mesh.indices.size(), report);
    for (auto* uvs : {&mesh.uv0, &mesh.uv1}) {
        for (vec2& uv : *uvs) {
            if (!finite(uv)) uv = vec2(0.0f);
        }
    }
    for (vec4& color : mesh.colors) color = finite(color) ? glm::clamp(color, 0.0f, 1.0f) : vec4(1.0f);
}

void dropTriangles(MeshData& mesh, size_t materialCount, MeshReport& report) {
    size_t kept = 0;
    const size_t vertexCount = mesh.positions.size();
    for (size_t i = 0; i < mesh.indices.size(); i++) {
        const uvec3 t = mesh.indices[i];
        if (t.x >= vertexCount || t.y >= vertexCount || t.z >= vertexCount) {
            report.outOfRange++;
            continue;
        }
        const vec3 a = mesh.positions[t.x], b = mesh.positions[t.y], c = mesh.positions[t.z];
        if (!usable(a) || !usable(b) || !usable(c)) {
            report.nonFinite++;
            continue;
        }
        const glm::dvec3 normal = glm::cross(glm::dvec3(b) - glm::dvec3(a), glm::dvec3(c) - glm::dvec3(a));
        if (normal.x == 0.0 && normal.y == 0.0 && normal.z == 0.0) report.zeroArea++;
        mesh.indices[kept] = t;
        if (!mesh.materials.empty()) {
            uint32_t material = mesh.materials[i];
            if (material >= materialCount) {
                material = 0;
                report.badMaterials++;
            }
            mesh.materials[kept] = material;
        }
        kept++;
    }
    mesh.indices.resize(kept);
    if (!mesh.materials.empty()) mesh.materials.resize(kept);
}

template <typename T>
void gather(std::vector<T>& array, std::span<const uint32_t> sources) {
    if (array.empty()) return;
    // Sources grow, so moving down in place never overwrites what is still needed.
    for (size_t i = 0; i < sources.size(); i++) array[i] = array[sources[i]];
    array.resize(sources.size());
}

void dropUnusedVertices(MeshData& mesh) {
    std::vector<uint32_t> target(mesh.positions.size(), NO_INDEX);
    for (const uvec3& t : mesh.indices) target[t.x] = target[t.y] = target[t.z] = 0;
    std::vector<uint32_t> sources;
    sources.reserve(mesh.positions.size());
    for (size_t i = 0; i < target.size(); i++) {
        if (target[i] == NO_INDEX) continue;
        target[i] = static_cast<uint32_t>(sources.size());
        sources.push_back(static_cast<uint32_t>(i));
    }
    if (sources.size() == target.size()) return;
    gather(mesh.positions, sources);
    gather(mesh.normals, sources);
    gather(mesh.uv0, sources);
    gather(mesh.uv1, sources);
    gather(mesh.tangents, sources);
    gather(mesh.colors, sources);
    for (uvec3& t : mesh.indices) t = uvec3(target[t.x], target[t.y], target[t.z]);
}

void fillNormals(MeshData& mesh, MeshReport& report) {
    if (mesh.normals.empty()) {
        mesh.normals = areaWeightedNormals(mesh.positions, mesh.indices);
        return;
    }
    std::vector<uint32_t> bad;
    for (size_t i = 0; i < mesh.normals.size(); i++) {
        const glm::dvec3 normal(mesh.normals[i]);
        const double length = glm::length(normal);
        if (std::isfinite(length) && length > 1e-30) {
            mesh.normals[i] = vec3(normal / length);
        } else {
            bad.push_back(static_cast<uint32_t>(i));
        }
    }
    if (bad.empty()) return;
    report.badNormals += bad.size();
    const std::vector<vec3> made = areaWeightedNormals(mesh.positions, mesh.indices);
    for (uint32_t i : bad) mesh.normals[i] = made[i];
}

}  // namespace

void MeshReport::add(const MeshReport& other) {
    outOfRange += other.outOfRange;
    nonFinite += other.nonFinite;
    zeroArea += other.zeroArea;
    badMaterials += other.badMaterials;
    badNormals += other.badNormals;
    badArrays += other.badArrays;
}

std::vector<vec3> areaWeightedNormals(std::span<const vec3> positions, std::span<const uvec3> triangles) {
    std::vector<glm::dvec3> sums(positions.size(), glm::dvec3(0.0));
    for (const uvec3& t : triangles) {
        const glm::dvec3 a(positions[t.x]), b(positions[t.y]), c(positions[t.z]);
        const glm::dvec3 doubled = glm::cross(b - a, c - a);  // length: twice the area
        sums[t.x] += doubled;
        sums[t.y] += doubled;
        sums[t.z] += doubled;
    }
    std::vector<vec3> normals(positions.size());
    for (size_t i = 0; i < sums.size(); i++) {
        const double length = glm::length(sums[i]);
        normals[i] = length > 0.0 ? vec3(sums[i] / length) : vec3(0.0f, 1.0f, 0.0f);
    }
    return normals;
}

MeshReport prepareMesh(MeshData& mesh, std::span<const Steering> materials) {
    MeshReport report;
    checkArrays(mesh, report);
    dropTriangles(mesh, materials.size(), report);
    dropUnusedVertices(mesh);
    fillNormals(mesh, report);
    fillTangents(mesh, materials);
    return report;
}

}  // namespace heliograph
