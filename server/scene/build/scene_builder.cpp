#include "server/scene/build/scene_builder.h"

#include "server/base/error.h"
#include "server/scene/build/content_hash.h"
#include "server/scene/build/default_camera.h"
#include "server/scene/build/image_pyramid.h"
#include "server/scene/build/layer_words.h"
#include "server/scene/build/mesh_assembly.h"
#include "server/scene/build/mesh_prepare.h"
#include "server/scene/build/scene_checks.h"
#include "server/scene/build/scene_draft.h"
#include "server/scene/build/shape_mesh.h"
#include "server/scene/light/ambient.h"
#include "server/scene/light/emitters.h"
#include "server/scene/light/glass_table.h"
#include "server/scene/light/environment_tables.h"
#include "server/scene/light/light_tree.h"
#include "server/scene/light/studio.h"
#include "server/scene/media/nested_media.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace heliograph {

struct SceneBuilder::Data : SceneDraft {};

namespace {

constexpr vec3 DEFAULT_SURROUNDINGS{0.24f, 0.27f, 0.33f};  // an overcast sky, radiance
constexpr float HEADLIGHT_IRRADIANCE = 2.0f;               // white facing the camera comes out at 2 / pi
constexpr float LAMPS_IRRADIANCE = 0.25f;                  // of glowing surfaces, from which on no headlight is needed
constexpr double SMOOTH_AMBIENT = 0.03;                    // relative error of nine coefficients that is let be
constexpr double SMOOTH_REFLECTION = 0.3;                  // the same of what a surface of roughness 0.4 reflects
constexpr double LIGHT_IN_SKY = 0.05;                      // share of the light from concentrated places that calls for rays
constexpr uint64_t MOST_LIGHT_TEXELS = uint64_t(1) << 19;  // of an environment image that is sampled
constexpr uint64_t MOST_FILTERED_TEXELS = 512 * 256;
constexpr size_t MOST_WARNINGS = 64;
constexpr size_t LONGEST_WARNING = 300;

bool validImage(const ImageData& image) {
    const uint64_t texels = static_cast<uint64_t>(image.width) * image.height;
    if (texels == 0 || image.width > 16384 || image.height > 16384) return false;
    return image.rgb32f.empty() ? image.rgba8.size() == texels * 4 : image.rgb32f.size() == texels * 3;
}

std::vector<bool> imagesWithAlpha(const std::vector<ImageData>& images) {
    std::vector<bool> result;
    for (const ImageData& image : images) {
        bool alpha = false;
        for (size_t i = 3; i < image.rgba8.size() && !alpha; i += 4) alpha = image.rgba8[i] != 255;
        result.push_back(alpha);
    }
    return result;
}

/// Images whose alpha a material reads: their colours are filtered by alpha.
std::vector<bool> alphaWeightedImages(const Scene& scene, size_t imageCount) {
    std::vector<bool> result(imageCount, false);
    for (const Material& material : scene.materials) {
        const bool reads = (material.flags & (MATERIAL_ALPHA_MASK | MATERIAL_ALPHA_BLEND)) != 0;
        if (reads && material.baseTexture != NO_INDEX) result[scene.textures[material.baseTexture].image] = true;
    }
    return result;
}

void prepareMeshes(SceneDraft& draft) {
    std::vector<MeshReport> reports(draft.meshes.size());
    const std::vector<Steering> materials = steeringOf(draft);
    tbb::parallel_for(size_t(0), draft.meshes.size(), [&](size_t i) { reports[i] = prepareMesh(draft.meshes[i], materials); });
    MeshReport sum;
    for (const MeshReport& report : reports) sum.add(report);
    const auto warn = [&](uint64_t count, const char* what) {
        if (count > 0) addWarning(draft, std::to_string(count) + what);
    };
    warn(sum.outOfRange, " triangles were dropped: a vertex index is out of range");
    warn(sum.nonFinite, " triangles were dropped: a vertex is not finite");
    warn(sum.zeroArea, " triangles have no area");
    warn(sum.badMaterials, " triangles name a material that does not exist; they take the default");
    warn(sum.badNormals, " normals were not usable and were computed from the triangles");
    warn(sum.badArrays, " vertex arrays of the wrong length were ignored");
}

void buildImages(SceneDraft& draft, const Progress& progress) {
    Scene& scene = draft.scene;
    uint64_t texels = 0;
    for (const ImageData& image : draft.images) texels += pyramidTexels(image.width, image.height);
    if (texels >= NO_INDEX)
        throw InputError(scene.name, std::to_string(texels) + " texels with mip maps", "fewer than 4294967295");
    scene.texels.reserve(texels);
    const std::vector<bool> weighted = alphaWeightedImages(scene, draft.images.size());
    for (size_t i = 0; i < draft.images.size(); i++) {
        report(progress, "images", static_cast<double>(i) / draft.images.size());
        appendPyramid(scene, draft.images[i], weighted[i]);
    }
}

/// An environment as `image` or, without one, `color` makes it; without tables.
Environment environmentOf(const SceneDraft& draft, uint32_t image, vec3 color, float intensity, float rotation) {
    Environment environment{};
    environment.image = environment.filtered = NO_INDEX;
    environment.intensity = 1.0f;
    if (image >= draft.images.size()) {
        ambientFromColor(environment, color);
        return environment;
    }
    environment.image = image;
    environment.intensity = intensity;
    environment.rotation = rotation;
    ambientFromImage(environment, draft.images[image]);
    return environment;
}

/// Whether nine coefficients hold the image's light. They are turned with the image; the map is not.
bool hasSmoothSky(const ImageData& image, const RadianceMap& map) {
    Environment unrotated{};
    unrotated.intensity = 1.0f;
    ambientFromImage(unrotated, image);
    const RadianceMap coarse = halvedTo(map, 128 * 64);
    return ambientMisses(coarse, unrotated) <= SMOOTH_AMBIENT && reflectionMisses(coarse, unrotated) <= SMOOTH_REFLECTION;
}

/// An environment and the radiance of its image, kept until its tables are built: the pixels are freed before.
struct NewSurroundings {
    Environment environment;
    RadianceMap map;  // empty without an image
    bool smooth = true;

