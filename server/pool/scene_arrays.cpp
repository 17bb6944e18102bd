#include "server/pool/scene_arrays.h"

#include "server/pool/wire/bytes.h"

#include <algorithm>

namespace heliograph {

namespace {

void expect(bool sound) {
    if (!sound) throw PoolMessageError("is a scene whose arrays do not fit together");
}

/// [first, first + count) lies within an array of that size.
bool within(uint32_t first, uint32_t count, size_t size) { return static_cast<uint64_t>(first) + count <= size; }

bool among(uint32_t index, size_t size) { return index == NO_INDEX || index < size; }

void checkGeometry(const Scene& scene) {
    const size_t vertices = std::min(scene.positions.size(), scene.attributes.size());
    for (const uvec4& triangle : scene.triangles) {
        expect(std::max({triangle.x, triangle.y, triangle.z}) < vertices && triangle.w < scene.materials.size());
    }
    expect(scene.positions.size() > scene.attributes.size() || scene.triangles.empty());  // the padding
    expect(scene.tangents.empty() || scene.tangents.size() >= vertices);
    for (const Mesh& mesh : scene.meshes) {
        expect(within(mesh.firstTriangle, mesh.triangleCount, scene.triangles.size()));
        expect(within(mesh.firstVertex, mesh.vertexCount, vertices));
    }
    for (const Instance& instance : scene.instances) {
        expect(instance.mesh < scene.meshes.size());
        expect(instance.firstTriangle == scene.meshes[instance.mesh].firstTriangle);
        // Where a ray enters and where it leaves a shape are two numbers of triangles.
        expect((instance.flags & INSTANCE_SHAPE) == 0 || scene.meshes[instance.mesh].triangleCount >= 2);
    }
}

void checkImages(const Scene& scene) {
    for (const TextureSlot& texture : scene.textures) expect(texture.image < scene.images.size());
    for (const Image& image : scene.images) expect(within(image.firstLevel, image.levelCount, scene.imageLevels.size()));
    for (const ImageLevel& level : scene.imageLevels) {
        const uint64_t texels = static_cast<uint64_t>(level.width) * level.height;
        expect(texels <= scene.texels.size() && level.firstTexel <= scene.texels.size() - texels);
    }
    for (const Material& m : scene.materials) {
        for (uint32_t texture : {m.baseTexture, m.metallicRoughnessTexture, m.normalTexture, m.emissionTexture,
                                 m.opacityTexture, m.transmissionTexture, m.specularTexture, m.occlusionTexture})
            expect(among(texture, scene.textures.size()));
    }
    const auto expectImages = [&](const Environment& environment) {
        expect(among(environment.image, scene.images.size()));
        expect(among(environment.filtered, scene.images.size()));
    };
    expectImages(scene.environment);
    for (const Environment& offered : scene.offered) expectImages(offered);
    expect(scene.offered.empty() || scene.offered.size() == 2);
}

}  // namespace

void checkSceneArrays(const Scene& scene) {
    checkGeometry(scene);
    checkImages(scene);
    expect(scene.environment.listedLights <= scene.lights.size());
}

}  // namespace heliograph
