#include "server/scene/build/scene_checks.h"

#include "server/scene/build/default_camera.h"
#include "server/scene/build/transform.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace heliograph {

namespace {

constexpr float FARTHEST_LIGHT = 1e18f;  // squared distances are floats

/// Clamps, and counts what was not a number or out of range.
class Repair {
public:
    void number(float& value, float low, float high, float neutral) {
        const float before = value;
        value = std::isfinite(value) ? std::clamp(value, low, high) : neutral;
        if (!(before == value)) count++;
    }
    void color(vec4& value, float high, float neutral) {
        for (int i = 0; i < 3; i++) number(value[i], 0.0f, high, neutral);
        if (!std::isfinite(value.w)) value.w = 0.0f;
    }
    void texture(uint32_t& index, size_t textures) {
        if (index == NO_INDEX || index < textures) return;
        index = NO_INDEX;
        count++;
    }
    int count = 0;
};

int repairMaterial(Material& m, size_t textures) {
    Repair repair;
    repair.number(m.baseColor.w, 0.0f, 1.0f, 1.0f);
    repair.color(m.baseColor, 1e6f, 1.0f);
    repair.color(m.emission, 1e9f, 0.0f);
    repair.number(m.specular.w, 0.0f, 1e5f, 0.0f);
    repair.color(m.specular, 1e6f, 0.0f);
    repair.color(m.absorption, 1e9f, 0.0f);
    repair.color(m.transmissionTint, 1e6f, 1.0f);
    repair.number(m.metallic, 0.0f, 1.0f, 0.0f);
    repair.number(m.roughness, 0.0f, 1.0f, 1.0f);
    repair.number(m.transmission, 0.0f, 1.0f, 0.0f);
    if (m.ior != 0.0f) repair.number(m.ior, 1e-3f, 1e6f, 1.5f);  // 0 means: reflects everything
    repair.number(m.mirror, 0.0f, 1.0f, 0.0f);
    repair.number(m.alphaCutoff, 0.0f, 1e6f, 0.5f);
    repair.number(m.normalScale, -1e3f, 1e3f, 1.0f);
    repair.number(m.occlusionStrength, 0.0f, 1.0f, 1.0f);
    for (uint32_t* index : {&m.baseTexture, &m.metallicRoughnessTexture, &m.normalTexture, &m.emissionTexture,
                            &m.opacityTexture, &m.transmissionTexture, &m.specularTexture, &m.occlusionTexture}) {
        repair.texture(*index, textures);
    }
    return repair.count;
}

int repairLayers(MaterialLayers& l, size_t textures) {
    Repair repair;
    for (float* share : {&l.coat, &l.coatRoughness, &l.sheenRed, &l.sheenGreen, &l.sheenBlue, &l.sheenRoughness, &l.anisotropy,
                         &l.iridescence, &l.diffuseTransmission})
        repair.number(*share, 0.0f, 1.0f, 0.0f);
    for (float* color : {&l.diffuseRed, &l.diffuseGreen, &l.diffuseBlue}) repair.number(*color, 0.0f, 1.0f, 1.0f);
    for (float* turn : {&l.anisotropyCosine, &l.anisotropySine}) repair.number(*turn, -1.0f, 1.0f, 0.0f);
    repair.number(l.coatNormalScale, -1e3f, 1e3f, 1.0f);
    repair.number(l.filmIor, 1.0f, 10.0f, 1.3f);
    repair.number(l.filmThinnest, 0.0f, 1e5f, 100.0f);
    repair.number(l.filmThickest, 0.0f, 1e5f, 400.0f);
    repair.number(l.dispersion, 0.0f, 20.0f, 0.0f);
    for (uint32_t* index : {&l.coatTexture, &l.coatRoughnessTexture, &l.coatNormalTexture, &l.sheenColorTexture,
                            &l.sheenRoughnessTexture, &l.anisotropyTexture, &l.iridescenceTexture, &l.filmThicknessTexture,
                            &l.diffuseTransmissionTexture, &l.diffuseColorTexture})
        repair.texture(*index, textures);
    l.sheenTable = NO_INDEX;
    return repair.count;
}

bool repairLight(Light& light) {
    if (!finite(light.position) || !finite(light.direction) || !finite(light.intensity)) return false;
    for (int i = 0; i < 3; i++) {
        if (std::abs(light.position[i]) > FARTHEST_LIGHT || std::abs(light.edge[i]) > FARTHEST_LIGHT) return false;
    }
    if (!std::isfinite(light.range) || light.range < 0.0f) light.range = 0.0f;
    if (light.type > LIGHT_QUAD || light.falloff > FALLOFF_LINEAR) return false;
    if (!(light.radius >= 0.0f && light.radius <= FARTHEST_LIGHT) || light.type == LIGHT_HEADLIGHT || light.type == LIGHT_QUAD)
        light.radius = 0.0f;
    if (light.type == LIGHT_QUAD) {
        if (!finite(light.edge) || !(glm::length(light.edge) > 0.0f)) return false;
        if (!std::isfinite(light.aspect) || light.aspect < 0.0f) light.aspect = 0.0f;
    }
    light.intensity = glm::max(light.intensity, vec3(0.0f));
    const float length = glm::length(light.direction);
    if (length > 0.0f && std::isfinite(length)) {
        light.direction /= length;
    } else if (light.type == LIGHT_SPOT || light.type == LIGHT_DIRECTIONAL || light.type == LIGHT_QUAD) {
        return false;
    } else {
        light.direction = vec3(0.0f, -1.0f, 0.0f);
    }
    if (!std::isfinite(light.cosInner)) light.cosInner = 1.0f;
    if (!std::isfinite(light.cosOuter)) light.cosOuter = 0.0f;
    light.cosOuter = std::clamp(light.cosOuter, -1.0f, 1.0f);
    light.cosInner = std::clamp(light.cosInner, light.cosOuter, 1.0f);
    return true;
}

bool inside(const Bounds& range, vec3 p) {
    return glm::all(glm::lessThanEqual(range.low, p)) && glm::all(glm::lessThanEqual(p, range.high));
}

std::string shown(vec3 v) {
    std::ostringstream text;
    text << "[" << v.x << ", " << v.y << ", " << v.z << "]";
    return text.str();
}

constexpr float NARROWEST = 0.01f, WIDEST = 179.0f;  // degrees

bool repairCamera(NamedCamera& camera) {
    const float length = glm::length(camera.forward);
    if (!finite(camera.position) || !(length > 1e-12f) || !std::isfinite(length)) return false;
    camera.forward /= length;
    vec3 up = finite(camera.up) ? camera.up : vec3(0.0f, 1.0f, 0.0f);
    up -= camera.forward * glm::dot(camera.forward, up);
    if (!(glm::length(up) > 1e-6f)) {
        const vec3 other = std::abs(camera.forward.y) < 0.9f ? vec3(0.0f, 1.0f, 0.0f) : vec3(0.0f, 0.0f, -1.0f);
        up = other - camera.forward * glm::dot(camera.forward, other);
    }
    camera.up = glm::normalize(up);
    camera.fieldOfView = std::isfinite(camera.fieldOfView) ? std::clamp(camera.fieldOfView, NARROWEST, WIDEST) : 60.0f;
    return true;
}

template <typename T, typename Keep>
size_t dropUnless(std::vector<T>& items, const Keep& keep) {
    const size_t before = items.size();
    items.erase(std::remove_if(items.begin(), items.end(), [&](T& item) { return !keep(item); }), items.end());
    return before - items.size();
}

}  // namespace

