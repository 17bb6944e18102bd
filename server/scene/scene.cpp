#include "server/scene/scene.h"

#include <algorithm>

namespace heliograph {

Bounds Scene::cameraRange() const {
    constexpr float RADII = 1e4f, LEAST = 1e4f, FARTHEST = 1e17f;
    const vec3 reach(std::max(RADII * bounds.radius(), LEAST));
    const vec3 center = bounds.empty() ? vec3(0.0f) : bounds.center();
    Bounds range;
    range.low = glm::clamp(center - reach, vec3(-FARTHEST), vec3(FARTHEST));
    range.high = glm::clamp(center + reach, vec3(-FARTHEST), vec3(FARTHEST));
    return range;
}

float Scene::rayReach() const {
    Bounds range = cameraRange();
    if (!bounds.empty()) range.grow(bounds.low), range.grow(bounds.high);
    const vec3 farthest = glm::max(glm::abs(range.low), glm::abs(range.high));
    return std::max(farthest.x + farthest.y + farthest.z, farthestSurface);
}

uint64_t Scene::triangleCount() const {
    uint64_t count = 0;
    for (const Instance& instance : instances)
        if ((instance.flags & INSTANCE_SHAPE) == 0) count += meshes[instance.mesh].triangleCount;
    return count;
}

namespace {

template <typename T>
uint64_t bytesOf(const std::vector<T>& array) {
    return array.size() * sizeof(T);
}

}  // namespace

uint64_t Scene::bytes() const {
    return bytesOf(positions) + bytesOf(attributes) + bytesOf(tangents) + bytesOf(triangles) + bytesOf(meshes) +
           bytesOf(instances) + bytesOf(materials) + bytesOf(textures) + bytesOf(images) + bytesOf(imageLevels) +
           bytesOf(texels) + bytesOf(lights) + sizeof(Environment);
}

}  // namespace heliograph