    NewSurroundings(const SceneDraft& draft, const Environment& made) : environment(made) {
        if (made.image == NO_INDEX) return;
        map = radianceMap(draft.images[made.image], MOST_LIGHT_TEXELS);
        smooth = hasSmoothSky(draft.images[made.image], map);
    }

    /// Builds the tables of the image, where its light is not smooth.
    void addTables(Scene& scene) {
        if (map.texels.empty()) return;
        if (!smooth) environment.filtered = appendFiltered(scene, halvedTo(map, MOST_FILTERED_TEXELS));
        if (concentrated(map) > LIGHT_IN_SKY) appendLightTable(scene, environment, map);
    }
};

/// Surroundings that are offered, as a scene without anything else: their images and tables are the same for every scene.
struct Offered {
    Scene scene;

    explicit Offered(ImageData image) {
        SceneDraft draft;
        draft.images.push_back(std::move(image));
        NewSurroundings surroundings(draft, environmentOf(draft, 0, vec3(0.0f), 1.0f, 0.0f));
        appendPyramid(scene, draft.images.front(), false);
        surroundings.addTables(scene);
        scene.environment = surroundings.environment;
    }

    /// Puts images and tables behind those of `to`.
    Environment appendedTo(Scene& to) const {
        const auto texels = static_cast<uint32_t>(to.texels.size()), levels = static_cast<uint32_t>(to.imageLevels.size()),
                   images = static_cast<uint32_t>(to.images.size());
        if (uint64_t(texels) + scene.texels.size() >= NO_INDEX)
            throw InputError(to.name, std::to_string(texels) + " texels", "fewer than 4294967295 with the studio's");
        to.texels.insert(to.texels.end(), scene.texels.begin(), scene.texels.end());
        for (ImageLevel level : scene.imageLevels) {
            level.firstTexel += texels;
            to.imageLevels.push_back(level);
        }
        for (Image image : scene.images) {
            image.firstLevel += levels;
            to.images.push_back(image);
        }
        Environment environment = scene.environment;
        environment.image += images;
        if (environment.filtered != NO_INDEX) environment.filtered += images;
        if (environment.lightColumns > 0) environment.lightTable += texels;
        return environment;
    }
};

// Made once, at the first scene that needs them.
const Offered& studio() {
    static const Offered made(paintStudio());
    return made;
}
const Offered& clearDay() {
    static const Offered made(paintClearDay());
    return made;
}

bool standsInStudio(const SceneDraft& draft) {
    return draft.hasStudio && draft.scene.fromFile && draft.lights.empty() && draft.environmentImage == NO_INDEX &&
           !draft.environmentColor;
}

/// The scene's own; of one in the studio nothing yet.
NewSurroundings ownSurroundings(SceneDraft& draft) {
    draft.scene.inStudio = standsInStudio(draft);
    const vec3 color = draft.environmentColor.value_or(DEFAULT_SURROUNDINGS);
    return {draft, environmentOf(draft, draft.environmentImage, color, draft.environmentIntensity, draft.environmentRotation)};
}

void buildEnvironments(SceneDraft& draft, NewSurroundings& own) {
    Scene& scene = draft.scene;
    own.addTables(scene);
    scene.environment = own.environment;
    if (draft.offers) scene.offered = {studio().appendedTo(scene), clearDay().appendedTo(scene)};
    if (scene.inStudio) scene.environment = draft.offers ? scene.offered.front() : studio().appendedTo(scene);
}

/// `lamps`: irradiance of the glowing surfaces.
void buildLights(SceneDraft& draft, float lamps) {
    checkLights(draft);
    const bool image = draft.scene.environment.image != NO_INDEX;
    // Only a file that means candela per square metre has surfaces that send more than white does.
    const bool glows = std::ranges::any_of(draft.scene.materials, [](const Material& m) {
        return std::max({m.emission.x, m.emission.y, m.emission.z}) > 1.0f;
    });
    draft.scene.litByFile = draft.scene.fromFile && (!draft.lights.empty() || glows);
    if (draft.lights.empty() && (image || lamps >= LAMPS_IRRADIANCE)) {
        addWarning(draft, std::string("no light in the file: ") + (draft.scene.inStudio ? "the studio lights it"
                                                                   : image              ? "the environment image lights it"
                                                                                        : "its glowing surfaces light it"));
    } else if (draft.lights.empty()) {
        Light light{};
        light.type = LIGHT_HEADLIGHT;
        light.direction = vec3(0.0f, 0.0f, -1.0f);
        light.intensity = vec3(HEADLIGHT_IRRADIANCE);
        draft.lights.push_back(light);
        addWarning(draft, "no light in the file: a headlight was added");
    }
    draft.scene.lights = std::move(draft.lights);
    appendLightTree(draft.scene);
}

}  // namespace

