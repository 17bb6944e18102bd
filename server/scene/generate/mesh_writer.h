#pragma once
// Collects the triangles of a generated scene. Everything added goes through the present transform and takes the
// present material, so that repeated parts are written as plain copies: one mesh, one tree, no second level to
// traverse.

#include "server/scene/build/scene_builder.h"

#include <glm/gtc/matrix_transform.hpp>

namespace heliograph::generate {

/// Translation by `offset`.
inline mat4 placed(vec3 offset) { return glm::translate(mat4(1.0f), offset); }
/// Rotation about +Y by quarter turns, exact: walls that meet at right angles share their vertices' bits.
mat4 quarterTurned(int turns);
/// Rotation about +Y in degrees.
inline mat4 turned(float degrees) { return glm::rotate(mat4(1.0f), glm::radians(degrees), vec3(0, 1, 0)); }
/// Uniform scale.
inline mat4 scaled(float factor) { return glm::scale(mat4(1.0f), vec3(factor)); }

class MeshWriter {
public:
    void setMaterial(uint32_t material) { material_ = material; }
    uint32_t material() const { return material_; }
    /// Applies to what is added from now on. A mirroring transform flips the winding as well.
    void setTransform(const mat4& toWorld);
    const mat4& transform() const { return transform_; }

    /// `normal` need not be unit. `uv` in metres by convention; texture slots divide by the image's size.
    uint32_t vertex(vec3 position, vec3 normal, vec2 uv);
    /// Counter-clockwise seen from outside.
    void triangle(uint32_t a, uint32_t b, uint32_t c);
    void quad(uint32_t a, uint32_t b, uint32_t c, uint32_t d) { triangle(a, b, c), triangle(a, c, d); }
    /// A flat quad with its own vertices; uv runs along the given corners.
    void flatQuad(vec3 a, vec3 b, vec3 c, vec3 d, vec2 uvA, vec2 uvB, vec2 uvC, vec2 uvD);
    /// A flat quad with uv in metres: u along a to b, v along a to d.
    void flatQuad(vec3 a, vec3 b, vec3 c, vec3 d);

    size_t triangleCount() const { return mesh_.indices.size(); }
    /// Ends the mesh and starts an empty one.
    MeshData take();

private:
    MeshData mesh_;
    mat4 transform_{1.0f};
    mat3 normalTransform_{1.0f};
    bool mirrored_ = false;
    uint32_t material_ = 0;
};

}  // namespace heliograph::generate
