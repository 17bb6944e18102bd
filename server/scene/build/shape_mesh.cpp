#include "server/scene/build/shape_mesh.h"

#include <glm/gtc/quaternion.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace heliograph {

namespace {

constexpr uint32_t SEGMENTS = 32;  // a multiple of four, so that the box is that of the shape
constexpr uint32_t RINGS = 16;
constexpr double LARGEST_SHAPE = 1024.0;  // over the rest of the scene, which would not be seen beside it
// A ball whose rim is nearer the origin than an eighth of its radius has its anchor there.
constexpr double NEAR_RIM = 0.125;

/// Rows of vertices around the y axis; `u` from 0 to 1.
struct Lathe {
    MeshData& mesh;

    static vec3 around(uint32_t i, double radius, double y) {
        const double turn = 2.0 * std::numbers::pi * (double(i % SEGMENTS) / SEGMENTS - 0.5);
        return vec3(dvec3(std::sin(turn) * radius, y, std::cos(turn) * radius));
    }
    void addVertex(vec3 position, vec3 normal, vec2 uv) {
        mesh.positions.push_back(position);
        mesh.normals.push_back(normal);
        mesh.uv0.push_back(uv);
    }
    /// Joins the last two rows; triangles without area are left out.
    void join(bool pointAbove, bool pointBelow) {
        const auto row = static_cast<uint32_t>(mesh.positions.size()) - 2 * (SEGMENTS + 1);
        for (uint32_t i = row; i < row + SEGMENTS; i++) {
            const uint32_t below = i + SEGMENTS + 1;
            if (!pointBelow) mesh.indices.emplace_back(i, below, below + 1);
            if (!pointAbove) mesh.indices.emplace_back(i, below + 1, i + 1);
        }
    }
    void addEnd(float y, float outward) {
        const auto first = static_cast<uint32_t>(mesh.positions.size());
        for (uint32_t i = 0; i < SEGMENTS; i++) {
            const vec3 p = around(i, 1.0, y);
            addVertex(p, vec3(0.0f, outward, 0.0f), 0.5f + 0.5f * vec2(outward * p.x, p.z));
        }
        for (uint32_t i = 1; i + 1 < SEGMENTS; i++) {
            if (outward > 0.0f) mesh.indices.emplace_back(first, first + i, first + i + 1);
            else mesh.indices.emplace_back(first, first + i + 1, first + i);
        }
    }
};

void fillSphere(Lathe lathe) {
    for (uint32_t ring = 0; ring <= RINGS; ring++) {
        const double angle = std::numbers::pi * ring / RINGS;
        const double radius = ring == 0 || ring == RINGS ? 0.0 : std::sin(angle);
        for (uint32_t i = 0; i <= SEGMENTS; i++) {
            const vec3 p = Lathe::around(i, radius, std::cos(angle));
            lathe.addVertex(p, p, vec2(float(i) / SEGMENTS, float(ring) / RINGS));
        }
        if (ring > 0) lathe.join(ring == 1, ring == RINGS);
    }
}

void fillCylinder(Lathe lathe, bool capped) {
    for (float y : {1.0f, -1.0f})
        for (uint32_t i = 0; i <= SEGMENTS; i++)
            lathe.addVertex(Lathe::around(i, 1.0, y), Lathe::around(i, 1.0, 0.0), vec2(float(i) / SEGMENTS, 0.5f - 0.5f * y));
    lathe.join(false, false);
    if (!capped) return;
    lathe.addEnd(1.0f, 1.0f);
    lathe.addEnd(-1.0f, -1.0f);
}

void fillSquare(MeshData& mesh) {
    mesh.positions = {{-1, 0, -1}, {-1, 0, 1}, {1, 0, 1}, {1, 0, -1}};
    mesh.normals.assign(4, vec3(0.0f, 1.0f, 0.0f));
    mesh.indices = {{0, 1, 2}, {0, 2, 3}};
}

Placement changed(const dmat3& linear, dvec3 offset) {
    Placement placement = placementOf(linear, offset);
    placement.identity = false;
    return placement;
}

/// The anchor on the rim, where that is the point nearest the world's origin.
ShapeSpace spaceOfBall(const Placement& placement) {
    ShapeSpace space{placement};
    const dmat3 inverse = glm::transpose(placement.cofactor) / placement.determinant;
    const dvec3 toOrigin = inverse * -placement.offset;
    const double distance = glm::length(toOrigin);
    if (!(distance > 0.0) || !std::isfinite(distance)) return space;
    const dvec3 up = toOrigin / distance, radius = placement.linear * up, rim = placement.offset + radius;
    if (glm::length(rim) > NEAR_RIM * glm::length(radius)) return space;
    const dvec3 axis = glm::cross(dvec3(0.0, 1.0, 0.0), up);
    const glm::dquat half(1.0 + up.y, axis.x, axis.y, axis.z);
    const glm::dquat turn = glm::length(half) > 1e-9 ? glm::normalize(half) : glm::dquat(0.0, 1.0, 0.0, 0.0);
    space.placement = changed(placement.linear * glm::mat3_cast(turn), rim);
    space.flags |= SHAPE_POLE;
    space.extra = vec3(dvec3(turn.x, turn.y, turn.z));
    return space;
}

/// A square about the point that is nearest the world's origin.
ShapeSpace spaceOfPlane(const Placement& placement, double reach) {
    const dvec3 normal = placement.normal(vec3(0.0f, 1.0f, 0.0f)), middle = normal * glm::dot(placement.offset, normal);
    const double scale = reach / glm::length(placement.linear[0]);
    ShapeSpace space{changed(dmat3(placement.linear[0] * scale, normal, placement.linear[2] * scale), middle)};
    const dmat3 inverse = glm::transpose(placement.cofactor) / placement.determinant;
    const dvec3 place = inverse * (middle - placement.offset);
    space.extra = vec3(dvec3(scale, place.x, place.z));
    return space;
}

}  // namespace