void checkMaterials(SceneDraft& draft) {
    Scene& scene = draft.scene;
    for (TextureSlot& slot : scene.textures) {
        if (!finite(slot.transform)) slot.transform = vec4(1.0f, 0.0f, 0.0f, 1.0f);
        if (!finite(slot.offset)) slot.offset = vec2(0.0f);
        slot.uvSet = std::min(slot.uvSet, 1u);
        if (slot.wrapU > WRAP_MIRROR) slot.wrapU = WRAP_REPEAT;
        if (slot.wrapV > WRAP_MIRROR) slot.wrapV = WRAP_REPEAT;
    }
    for (size_t i = 0; i < scene.materials.size(); i++) {
        Material& material = scene.materials[i];
        int repaired = repairMaterial(material, scene.textures.size());
        if (material.layers >= draft.layers.size()) material.layers = NO_INDEX;
        if (material.layers != NO_INDEX) repaired += repairLayers(draft.layers[material.layers], scene.textures.size());
        if (repaired > 0) {
            addWarning(draft, "material '" + scene.materialNames[i] + "': " + std::to_string(repaired) +
                                  " values out of range were clamped");
        }
    }
}

void checkLights(SceneDraft& draft) {
    const size_t dropped = dropUnless(draft.lights, repairLight);
    if (dropped > 0)
        addWarning(draft, std::to_string(dropped) + " lights were left out: not finite, without direction or beyond 1e18");
    // What a light of a unit scene may have, carried over by the inverse square; more would leave float on the way to a pixel.
    const double reach = std::max(1.0, static_cast<double>(draft.scene.bounds.radius()));
    const auto strongest = static_cast<float>(std::min(1e12 * reach * reach, 1e36));
    size_t weakened = 0;
    for (Light& light : draft.lights) {
        weakened += glm::any(glm::greaterThan(light.intensity, vec3(strongest)));
        light.intensity = glm::min(light.intensity, vec3(strongest));
    }
    if (weakened > 0) addWarning(draft, fmt::format("{} lights were stronger than {:g}: drawn with that", weakened, strongest));
}

