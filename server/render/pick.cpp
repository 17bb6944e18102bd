#include "server/render/pick.h"

#include <cmath>
#include <limits>

namespace heliograph {

namespace {

using glm::dvec3;

struct PickRay {
    dvec3 origin, direction;
};

/// Smallest box around a mesh's vertices.
struct Box {
    dvec3 low{std::numeric_limits<double>::infinity()}, high{-std::numeric_limits<double>::infinity()};
};

Box boxOf(const Scene& scene, const Mesh& mesh) {
    Box box;
    for (uint32_t v = mesh.firstVertex; v < mesh.firstVertex + mesh.vertexCount; v++) {
        box.low = glm::min(box.low, dvec3(scene.positions[v]));
        box.high = glm::max(box.high, dvec3(scene.positions[v]));
    }
    return box;
}

/// A plane through the box counts as in the way; comparisons are written so that 0 * infinity does not hide it.
bool inTheWay(const Box& box, const PickRay& ray, double nearest) {
    double first = 0.0, last = nearest;
    for (int axis = 0; axis < 3; axis++) {
        const double inverse = 1.0 / ray.direction[axis];
        double a = (box.low[axis] - ray.origin[axis]) * inverse, b = (box.high[axis] - ray.origin[axis]) * inverse;
        if (b < a) std::swap(a, b);
        if (a > first) first = a;
        if (b < last) last = b;
    }
    return !(first > last);
}

PickRay inObject(const Instance& instance, const PickRay& ray) {
    if (instance.flags & INSTANCE_IDENTITY) return ray;
    auto row = [](vec4 r, dvec3 p, double w) { return r.x * p.x + r.y * p.y + r.z * p.z + r.w * w; };
    auto apply = [&](dvec3 p, double w) {
        return dvec3(row(instance.toObject0, p, w), row(instance.toObject1, p, w), row(instance.toObject2, p, w));
    };
    return {apply(ray.origin, 1.0), apply(ray.direction, 0.0)};
}

/// The distance in units of the direction's length; `nearest` where it is missed or farther.
double meet(const Scene& scene, uvec4 corners, const PickRay& ray, double nearest) {
    const dvec3 a(scene.positions[corners.x]), b(scene.positions[corners.y]), c(scene.positions[corners.z]);
    const dvec3 ab = b - a, ac = c - a, p = glm::cross(ray.direction, ac);
    const double determinant = glm::dot(ab, p);
    if (determinant == 0.0) return nearest;
    const dvec3 from = ray.origin - a;
    const double u = glm::dot(from, p) / determinant;
    const dvec3 q = glm::cross(from, ab);
    const double v = glm::dot(ray.direction, q) / determinant;
    const double t = glm::dot(ac, q) / determinant;
    const bool hit = u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 && t < nearest;
    return hit ? t : nearest;
}

}  // namespace

std::optional<double> depthAt(const Scene& scene, const Camera& camera, double aspect, double x, double y) {
    const double half = std::tan(0.5 * glm::radians(static_cast<double>(camera.fieldOfView)));
    const dvec3 forward(camera.forward), up(camera.up), right = glm::cross(forward, up);
    // The component along `forward` is 1, so distances are depths.
    const PickRay ray{dvec3(camera.position), forward + right * (half * aspect * (2.0 * x - 1.0)) + up * (half * (1.0 - 2.0 * y))};
    std::vector<std::optional<Box>> boxes(scene.meshes.size());
    double nearest = std::numeric_limits<double>::infinity();
    for (const Instance& instance : scene.instances) {
        const Mesh& mesh = scene.meshes[instance.mesh];
        if (!boxes[instance.mesh]) boxes[instance.mesh] = boxOf(scene, mesh);
        const PickRay local = inObject(instance, ray);
        if (!inTheWay(*boxes[instance.mesh], local, nearest)) continue;
        for (uint32_t t = 0; t < mesh.triangleCount; t++) {
            nearest = meet(scene, scene.triangles[mesh.firstTriangle + t], local, nearest);
        }
    }
    if (!std::isfinite(nearest)) return std::nullopt;
    return nearest;
}

}  // namespace heliograph
