#include "tests/support/bodies.h"

#include <map>

namespace heliograph::test {

MeshData icosphere(int subdivisions, uint32_t material) {
    const double g = (1.0 + std::sqrt(5.0)) / 2.0;
    std::vector<glm::dvec3> points = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                                      {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
    for (glm::dvec3& p : points) p = glm::normalize(p);
    MeshData mesh;
    mesh.indices = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                    {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                    {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
    for (int i = 0; i < subdivisions; i++) {
        std::map<std::pair<uint32_t, uint32_t>, uint32_t> middles;
        const auto middle = [&](uint32_t a, uint32_t b) {
            const auto key = std::minmax(a, b);
            auto [at, added] = middles.try_emplace({key.first, key.second}, static_cast<uint32_t>(points.size()));
            if (added) points.push_back(glm::normalize(points[a] + points[b]));
            return at->second;
        };
        std::vector<uvec3> finer;
        for (uvec3 t : mesh.indices) {
            const uint32_t ab = middle(t.x, t.y), bc = middle(t.y, t.z), ca = middle(t.z, t.x);
            finer.insert(finer.end(), {{t.x, ab, ca}, {t.y, bc, ab}, {t.z, ca, bc}, {ab, bc, ca}});
        }
        mesh.indices = std::move(finer);
    }
    for (glm::dvec3 p : points) mesh.positions.emplace_back(p);
    mesh.normals = mesh.positions;
    mesh.materials.assign(mesh.indices.size(), material);
    return mesh;
}

MeshData panel(vec3 corner, vec3 edge1, vec3 edge2, uint32_t material) {
    MeshData mesh;
    mesh.positions = {corner, corner + edge1, corner + edge1 + edge2, corner + edge2};
    mesh.uv0 = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    mesh.normals.assign(4, glm::normalize(glm::cross(edge1, edge2)));
    mesh.indices = {{0, 1, 2}, {0, 2, 3}};
    mesh.materials = {material, material};
    return mesh;
}

MeshData box(vec3 low, vec3 high, uint32_t material) {
    MeshData mesh;
    const vec3 d = high - low;
    const vec3 x(d.x, 0, 0), y(0, d.y, 0), z(0, 0, d.z);
    const MeshData faces[] = {panel(low, y, x, material),     panel(low + z, x, y, material), panel(low, z, y, material),
                              panel(low + x, y, z, material), panel(low, x, z, material),     panel(low + y, z, x, material)};
    for (const MeshData& face : faces) {
        const auto first = static_cast<uint32_t>(mesh.positions.size());
        mesh.positions.insert(mesh.positions.end(), face.positions.begin(), face.positions.end());
        mesh.normals.insert(mesh.normals.end(), face.normals.begin(), face.normals.end());
        mesh.uv0.insert(mesh.uv0.end(), face.uv0.begin(), face.uv0.end());
        for (uvec3 t : face.indices) mesh.indices.push_back(t + first);
    }
    mesh.materials.assign(mesh.indices.size(), material);
    return mesh;
}

MeshData insideOut(MeshData mesh) {
    for (uvec3& t : mesh.indices) t = uvec3(t.x, t.z, t.y);
    for (vec3& n : mesh.normals) n = -n;
    return mesh;
}

}  // namespace heliograph::test