MeshData shapeMesh(ShapeForm form, uint32_t material) {
    MeshData mesh;
    mesh.shape = form;
    if (form.kind == SHAPE_SPHERE) fillSphere({mesh});
    if (form.kind == SHAPE_CYLINDER) fillCylinder({mesh}, form.capped);
    if (form.kind == SHAPE_DISC) Lathe{mesh}.addEnd(0.0f, 1.0f);
    if (form.kind == SHAPE_PLANE) fillSquare(mesh);
    mesh.materials.assign(mesh.indices.size(), material);
    return mesh;
}

void growByShapes(Scene& scene, std::span<const PlacedShape> shapes, std::span<const PlacedShape> planes) {
    std::vector<Bounds> boxes;
    for (const PlacedShape& shape : shapes) boxes.push_back(shape.bounds);
    const auto sizeOf = [](const Bounds& box) { return glm::length(dvec3(box.high) - dvec3(box.low)); };
    std::ranges::sort(boxes, {}, sizeOf);
    for (const Bounds& box : boxes) {
        if (scene.bounds.empty() || sizeOf(box) <= LARGEST_SHAPE * sizeOf(scene.bounds))
            scene.bounds.grow(box.low), scene.bounds.grow(box.high);
        const vec3 reach = glm::max(glm::abs(box.low), glm::abs(box.high));
        scene.farthestSurface = std::max(scene.farthestSurface, reach.x + reach.y + reach.z);
    }
    if (!scene.bounds.empty() || planes.empty()) return;
    scene.bounds.grow(vec3(planes.front().placement.offset) - 1.0f);
    scene.bounds.grow(vec3(planes.front().placement.offset) + 1.0f);
}

ShapeSpace shapeSpaceOf(ShapeForm form, const Placement& placement, double reach) {
    ShapeSpace space = form.kind == SHAPE_SPHERE  ? spaceOfBall(placement)
                       : form.kind == SHAPE_PLANE ? spaceOfPlane(placement, reach)
                                                  : ShapeSpace{placement};
    space.flags |= form.kind * SHAPE_KIND;
    if (form.capped) space.flags |= SHAPE_CAPPED;
    return space;
}

}  // namespace heliograph
