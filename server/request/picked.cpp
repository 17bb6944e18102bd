#include "server/request/picked.h"

#include "server/scene/shape.h"

namespace heliograph {

namespace {

using glm::dvec3;
using glm::dvec4;

dvec3 placed(const Instance& instance, vec4 position) {
    const dvec4 p(dvec3(vec3(position)), 1.0);
    return {glm::dot(dvec4(instance.toWorld0), p), glm::dot(dvec4(instance.toWorld1), p),
            glm::dot(dvec4(instance.toWorld2), p)};
}

/// Unit, against the ray; 0 for a triangle without area.
dvec3 normalOf(const Scene& scene, const Instance& instance, uvec4 triangle, dvec3 along) {
    const dvec3 a = placed(instance, scene.positions[triangle.x]), b = placed(instance, scene.positions[triangle.y]),
                c = placed(instance, scene.positions[triangle.z]);
    const dvec3 normal = glm::cross(b - a, c - a);
    const double length = glm::length(normal);
    if (!(length > 0.0)) return dvec3(0.0);
    return normal * ((glm::dot(normal, along) > 0.0 ? -1.0 : 1.0) / length);
}

}  // namespace

Picked pickedAt(const Scene& scene, const ViewRay& ray, double depth, uint32_t instance, uint32_t triangle) {
    Picked picked;
    picked.depth = depth;
    picked.distance = depth * glm::length(ray.direction);
    picked.position = ray.origin + depth * ray.direction;
    if (instance >= scene.instances.size()) return picked;
    const Instance& met = scene.instances[instance];
    if (triangle >= scene.meshes[met.mesh].triangleCount) return picked;
    const uint32_t index = met.firstTriangle + triangle;
    const uvec4 corners = scene.triangles[index];
    picked.object = scene.objects.of(instance, index);
    if (corners.w < scene.materialNames.size()) picked.material = scene.materialNames[corners.w];
    if (isShape(met)) {
        const dvec3 outward = shapeNormal(met, picked.position);
        picked.normal = glm::dot(outward, ray.direction) > 0.0 ? -outward : outward;
    } else {
        picked.normal = normalOf(scene, met, corners, ray.direction);
    }
    return picked;
}

}  // namespace heliograph