void addWarning(SceneDraft& draft, const std::string& message) {
    std::string line = message.substr(0, LONGEST_WARNING);
    for (char& c : line) {
        if (static_cast<unsigned char>(c) < 0x20) c = ' ';
    }
    std::vector<std::string>& warnings = draft.scene.warnings;
    if (std::find(warnings.begin(), warnings.end(), line) != warnings.end()) return;
    if (warnings.size() < MOST_WARNINGS) {
        warnings.push_back(std::move(line));
    } else {
        draft.warningsLeftOut++;
    }
}

SceneBuilder::SceneBuilder(std::string name) : data_(std::make_shared<Data>()) {
    data_->scene.name = std::move(name);
    addMaterial(defaultMaterial(), "default");
}

uint32_t SceneBuilder::addMaterial(const Material& material, const std::string& name) {
    data_->scene.materials.push_back(material);
    data_->scene.materialNames.push_back(name);
    return static_cast<uint32_t>(data_->scene.materials.size() - 1);
}

uint32_t SceneBuilder::addLayers(const MaterialLayers& layers) {
    data_->layers.push_back(layers);
    return static_cast<uint32_t>(data_->layers.size() - 1);
}

uint32_t SceneBuilder::addImage(ImageData image) {
    if (!validImage(image)) {
        addWarning(*data_, "image '" + image.name + "' is empty or too large: drawn white");
        image.width = image.height = 1;
        image.rgb32f.clear();
        image.rgba8.assign(4, 255);
    }
    data_->images.push_back(std::move(image));
    return static_cast<uint32_t>(data_->images.size() - 1);
}

uint32_t SceneBuilder::addTexture(const TextureSlot& slot) {
    if (slot.image >= data_->images.size())
        throw std::logic_error("texture of image " + std::to_string(slot.image) + " of " +
                               std::to_string(data_->images.size()));
    data_->scene.textures.push_back(slot);
    return static_cast<uint32_t>(data_->scene.textures.size() - 1);
}

uint32_t SceneBuilder::addMesh(MeshData mesh) {
    data_->meshes.push_back(std::move(mesh));
    return static_cast<uint32_t>(data_->meshes.size() - 1);
}

uint32_t SceneBuilder::addShape(ShapeForm form, uint32_t material) {
    if (material >= data_->scene.materials.size())
        throw std::logic_error("shape of material " + std::to_string(material) + " of " +
                               std::to_string(data_->scene.materials.size()));
    Material own = data_->scene.materials[material];
    if (std::max({own.emission.x, own.emission.y, own.emission.z}) > 0.0f && (own.flags & MATERIAL_LIT_APART) == 0) {
        own.flags |= MATERIAL_LIT_APART;  // no rays are sent to it as to the triangles of that material
        const std::string name = data_->scene.materialNames[material];
        addWarning(*data_, "shapes of the glowing material '" + name + "' light others by chance alone");
        material = addMaterial(own, name);
    }
    return addMesh(shapeMesh(form, material));
}

