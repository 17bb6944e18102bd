#include "server/scene/generate/mesh_writer.h"

#include <utility>

namespace heliograph::generate {

mat4 quarterTurned(int turns) {
    static const float cosines[4] = {1.0f, 0.0f, -1.0f, 0.0f};
    const float c = cosines[turns & 3], s = cosines[(turns + 3) & 3];
    mat4 matrix(1.0f);
    matrix[0] = vec4(c, 0.0f, -s, 0.0f);
    matrix[2] = vec4(s, 0.0f, c, 0.0f);
    return matrix;
}

void MeshWriter::setTransform(const mat4& toWorld) {
    transform_ = toWorld;
    normalTransform_ = glm::transpose(glm::inverse(mat3(toWorld)));
    mirrored_ = glm::determinant(mat3(toWorld)) < 0.0f;
}

uint32_t MeshWriter::vertex(vec3 position, vec3 normal, vec2 uv) {
    mesh_.positions.push_back(vec3(transform_ * vec4(position, 1.0f)));
    mesh_.normals.push_back(glm::normalize(normalTransform_ * normal));
    mesh_.uv0.push_back(uv);
    return uint32_t(mesh_.positions.size() - 1);
}

void MeshWriter::triangle(uint32_t a, uint32_t b, uint32_t c) {
    if (mirrored_) std::swap(b, c);
    mesh_.indices.push_back(uvec3(a, b, c));
    mesh_.materials.push_back(material_);
}

void MeshWriter::flatQuad(vec3 a, vec3 b, vec3 c, vec3 d, vec2 uvA, vec2 uvB, vec2 uvC, vec2 uvD) {
    const vec3 normal = glm::cross(c - a, d - b);
    const uint32_t ia = vertex(a, normal, uvA), ib = vertex(b, normal, uvB);
    const uint32_t ic = vertex(c, normal, uvC), id = vertex(d, normal, uvD);
    quad(ia, ib, ic, id);
}

void MeshWriter::flatQuad(vec3 a, vec3 b, vec3 c, vec3 d) {
    const float width = glm::length(b - a), height = glm::length(d - a);
    flatQuad(a, b, c, d, vec2(0, 0), vec2(width, 0), vec2(width, height), vec2(0, height));
}

MeshData MeshWriter::take() { return std::exchange(mesh_, MeshData{}); }

}  // namespace heliograph::generate
