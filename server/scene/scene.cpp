#include "server/scene/scene.h"

namespace heliograph {

uint64_t Scene::triangleCount() const {
    uint64_t count = 0;
    for (const Instance& instance : instances) count += meshes[instance.mesh].triangleCount;
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