void SceneBuilder::addInstance(uint32_t mesh, const mat4& toWorld, const std::string& name) {
    if (mesh >= data_->meshes.size())
        throw std::logic_error("instance of mesh " + std::to_string(mesh) + " of " + std::to_string(data_->meshes.size()));
    data_->placed.push_back({mesh, toWorld, name});
}

void SceneBuilder::addLight(const Light& light) { data_->lights.push_back(light); }
void SceneBuilder::addCamera(const NamedCamera& camera) { data_->scene.cameras.push_back(camera); }
void SceneBuilder::addPath(const CameraPath& path) { data_->scene.paths.push_back(path); }
void SceneBuilder::setEnvironmentColor(vec3 radiance) { data_->environmentColor = radiance; }

void SceneBuilder::setEnvironmentImage(uint32_t image, float intensity, float rotation) {
    data_->environmentImage = image;
    data_->environmentIntensity = intensity;
    data_->environmentRotation = rotation;
}

void SceneBuilder::setAoRadius(float metres) { data_->aoRadius = metres; }
void SceneBuilder::setExposure(float ev) { data_->scene.exposure = ev; }
void SceneBuilder::setFromFile() { data_->scene.fromFile = true; }
void SceneBuilder::offerSurroundings(bool all) {
    data_->hasStudio = true;
    data_->offers = all;
}

void SceneBuilder::setAtRest(AtRest atRest) { data_->scene.atRest = std::move(atRest); }
void SceneBuilder::setVariants(Variants variants) { data_->scene.variants = std::move(variants); }
void SceneBuilder::setExtensions(std::vector<FileExtension> extensions) { data_->scene.extensions = std::move(extensions); }
void SceneBuilder::warn(const std::string& message) { addWarning(*data_, message); }

std::shared_ptr<const Scene> SceneBuilder::finish(const Progress& progress) {
    const std::shared_ptr<Data> data = std::move(data_);
    SceneDraft& draft = *data;
    Scene& scene = draft.scene;
    data_ = std::make_shared<Data>();
    addMaterial(defaultMaterial(), "default");

    report(progress, "geometry", 0.0);
    checkMaterials(draft);
    prepareMeshes(draft);
    nestMedia(draft);
    report(progress, "geometry", 0.6);
    assembleMeshes(draft, opacityClasses(scene, imagesWithAlpha(draft.images)));
    report(progress, "geometry", 1.0);
    NewSurroundings surroundings = ownSurroundings(draft);
    scene.surfaceImages = static_cast<uint32_t>(draft.images.size()) - (surroundings.environment.image != NO_INDEX ? 1 : 0);
    buildImages(draft, progress);
    report(progress, "images", 1.0);
    appendLayers(draft);
    buildEnvironments(draft, surroundings);
    appendGlassTable(scene);
    buildLights(draft, appendEmitters(scene));
    placeParallelCameras(draft);
    checkCameras(draft);
    if (scene.cameras.empty()) scene.cameras.push_back(defaultCamera(scene, scene.framing));
    scene.aoRadius = draft.aoRadius.value_or(0.1f * scene.bounds.radius());
    if (!(scene.aoRadius > 0.0f)) scene.aoRadius = 0.1f;
    if (draft.warningsLeftOut > 0) scene.warnings.push_back("and " + std::to_string(draft.warningsLeftOut) + " more warnings");
    scene.contentHash = contentHashOf(scene);
    return std::make_shared<const Scene>(std::move(scene));
}

Material SceneBuilder::defaultMaterial() {
    Material material{};
    material.baseColor = vec4(1.0f);
    material.specular = vec4(1.0f, 1.0f, 1.0f, 0.0f);
    material.transmissionTint = vec4(1.0f, 1.0f, 1.0f, 0.0f);
    material.roughness = 1.0f;
    material.ior = 1.5f;
    material.alphaCutoff = 0.5f;
    material.normalScale = material.occlusionStrength = 1.0f;
    material.baseTexture = material.metallicRoughnessTexture = material.normalTexture = NO_INDEX;
    material.emissionTexture = material.opacityTexture = NO_INDEX;
    material.transmissionTexture = material.specularTexture = material.occlusionTexture = material.layers = NO_INDEX;
    return material;
}

TextureSlot SceneBuilder::defaultTexture(uint32_t image) {
    TextureSlot slot{};
    slot.transform = vec4(1.0f, 0.0f, 0.0f, 1.0f);
    slot.image = image;
    return slot;
}

}  // namespace heliograph
