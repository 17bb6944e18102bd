#include "tests/bench/colonnade.h"

#include <cmath>
#include <functional>

namespace heliograph {

namespace {

constexpr float TURN = 6.28318531f;

// Adds a grid of points over [0, 1]^2 as triangles.
void addGrid(MeshData& mesh, uint32_t columns, uint32_t rows, const std::function<vec3(float, float)>& point) {
    uint32_t first = static_cast<uint32_t>(mesh.positions.size());
    for (uint32_t j = 0; j <= rows; j++)
        for (uint32_t i = 0; i <= columns; i++)
            mesh.positions.push_back(
                point(static_cast<float>(i) / static_cast<float>(columns), static_cast<float>(j) / static_cast<float>(rows)));
    for (uint32_t j = 0; j < rows; j++)
        for (uint32_t i = 0; i < columns; i++) {
            uint32_t a = first + j * (columns + 1) + i, b = a + columns + 1;
            mesh.indices.push_back({a, b, a + 1});
            mesh.indices.push_back({a + 1, b, b + 1});
        }
}

void addColumn(MeshData& mesh, vec3 foot, uint32_t around, uint32_t up) {
    addGrid(mesh, around, up, [&](float u, float v) {
        float flutes = 1.0f - 0.06f * std::abs(std::cos(10.0f * TURN * u));
        float radius =
            0.42f * flutes * (1.0f - 0.15f * v * v) + 0.12f * std::exp(-40.0f * v) + 0.1f * std::exp(-30.0f * (1.0f - v));
        return foot + vec3(radius * std::cos(TURN * u), 5.0f * v, radius * std::sin(TURN * u));
    });
}

void addSphere(MeshData& mesh, vec3 center, float radius, uint32_t around, uint32_t up) {
    addGrid(mesh, around, up, [&](float u, float v) {
        float polar = 0.5f * TURN * std::min(std::max(v, 1e-3f), 1.0f - 1e-3f);
        return center +
               radius * vec3(std::sin(polar) * std::cos(TURN * u), -std::cos(polar), std::sin(polar) * std::sin(TURN * u));
    });
}

}  // namespace

std::shared_ptr<const Scene> makeColonnade(float detail) {
    float edge = std::sqrt(detail);
    auto steps = [&](uint32_t n) { return std::max(4u, static_cast<uint32_t>(static_cast<float>(n) * edge)); };
    SceneBuilder builder("colonnade");
    MeshData mesh;
    for (int i = 0; i < 14; i++)
        for (float side : {-3.0f, 3.0f}) addColumn(mesh, {side, 0.003f, -3.0f * static_cast<float>(i)}, steps(120), steps(102));
    for (int i = 0; i < 34; i++) {
        float z = -1.2f * static_cast<float>(i) - 0.7f;
        float x = 1.9f * std::sin(2.3f * static_cast<float>(i));
        addSphere(mesh, {x, 0.4f + 0.011f, z}, 0.38f, steps(64), steps(32));
    }
    addGrid(mesh, steps(200), steps(200), [](float u, float v) {
        float angle = 0.5f * TURN * u;
        return vec3(3.9f * std::cos(angle), 5.1f + 2.5f * std::sin(angle), 2.0f - 45.0f * v);
    });
    addGrid(mesh, steps(16), steps(16), [](float u, float v) { return vec3(40.0f * (u - 0.5f), 0.0f, 12.0f - 70.0f * v); });
    builder.addInstance(builder.addMesh(std::move(mesh)), mat4(1.0f));
    Light sun{};
    sun.type = LIGHT_DIRECTIONAL;
    sun.direction = glm::normalize(vec3(0.62f, -0.7f, -0.31f));
    sun.intensity = vec3(3.0f);
    builder.addLight(sun);
    builder.setEnvironmentColor(vec3(0.4f, 0.5f, 0.7f));
    NamedCamera camera;
    camera.position = vec3(0.43f, 1.9f, 3.7f);
    camera.forward = glm::normalize(vec3(-0.06f, -0.02f, -1.0f));
    builder.addCamera(camera);
    builder.setAoRadius(5.0f);
    return builder.finish();
}

}  // namespace heliograph
