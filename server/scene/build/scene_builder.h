#pragma once
// Collects meshes, materials, images, lights and cameras and makes an immutable Scene of them. Everything a loader or a
// generator needs; the kernel's layout is known here alone.
//
// finish() sanitises (non-finite vertices and indices out of range are dropped, zero-area triangles counted, each with
// a warning), makes missing normals (area-weighted) and tangents (where a normal texture is used), splits meshes by
// opacity class, bakes meshes that are used once into world space unless that would cost precision, builds mip pyramids
// and the environment's ambient coefficients, adds a headlight where there is no light and says so, and a camera where
// there is none.

#include "server/base/progress.h"
#include "server/scene/material_layers.h"

#include <optional>
#include <span>

namespace heliograph {

/// What an analytic shape is, of size one; instances give it radius and height (addShape).
struct ShapeForm {
    uint32_t kind = SHAPE_SPHERE;
    bool capped = false;  // of a cylinder: closed at its ends
};

/// Triangles as loaded or generated, object space. All arrays but positions and indices may be empty.
struct MeshData {
    std::vector<vec3> positions;
    std::vector<vec3> normals;
    std::vector<vec2> uv0;
    std::vector<vec2> uv1;
    std::vector<vec4> tangents;  // w = handedness
    std::vector<vec4> colors;    // linear RGBA, 0..1
    std::vector<uvec3> indices;
    std::vector<uint32_t> materials;  // one per triangle, or empty: all material 0 (the default)
    std::optional<ShapeForm> shape;   // what is met in the place of the triangles (shape_mesh.h)
};

/// Pixels of an image before mip maps. Row-major, top row first.
struct ImageData {
    uint32_t width = 0;
    uint32_t height = 0;
    bool srgb = true;            // rgba8 holds sRGB-coded colour
    std::vector<uint8_t> rgba8;  // width * height * 4, or empty
    std::vector<float> rgb32f;   // width * height * 3 for HDR, or empty
    std::string name;
};

class SceneBuilder {
public:
    explicit SceneBuilder(std::string name);

    /// Material 0 always exists: white, rough, metallic-roughness.
    uint32_t addMaterial(const Material& material, const std::string& name);
    /// What a material has beyond its base: for Material.layers.
    uint32_t addLayers(const MaterialLayers& layers);
    uint32_t addImage(ImageData image);
    uint32_t addTexture(const TextureSlot& slot);
    uint32_t addMesh(MeshData mesh);
    /// An analytic shape, as a mesh of its own: a ball of radius 1 about 0; a cylinder of radius 1 from -1 to 1 along y; a disc of
    /// radius 1 or the whole plane at y = 0, with the normal along y. Instances scale it. One that glows lights others by chance alone.
    uint32_t addShape(ShapeForm form, uint32_t material);
    /// `name`: for messages.
    void addInstance(uint32_t mesh, const mat4& toWorld, const std::string& name = {});
    void addLight(const Light& light);
    void addCamera(const NamedCamera& camera);
    void addPath(const CameraPath& path);
    void setEnvironmentColor(vec3 radiance);
    void setEnvironmentImage(uint32_t image, float intensity = 1.0f, float rotation = 0.0f);
    void setAoRadius(float metres);
    void setExposure(float ev);
    /// It comes from a file: shown as files are (ToneCurve, exposesViews).
    void setFromFile();
    /// A file without any light gets the studio. `all`: settings may choose that and the sky, whatever the scene.
    void offerSurroundings(bool all);
    void setAtRest(AtRest atRest);
    void setVariants(Variants variants);
    void setExtensions(std::vector<FileExtension> extensions);
    void warn(const std::string& message);

    /// Ends the building; the builder is empty afterwards.
    std::shared_ptr<const Scene> finish(const Progress& progress = {});

    /// A metallic-roughness material with every texture field NO_INDEX and neutral values.
    static Material defaultMaterial();
    /// An identity slot for `image`.
    static TextureSlot defaultTexture(uint32_t image);

private:
    struct Data;
    std::shared_ptr<Data> data_;
};

}  // namespace heliograph
