#include "server/request/effect_rules.h"

#include "server/base/text.h"
#include "server/request/counted.h"
#include "server/scene/material_layers.h"
#include "server/scene/shape.h"

#include <algorithm>
#include <array>
#include <functional>
#include <iterator>
#include <span>

namespace heliograph {

namespace {

/// What of a scene is really there: a material counts when a triangle that is placed at least once has it.
struct Usage {
    const Scene& scene;
    bool lit = false;                   // a surface answers to light
    std::vector<uint64_t> trianglesOf;  // by material, over all instances
    std::vector<bool> coloured;         // by material: a vertex of its triangles is not white
    std::vector<uint8_t> met;           // by material: MET_* bits of the meshes that its triangles are in
    uint64_t triangles = 0;

    static constexpr uint8_t MET_MASKED = 1, MET_TRANSPARENT = 2, MET_TANGENTS = 4;

    explicit Usage(const Scene& s)
        : scene(s), trianglesOf(s.materials.size(), 0), coloured(s.materials.size(), false), met(s.materials.size(), 0) {
        std::vector<uint64_t> uses(s.meshes.size(), 0);
        for (const Instance& instance : s.instances) {
            if (isShape(instance)) add(s.meshes[instance.mesh], 1, 1);
            else uses[instance.mesh]++;
        }
        for (size_t m = 0; m < s.meshes.size(); m++)
            if (uses[m] > 0) add(s.meshes[m], s.meshes[m].triangleCount, uses[m]);
        for (size_t m = 0; m < s.materials.size(); m++)
            lit |= trianglesOf[m] > 0 && (s.materials[m].flags & MATERIAL_UNLIT) == 0;
    }

private:
    void add(const Mesh& mesh, uint32_t count, uint64_t uses) {
        auto white = [&](uint32_t vertex) { return scene.attributes[vertex].color == 0xffffffffu; };
        uint8_t kinds = mesh.hasTangents != 0 ? MET_TANGENTS : 0;
        if (mesh.opacity == OPACITY_MASKED) kinds |= MET_MASKED;
        if (mesh.opacity == OPACITY_TRANSPARENT) kinds |= MET_TRANSPARENT;
        triangles += uses * count;
        for (uint32_t t = 0; t < count; t++) {
            const uvec4 triangle = scene.triangles[mesh.firstTriangle + t];
            trianglesOf[triangle.w] += uses;
            met[triangle.w] |= kinds;
            if (!white(triangle.x) || !white(triangle.y) || !white(triangle.z)) coloured[triangle.w] = true;
        }
    }
};

struct Finding {
    bool calledFor = false;
    std::string because;
    bool choice = false;  // the viewer's
};

/// Called for by the used materials that `wanted` picks; names the first of them, those with most triangles first.
Finding byMaterial(const Usage& usage, const std::string& lack, const std::function<bool(uint32_t)>& wanted) {
    std::vector<uint32_t> found;
    uint64_t triangles = 0;
    for (uint32_t m = 0; m < usage.trianglesOf.size(); m++) {
        if (usage.trianglesOf[m] == 0 || !wanted(m)) continue;
        found.push_back(m);
        triangles += usage.trianglesOf[m];
    }
    if (found.empty()) return {false, lack};
    std::stable_sort(found.begin(), found.end(),
                     [&](uint32_t a, uint32_t b) { return usage.trianglesOf[a] > usage.trianglesOf[b]; });
    constexpr size_t NAMED = 4;
    std::string names;
    for (size_t i = 0; i < std::min(found.size(), NAMED); i++) {
        const std::string& name = usage.scene.materialNames[found[i]];
        names += (i == 0 ? "" : ", ") + (name.empty() ? "material " + std::to_string(found[i]) : name);
    }
    if (found.size() > NAMED) names += ", ...";
    return {true, counted(found.size(), "material") + " (" + names + "), " + counted(triangles, "triangle")};
}

std::vector<uint32_t> textureSlots(const Scene& scene, const Material& m) {
    const MaterialLayers l = layersOf(scene, m);
    return {m.baseTexture,
            m.metallicRoughnessTexture,
            m.normalTexture,
            m.emissionTexture,
            m.opacityTexture,
            m.transmissionTexture,
            m.specularTexture,
            m.occlusionTexture,
            l.coatTexture,
            l.coatRoughnessTexture,
            l.coatNormalTexture,
            l.sheenColorTexture,
            l.sheenRoughnessTexture,
            l.anisotropyTexture,
            l.iridescenceTexture,
            l.filmThicknessTexture,
            l.diffuseTransmissionTexture,
            l.diffuseColorTexture};
}

bool hasTexture(const Scene& scene, const Material& m) {
    auto slots = textureSlots(scene, m);
    return std::any_of(slots.begin(), slots.end(), [](uint32_t slot) { return slot != NO_INDEX; });
}

bool usesSecondUv(const Scene& scene, const Material& m) {
    auto slots = textureSlots(scene, m);
    return std::any_of(slots.begin(), slots.end(),
                       [&](uint32_t slot) { return slot != NO_INDEX && scene.textures[slot].uvSet != 0; });
}

bool lit(const Material& m) { return (m.flags & MATERIAL_UNLIT) == 0; }
bool phong(const Material& m) { return (m.flags & MATERIAL_PHONG) != 0; }

/// Of the texels of a slot's image at full size, `wanted` of one of them; for channels that mean a number (0: red).
bool anyTexel(const Scene& scene, uint32_t texture, const std::function<bool(uint32_t texel)>& wanted) {
    const ImageLevel& level = scene.imageLevels[scene.images[scene.textures[texture].image].firstLevel];
    const uint32_t* first = scene.texels.data() + level.firstTexel;
    return std::any_of(first, first + static_cast<size_t>(level.width) * level.height, wanted);
}

/// The texture may be brighter than black in a colour channel that `mask` picks. Asks the 1x1 level first: a mean that is
/// not black needs no search.
bool notBlack(const Scene& scene, uint32_t texture, uint32_t mask) {
    if (texture == NO_INDEX) return true;
    const Image& image = scene.images[scene.textures[texture].image];
    if (image.format == IMAGE_RGB9E5) mask = 0x07ffffffu;  // the mantissas
    const ImageLevel& last = scene.imageLevels[image.firstLevel + image.levelCount - 1];
    if ((scene.texels[last.firstTexel] & mask) != 0) return true;
    return anyTexel(scene, texture, [mask](uint32_t texel) { return (texel & mask) != 0; });
}

/// Lets light through; a full metal never does.
bool transmits(const Scene& scene, const Material& m) {
    bool metal = !phong(m) && m.metallic >= 1.0f && m.metallicRoughnessTexture == NO_INDEX;
    return lit(m) && m.transmission > 0.0f && !metal && notBlack(scene, m.transmissionTexture, 0xffu);
}

/// Whether some point of the material is smoother than `limit`: roughness is the factor times the green texel.
bool smootherThan(const Scene& scene, const Material& m, float limit) {
    if (m.roughness < limit) return true;
    if (m.metallicRoughnessTexture == NO_INDEX) return false;
    if (scene.images[scene.textures[m.metallicRoughnessTexture].image].format == IMAGE_RGB9E5) return true;
    return anyTexel(scene, m.metallicRoughnessTexture,
                    [&](uint32_t texel) { return m.roughness * static_cast<float>((texel >> 8) & 255u) / 255.0f < limit; });
}

constexpr float LEAST_MIRROR = 0.01f;    // constant reflectance of MTL below which no ray is worth it
constexpr float ROUGHEST_MIRROR = 0.4f;  // material.glsl: traceableShare is 0 from there

bool glows(const Scene& scene, const Material& m) {
    bool factor = m.emission.x > 0.0f || m.emission.y > 0.0f || m.emission.z > 0.0f;
    return factor && notBlack(scene, m.emissionTexture, 0xffffffu);
}

/// A normal or bump image that is seen: unlit surfaces look the same whatever their normal.
bool bumpy(const Material& m) { return m.normalTexture != NO_INDEX && lit(m); }

bool shines(const Light& light) { return light.intensity.x > 0.0f || light.intensity.y > 0.0f || light.intensity.z > 0.0f; }

/// Whether a metallic-roughness material has a specular lobe.
bool specular(const Material& m) {
    bool coloured = m.specular.x > 0.0f || m.specular.y > 0.0f || m.specular.z > 0.0f;
    return m.metallic > 0.0f || (m.ior != 1.0f && coloured && m.specular.w < 1.0f);
}

/// Whether the kernel would follow a mirror ray from it.
bool reflects(const Scene& scene, const Material& m) {
    if (!lit(m)) return false;
    if (m.mirror > LEAST_MIRROR || (m.ior != 1.0f && transmits(scene, m))) return true;
    if (phong(m)) return false;
    const MaterialLayers l = layersOf(scene, m);
    if (l.coat > 0.0f && (l.coatRoughness < ROUGHEST_MIRROR || l.coatRoughnessTexture != NO_INDEX)) return true;
    return specular(m) && smootherThan(scene, m, ROUGHEST_MIRROR);
}

/// Whether it reflects blurred: anything but a mirror.
bool glossy(const Scene& scene, const Material& m) {
    if (!lit(m) || phong(m)) return false;
    const MaterialLayers l = layersOf(scene, m);
    return (l.coat > 0.0f && l.coatRoughness > 0.0f) ||
           (!transmits(scene, m) && (m.roughness > 0.0f || l.anisotropy > 0.0f) && specular(m));
}

/// Something that light falls on.
Finding litSurfaceIn(const Usage& usage) {
    if (usage.triangles == 0) return {false, "no triangles"};
    if (!usage.lit) return {false, "every surface is unlit"};
    return {true, counted(usage.triangles, "triangle")};
}

/// Blended, and somewhere less than solid.
bool blends(const Usage& usage, uint32_t m) {
    return (usage.scene.materials[m].flags & MATERIAL_ALPHA_BLEND) != 0 && (usage.met[m] & Usage::MET_TRANSPARENT) != 0;
}

Finding byItsMaterial(const Usage& usage, const char* lack, const std::function<bool(const Material&)>& wanted) {
    return byMaterial(usage, lack, [&](uint32_t m) { return wanted(usage.scene.materials[m]); });
}

/// What the table names in its column `rule`.
namespace rules {

/// For what is the viewer's choice alone: no scene calls for it, and where there is something to see it can be had.
Finding anywhere(const Usage& usage) {
    if (usage.triangles == 0) return {false, "no triangles"};
    return {false, "the viewer chooses", true};
}

/// The same for what acts on lit surfaces.
Finding onLitSurfaces(const Usage& usage) {
    Finding surface = litSurfaceIn(usage);
    return surface.calledFor ? Finding{false, "the viewer chooses", true} : surface;
}

Finding shadows(const Usage& usage) {
    const Scene& scene = usage.scene;
    const bool sampled = scene.environment.lightColumns > 0 || scene.environment.emitterCount > 0;
    if (scene.lights.empty() && !sampled) return {false, "no light"};
    const bool black = std::none_of(scene.lights.begin(), scene.lights.end(), shines);
    if (black && !sampled) return {false, "every light is black"};
    if (Finding surface = litSurfaceIn(usage); !surface.calledFor) return surface;
    if (black) return {true, "light of the environment image or of glowing surfaces"};
    static const char* const KINDS[] = {"point", "spot", "directional", "headlight", "quad"};
    std::vector<std::string> kinds;
    size_t shining = 0;
    for (uint32_t type = 0; type < std::size(KINDS); type++) {
        auto number = std::count_if(scene.lights.begin(), scene.lights.end(),
                                    [&](const Light& l) { return l.type == type && shines(l); });
        if (number > 0) kinds.push_back(std::to_string(number) + " " + KINDS[type]);
        shining += static_cast<size_t>(number);
    }
    return {true, counted(shining, "light") + " (" + joined(kinds) + ")"};
}

Finding softShadows(const Usage& usage) {
    const auto& lights = usage.scene.lights;
    if (Finding surface = litSurfaceIn(usage); !surface.calledFor) return surface;
    auto wide = std::count_if(lights.begin(), lights.end(),
                              [](const Light& l) { return shines(l) && (l.radius > 0.0f || l.type == LIGHT_QUAD); });
    if (wide == 0) return {false, "no light has an extent"};
    return {true, counted(static_cast<uint64_t>(wide), "light") + " with an extent"};
}

Finding manyLights(const Usage& usage) {
    const Scene& scene = usage.scene;
    if (scene.environment.lightTreeLevels == 0)
        return {false, "no more than " + std::to_string(MOST_LISTED_LIGHTS) + " lights have a place"};
    if (Finding surface = litSurfaceIn(usage); !surface.calledFor) return surface;
    return {true, counted(scene.lights.size() - scene.environment.listedLights, "light") + " with a place"};
}

Finding transparentShadows(const Usage& usage) {
    Finding light = shadows(usage);
    if (!light.calledFor) return light;
    return byMaterial(usage, "no surface lets light through",
                      [&](uint32_t m) { return transmits(usage.scene, usage.scene.materials[m]) || blends(usage, m); });
}

Finding environment(const Usage& usage) {
    const Scene& scene = usage.scene;
    if (scene.environment.image == NO_INDEX) return {false, "no environment image"};
    const ImageLevel& level = scene.imageLevels[scene.images[scene.environment.image].firstLevel];
    return {true, "an image of " + std::to_string(level.width) + "x" + std::to_string(level.height) + " pixels"};
}

Finding filteredEnvironment(const Usage& usage) {
    if (Finding image = environment(usage); !image.calledFor) return image;
    if (usage.scene.environment.filtered == NO_INDEX) return {false, "the image's light is smooth: nine coefficients hold it"};
    if (Finding surface = litSurfaceIn(usage); !surface.calledFor) return surface;
    return {true, "an image whose light is not smooth: nine coefficients do not hold it"};
}

Finding environmentLight(const Usage& usage) {
    if (Finding image = environment(usage); !image.calledFor) return image;
    if (usage.scene.environment.lightColumns == 0) return {false, "no place of the image is far brighter than the rest"};
    if (Finding surface = litSurfaceIn(usage); !surface.calledFor) return surface;
    return {true, "an image of which more than 5 % of the light comes from bright places"};
}

Finding surfaceLights(const Usage& usage) {
    if (usage.scene.environment.emitterCount == 0) return {false, "no surface glows that no light stands for"};
    if (Finding surface = litSurfaceIn(usage); !surface.calledFor) return surface;
    return {true, counted(usage.scene.environment.emitterCount, "glowing triangle")};
}

Finding manyLamps(const Usage& usage) {
    const Environment& environment = usage.scene.environment;
    if (environment.lampTreeLevels == 0)
        return {false, "no more than " + std::to_string(MOST_LISTED_LAMPS) + " triangles glow"};
    if (Finding surface = litSurfaceIn(usage); !surface.calledFor) return surface;
    return {true, counted(environment.emitterCount, "glowing triangle")};
}

Finding roughGlass(const Usage& usage) {
    return byItsMaterial(usage, "no rough glass",
                         [&](const Material& m) { return !phong(m) && m.roughness > 0.0f && transmits(usage.scene, m); });
}

Finding path(const Usage& usage) { return onLitSurfaces(usage); }
Finding tangents(const Usage& usage) {
    return byMaterial(usage, "no normal or bump image and no anisotropy on a mesh with tangents", [&](uint32_t m) {
        const MaterialLayers l = layersOf(usage.scene, usage.scene.materials[m]);
        const bool steered = l.anisotropy > 0.0f || l.coatNormalTexture != NO_INDEX;
        return (steered || bumpy(usage.scene.materials[m])) && (usage.met[m] & Usage::MET_TANGENTS) != 0;
    });
}

Finding instancing(const Usage& usage) {
    const auto& instances = usage.scene.instances;
    auto placed =
        std::count_if(instances.begin(), instances.end(), [](const Instance& i) { return (i.flags & INSTANCE_IDENTITY) == 0; });
    if (placed == 0) return {false, "every mesh stands where its vertices say"};
    return {true, counted(static_cast<uint64_t>(placed), "placed instance") + ", " +
                      counted(usage.scene.triangles.size(), "stored triangle")};
}

Finding shapes(const Usage& usage) {
    std::vector<std::string> kinds;
    for (uint32_t kind = 0; kind < 4; kind++) {
        const auto isOf = [&](const Instance& i) { return isShape(i) && shapeKindOf(i) == kind; };
        const auto count = static_cast<uint64_t>(std::ranges::count_if(usage.scene.instances, isOf));
        if (count > 0) kinds.push_back(counted(count, shapeName(kind)));
    }
    return {!kinds.empty(), kinds.empty() ? "no shape that a formula describes" : joined(kinds)};
}

Finding reflections(const Usage& usage) {
    return byItsMaterial(usage, "no mirror, glass or smooth surface",
                         [&](const Material& m) { return reflects(usage.scene, m); });
}

Finding glossyReflections(const Usage& usage) {
    return byItsMaterial(usage, "no rough surface that reflects", [&](const Material& m) { return glossy(usage.scene, m); });
}

Finding refractions(const Usage& usage) {
    return byItsMaterial(usage, "no transmissive material", [&](const Material& m) { return transmits(usage.scene, m); });
}

Finding absorption(const Usage& usage) {
    return byItsMaterial(usage, "no body that absorbs", [&](const Material& m) {
        vec4 a = m.absorption;
        bool body = (m.flags & MATERIAL_VOLUME) != 0 && transmits(usage.scene, m);
        return body && (a.x > 0.0f || a.y > 0.0f || a.z > 0.0f);
    });
}

Finding nestedMedia(const Usage& usage) {
    if (usage.scene.nestedBodies == 0) return {false, "no bodies of two media touch"};
    std::vector<std::pair<uint32_t, std::string>> media;
    for (size_t m = 0; m < usage.scene.materials.size(); m++) {
        const uint32_t medium = usage.scene.materials[m].medium;
        if (medium != 0 && usage.trianglesOf[m] > 0) media.push_back({medium, usage.scene.materialNames[m]});
    }
    std::ranges::stable_sort(media, std::greater(), &std::pair<uint32_t, std::string>::first);
    constexpr size_t NAMED = 4;
    std::string names;
    for (size_t i = 0; i < std::min(media.size(), NAMED); i++) names += (i == 0 ? "" : " over ") + media[i].second;
    if (media.size() > NAMED) names += " over ...";
    return {true, withThousands(usage.scene.nestedBodies) + " bodies that touch or stand in each other: " + names};
}

Finding textures(const Usage& usage) {
    return byItsMaterial(usage, "no material has a texture", [&](const Material& m) { return hasTexture(usage.scene, m); });
}
Finding normalMaps(const Usage& usage) { return byItsMaterial(usage, "no normal or bump image", bumpy); }

Finding occlusionTextures(const Usage& usage) {
    return byItsMaterial(usage, "no occlusion image", [](const Material& m) {
        return m.occlusionTexture != NO_INDEX && m.occlusionStrength > 0.0f && lit(m);
    });
}

Finding clearcoat(const Usage& usage) {
    return byItsMaterial(usage, "no material has a coat", [&](const Material& m) {
        const MaterialLayers l = layersOf(usage.scene, m);
        return lit(m) && l.coat > 0.0f && notBlack(usage.scene, l.coatTexture, 0xffu);
    });
}

Finding sheen(const Usage& usage) {
    return byItsMaterial(usage, "no material has sheen", [&](const Material& m) {
        const MaterialLayers l = layersOf(usage.scene, m);
        return lit(m) && l.sheenTable != NO_INDEX && notBlack(usage.scene, l.sheenColorTexture, 0xffffffu);
    });
}

Finding anisotropy(const Usage& usage) {
    return byItsMaterial(usage, "no material's highlights are longer one way", [&](const Material& m) {
        const MaterialLayers l = layersOf(usage.scene, m);
        return lit(m) && l.anisotropy > 0.0f && notBlack(usage.scene, l.anisotropyTexture, 0xff0000u);
    });
}

Finding iridescence(const Usage& usage) {
    return byItsMaterial(usage, "no material has a thin film", [&](const Material& m) {
        const MaterialLayers l = layersOf(usage.scene, m);
        const bool thick = l.filmThickest > 0.0f || (l.filmThinnest > 0.0f && l.filmThicknessTexture != NO_INDEX);
        return lit(m) && thick && l.iridescence > 0.0f && notBlack(usage.scene, l.iridescenceTexture, 0xffu);
    });
}

Finding dispersion(const Usage& usage) {
    return byItsMaterial(usage, "no glass bends its colours apart", [&](const Material& m) {
        const bool body = (m.flags & MATERIAL_VOLUME) != 0 && m.ior > 1.0f && transmits(usage.scene, m);
        return body && layersOf(usage.scene, m).dispersion > 0.0f;
    });
}

Finding diffuseTransmission(const Usage& usage) {
    return byItsMaterial(usage, "no light scatters through a surface", [&](const Material& m) {
        const MaterialLayers l = layersOf(usage.scene, m);
        return lit(m) && l.diffuseTransmission > 0.0f && notBlack(usage.scene, l.diffuseTransmissionTexture, 0xff000000u) &&
               notBlack(usage.scene, l.diffuseColorTexture, 0xffffffu);
    });
}

Finding vertexColors(const Usage& usage) {
    return byMaterial(usage, "every vertex is white", [&](uint32_t m) { return bool(usage.coloured[m]); });
}

Finding alphaMask(const Usage& usage) {
    return byMaterial(usage, "no cut-out material", [&](uint32_t m) { return (usage.met[m] & Usage::MET_MASKED) != 0; });
}

Finding alphaBlend(const Usage& usage) {
    return byMaterial(usage, "no blended material", [&](uint32_t m) { return blends(usage, m); });
}

Finding emission(const Usage& usage) {
    return byItsMaterial(usage, "nothing glows", [&](const Material& m) { return glows(usage.scene, m); });
}

Finding secondTextureCoordinates(const Usage& usage) {
    return byItsMaterial(usage, "every texture uses the first coordinates",
                         [&](const Material& m) { return usesSecondUv(usage.scene, m); });
}

}  // namespace rules

/// "2 animations (walk, run)": the first names that there are.
std::string listed(const std::vector<std::string>& names, const std::string& noun) {
    constexpr size_t NAMED = 4;
    std::vector<std::string> some;
    std::ranges::copy_if(std::span(names).first(std::min(names.size(), NAMED)), std::back_inserter(some),
                         [](const std::string& name) { return !name.empty(); });
    if (names.size() > NAMED && !some.empty()) some.push_back("...");
    return counted(names.size(), noun) + (some.empty() ? "" : " (" + joined(some) + ")");
}

/// Scenes are shown at rest, and the list says so.
std::vector<EffectReason> notSimulated(const AtRest& atRest) {
    auto row = [](const char* name, size_t number, const std::string& what, const char* lack, const char* help) {
        return EffectReason{name, 0, number > 0, number > 0 ? what + "; shown at rest" : lack, "", help, false};
    };
    return {row("animation", atRest.animations.size(), listed(atRest.animations, "animation"), "no animation in the file",
                "Objects that move in time."),
            row("skinning", atRest.skinnedMeshes, counted(atRest.skinnedMeshes, "skinned mesh", "es"), "no skin in the file",
                "Surfaces that follow a skeleton."),
            row("morphing", atRest.morphedMeshes, counted(atRest.morphedMeshes, "mesh", "es") + " with morph targets",
                "no morph targets in the file", "Surfaces that blend between shapes.")};
}

}  // namespace

std::vector<EffectReason> explainEffects(const Scene& scene) {
    const Usage usage(scene);
    std::vector<EffectReason> reasons;
    std::vector<Finding> findings;
#define EFFECT(bit, CONSTANT, name, setting, parent, positive, rule, tier, help) findings.push_back(rules::rule(usage));
#include "shaders/kernel/effect_table.glsl"
    for (size_t i = 0; i < findings.size(); i++) {
        const EffectRow& row = effectRows()[i];
        reasons.push_back({std::string(row.name), row.bit, findings[i].calledFor, findings[i].because, std::string(row.setting),
                           std::string(row.help), true, findings[i].choice});
    }
    for (EffectReason& row : notSimulated(scene.atRest)) reasons.push_back(std::move(row));
    return reasons;
}

EffectSet possibleEffects(const std::vector<EffectReason>& effects) {
    EffectSet possible;
    for (const EffectReason& effect : effects) {
        if (effect.possible()) possible.bits |= effect.bit;
    }
    return possible;
}

EffectSet effectsOf(const Scene& scene) { return possibleEffects(explainEffects(scene)); }

}  // namespace heliograph
