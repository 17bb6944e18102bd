#include "tests/support/test_scenes.h"

namespace heliograph::test {

MeshData square(uint32_t material) {
    MeshData mesh;
    mesh.positions = {{-1.0f, -1.0f, 0.0f}, {1.0f, -1.0f, 0.0f}, {1.0f, 1.0f, 0.0f}, {-1.0f, 1.0f, 0.0f}};
    mesh.uv0 = {{0.0f, 1.0f}, {1.0f, 1.0f}, {1.0f, 0.0f}, {0.0f, 0.0f}};
    mesh.indices = {{0, 1, 2}, {0, 2, 3}};
    mesh.materials = {material, material};
    return mesh;
}

SceneBuilder litBuilder(const std::string& name) {
    SceneBuilder builder(name);
    Light light{};
    light.type = LIGHT_DIRECTIONAL;
    light.direction = vec3(0.0f, 0.0f, -1.0f);
    light.intensity = vec3(1.0f);
    builder.addLight(light);
    return builder;
}

std::shared_ptr<const Scene> squareScene(const std::function<void(Material&)>& change, const std::string& name) {
    SceneBuilder builder = litBuilder();
    Material material = SceneBuilder::defaultMaterial();
    if (change) change(material);
    builder.addInstance(builder.addMesh(square(builder.addMaterial(material, name))), mat4(1.0f));
    return builder.finish();
}

}  // namespace heliograph::test
