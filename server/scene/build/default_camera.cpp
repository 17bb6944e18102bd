#include "server/scene/build/default_camera.h"

#include "server/scene/framing.h"
#include "server/scene/shape.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace heliograph {

namespace {

using glm::dvec3;

constexpr uint64_t MOST_TESTED_TRIANGLES = 4'000'000;
constexpr float ROOM_FIELD_OF_VIEW = 60.0f;    // degrees
constexpr float OBJECT_FIELD_OF_VIEW = 40.0f;  // as a lens of 50 mm, with which near parts look no larger than they are

dvec3 toWorld(const Instance& m, const vec4& p) {
    return dvec3(m.toWorld0.x * p.x + m.toWorld0.y * p.y + m.toWorld0.z * p.z + m.toWorld0.w,
                 m.toWorld1.x * p.x + m.toWorld1.y * p.y + m.toWorld1.z * p.z + m.toWorld1.w,
                 m.toWorld2.x * p.x + m.toWorld2.y * p.y + m.toWorld2.z * p.z + m.toWorld2.w);
}

/// Nearest surface that a ray meets.
struct Nearest {
    double distance = std::numeric_limits<double>::infinity();
    bool facesOrigin = false;
};

/// Moeller & Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection" (1997).
double hitDistance(dvec3 origin, dvec3 direction, dvec3 a, dvec3 edge1, dvec3 edge2) {
    const dvec3 p = glm::cross(direction, edge2);
    const double det = glm::dot(edge1, p);
    if (det == 0.0) return -1.0;
    const dvec3 s = origin - a;
    const double u = glm::dot(s, p) / det;
    if (!(u >= 0.0 && u <= 1.0)) return -1.0;
    const dvec3 q = glm::cross(s, edge1);
    const double v = glm::dot(direction, q) / det;
    return v >= 0.0 && u + v <= 1.0 ? glm::dot(edge2, q) / det : -1.0;
}

Nearest traceAll(const Scene& scene, dvec3 origin, dvec3 direction) {
    Nearest nearest;
    for (const Instance& instance : scene.instances) {
        const Mesh& mesh = scene.meshes[instance.mesh];
        const bool mirrored = (instance.flags & INSTANCE_MIRRORED) != 0;
        for (uint32_t i = mesh.firstTriangle; i < mesh.firstTriangle + mesh.triangleCount; i++) {
            const uvec4 t = scene.triangles[i];
            const dvec3 a = toWorld(instance, scene.positions[t.x]);
            const dvec3 edge1 = toWorld(instance, scene.positions[t.y]) - a;
            const dvec3 edge2 = toWorld(instance, scene.positions[t.z]) - a;
            const double distance = hitDistance(origin, direction, a, edge1, edge2);
            if (!(distance > 0.0) || distance >= nearest.distance) continue;
            nearest.distance = distance;
            nearest.facesOrigin = (glm::dot(glm::cross(edge1, edge2), direction) < 0.0) != mirrored;
        }
    }
    return nearest;
}

/// How many of RAYS rays meet a surface that faces their origin: from the middle outwards, around the horizon and below
/// (a courtyard has no roof), or from outside to the middle.
constexpr int RAYS = 20;
int facingSurfaces(const Scene& scene, dvec3 center, bool fromOutside) {
    const double far = 4.0 * scene.bounds.radius();
    std::array<bool, RAYS> faces{};
    tbb::parallel_for(0, RAYS, [&](int i) {
        const double azimuth = 2.0 * std::numbers::pi * (i + 0.3) / RAYS;
        const double rise = fromOutside ? 0.2 : i % 2 == 0 ? 0.1 : -0.4;
        const dvec3 direction = glm::normalize(dvec3(std::cos(azimuth), rise, std::sin(azimuth)));
        faces[i] = fromOutside ? traceAll(scene, center + direction * far, -direction).facesOrigin
                               : traceAll(scene, center, direction).facesOrigin;
    });
    return static_cast<int>(std::count(faces.begin(), faces.end(), true));
}

/// Walls all around, and either as large as a building (metres) or no outside to look at: a helmet has walls, too.
bool looksLikeRoom(const Scene& scene, dvec3 center) {
    if (scene.triangleCount() > MOST_TESTED_TRIANGLES || scene.instances.size() > 10'000) return false;
    if (facingSurfaces(scene, center, false) < RAYS * 17 / 20) return false;
    return scene.bounds.radius() > 4.0f || facingSurfaces(scene, center, true) < RAYS / 2;
}

/// Of the vertices that triangles use, wherever they are placed.
Framing framingOf(const Scene& scene, dvec3 center, const NamedCamera& view) {
    FramingWriter writer(center, view);
    for (const Instance& instance : scene.instances) {
        if (isShape(instance) && shapeKindOf(instance) == SHAPE_PLANE) continue;  // it has no end
        const Mesh& mesh = scene.meshes[instance.mesh];
        const auto part = [&](const tbb::blocked_range<uint32_t>& range, FramingWriter found) {
            for (uint32_t i = range.begin(); i < range.end(); i++) found.add(toWorld(instance, scene.positions[i]));
            return found;
        };
        const auto both = [](FramingWriter a, const FramingWriter& b) {
            a.add(b);
            return a;
        };
        const tbb::blocked_range<uint32_t> vertices(mesh.firstVertex, mesh.firstVertex + mesh.vertexCount, 4096);
        writer.add(tbb::parallel_reduce(vertices, FramingWriter(center, view), part, both));
    }
    return writer.framing();
}

}  // namespace

NamedCamera defaultCamera(const Scene& scene, std::optional<Framing>& framing) {
    NamedCamera camera;
    camera.name = "default";
    const dvec3 low(scene.bounds.low), high(scene.bounds.high);
    const dvec3 size = high - low;
    const dvec3 center = 0.5 * (low + high);
    const dvec3 eye(center.x, low.y + 0.3 * size.y, center.z);
    if (looksLikeRoom(scene, eye)) {
        const dvec3 along = size.x >= size.z ? dvec3(1.0, 0.0, 0.0) : dvec3(0.0, 0.0, 1.0);
        const Nearest behind = traceAll(scene, eye, along);
        const double back = std::min(behind.distance, 0.5 * glm::dot(size, along)) * 0.65;
        camera.position = vec3(eye + along * back);
        camera.forward = vec3(dvec3(0.0) - along);
        camera.fieldOfView = ROOM_FIELD_OF_VIEW;
        return camera;
    }
    const dvec3 right = glm::normalize(glm::cross(-DEFAULT_VIEW, dvec3(0.0, 1.0, 0.0)));
    camera.forward = vec3(-DEFAULT_VIEW);
    camera.up = vec3(glm::cross(right, -DEFAULT_VIEW));
    camera.fieldOfView = OBJECT_FIELD_OF_VIEW;
    const bool visible = !scene.bounds.empty() && std::ranges::any_of(scene.instances, [&](const Instance& i) {
        return scene.meshes[i.mesh].vertexCount > 0;
    });
    if (!visible) {
        camera.position = vec3(DEFAULT_VIEW);
        return camera;
    }
    framing = framingOf(scene, center, camera);
    const NamedCamera fitted = framed(*framing, camera, USUAL_ASPECT);
    if (std::isfinite(fitted.position.x + fitted.position.y + fitted.position.z)) return fitted;
    framing.reset();  // planes alone: nothing that could be fitted
    camera.position = vec3(center + DEFAULT_VIEW * (3.0 * scene.bounds.radius()));
    return camera;
}

NamedCamera cameraFromAfar(const NamedCamera& parallel, float halfHeight, const Bounds& bounds) {
    constexpr double NARROWEST = 0.0101;  // degrees; a camera may have 0.01
    const dvec3 forward(parallel.forward), position(parallel.position);
    const dvec3 middle = bounds.empty() ? position : 0.5 * (dvec3(bounds.low) + dvec3(bounds.high));
    const double radius = std::max(bounds.empty() ? 0.0 : double(bounds.radius()), double(halfHeight));
    const double farthest = halfHeight / std::tan(0.5 * NARROWEST * std::numbers::pi / 180.0);
    const double distance = std::min(AFAR * radius, farthest);
    NamedCamera camera = parallel;
    camera.position = vec3(position + forward * (glm::dot(middle - position, forward) - distance));
    camera.fieldOfView = static_cast<float>(2.0 * std::atan(halfHeight / distance) * 180.0 / std::numbers::pi);
    return camera;
}

bool hasSomethingBehind(const NamedCamera& camera, const Bounds& bounds) {
    if (bounds.empty()) return false;
    const dvec3 half = 0.5 * (dvec3(bounds.high) - dvec3(bounds.low));
    const dvec3 forward(camera.forward);
    const double middle = glm::dot(dvec3(bounds.low) + half - dvec3(camera.position), forward);
    return middle - glm::dot(half, glm::abs(forward)) < -1e-4 * glm::length(half);
}

}  // namespace heliograph