void placeParallelCameras(SceneDraft& draft) {
    for (NamedCamera& camera : draft.scene.cameras) {
        const float halfHeight = halfHeightOf(camera);
        if (!(halfHeight > 0.0f) || !repairCamera(camera)) continue;  // checkCameras drops what cannot be repaired
        const bool behind = hasSomethingBehind(camera, draft.scene.bounds);
        camera = cameraFromAfar(camera, halfHeight, draft.scene.bounds);
        addWarning(draft, "camera '" + camera.name + "' has a parallel projection: drawn from afar" +
                              (behind ? "; what stands behind it hides what it looks at" : ""));
    }
}

void checkCameras(SceneDraft& draft) {
    for (const NamedCamera& camera : draft.scene.cameras) {
        if (camera.fieldOfView >= NARROWEST && camera.fieldOfView <= WIDEST) continue;
        addWarning(draft, "camera '" + camera.name + "' has a field of view of " + std::to_string(camera.fieldOfView) +
                              " degrees; drawn: the nearest of " + std::to_string(NARROWEST) + " to " + std::to_string(WIDEST));
    }
    const size_t dropped = dropUnless(draft.scene.cameras, repairCamera);
    if (dropped > 0) addWarning(draft, std::to_string(dropped) + " cameras were left out: not finite or without direction");
    const Bounds range = draft.scene.cameraRange();
    dropUnless(draft.scene.cameras, [&](const NamedCamera& camera) {
        if (inside(range, camera.position)) return true;
        addWarning(draft, "camera '" + camera.name + "' was left out: position " + shown(camera.position) +
                              "; allowed: " + shown(range.low) + " to " + shown(range.high));
        return false;
    });
    const size_t paths = dropUnless(draft.scene.paths, [&](const CameraPath& path) {
        return path.keys.size() >= 2 && path.seconds > 0.0f && std::isfinite(path.seconds) &&
               std::all_of(path.keys.begin(), path.keys.end(), [&](const CameraPath::Key& key) {
                   return inside(range, key.position) && inside(range, key.target);
               });
    });
    if (paths > 0)
        addWarning(draft, std::to_string(paths) + " camera paths were left out: fewer than 2 keys, not finite or too far away");
}

}  // namespace heliograph
