#pragma once
// A scene: immutable, shared by all devices, flat arrays in the kernel's layout (shaders/kernel/types.glsl). Made by
// SceneBuilder only. Y is up; lengths are the file's own units, taken as metres.

#include "server/kernel/kernel_types.h"
#include "server/scene/object_names.h"

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace heliograph {

struct Bounds {
    vec3 low{1e30f};
    vec3 high{-1e30f};
    bool empty() const { return low.x > high.x; }
    vec3 center() const { return 0.5f * (low + high); }
    float radius() const { return empty() ? 1.0f : 0.5f * glm::length(high - low); }  // of the bounding sphere
    void grow(vec3 point) {
        low = glm::min(low, point);
        high = glm::max(high, point);
    }
};

/// A viewpoint of the scene. Angles in degrees.
struct NamedCamera {
    std::string name;
    vec3 position{0.0f};
    vec3 forward{0.0f, 0.0f, -1.0f};  // unit
    vec3 up{0.0f, 1.0f, 0.0f};        // unit, orthogonal to forward
    float fieldOfView = 60.0f;        // vertical, degrees
};

/// How far the vertices of a scene reach as seen from one direction (scene/framing.h).
struct Framing {
    static constexpr size_t STEPS = 40;
    vec3 center{0.0f};
    /// To the right, left, up and down of the center, plus the tangent of an opening angle times how much nearer they are: for
    /// tangents in equal ratios from 1e-4 to 100.
    std::array<std::array<float, STEPS>, 4> reach{};
};

/// A camera path: keys are passed at equal times along a closed or open Catmull-Rom spline.
struct CameraPath {
    struct Key {
        vec3 position;
        vec3 target;
    };
    std::string name;
    float seconds = 10.0f;
    bool closed = true;
    std::vector<Key> keys;  // at least 2
};

/// What its file would have moving; a scene is shown at rest.
struct AtRest {
    std::vector<std::string> animations;  // their names, "" for those without
    uint32_t skinnedMeshes = 0;
    uint32_t morphedMeshes = 0;  // with morph targets; the file's weights are applied
};

/// Looks of its surfaces that a file offers (KHR_materials_variants).
struct Variants {
    std::vector<std::string> names;
    std::optional<uint32_t> chosen;  // of names; nothing: the file's own look
};

/// An extension that a file uses.
struct FileExtension {
    std::string name;
    bool read = true;
    std::string note;  // what is made of it, or why it is not read
};

class Scene {
public:
    std::string name;                          // as the user asked for it
    std::vector<vec4> positions;               // object space, w = 0; one padding element at the end (Embree reads 16 bytes)
    std::vector<VertexAttributes> attributes;  // one per position
    std::vector<vec4> tangents;                // xyz unit, w = +-1; one per position or empty when no mesh has them
    std::vector<uvec4> triangles;              // three absolute vertex indices and the material
    std::vector<Mesh> meshes;
    std::vector<Instance> instances;
    std::vector<Material> materials;
    std::vector<TextureSlot> textures;
    std::vector<Image> images;
    uint32_t surfaceImages = 0;  // of them; the others are of surroundings
    std::vector<ImageLevel> imageLevels;
    std::vector<uint32_t> texels;
    std::vector<Light> lights;
    Environment environment{};         // as the scene has it
    std::vector<Environment> offered;  // studio and sky, where settings may choose them (SceneBuilder::offerSurroundings)

    std::vector<std::string> materialNames;  // one per material, for messages and reasons
    ObjectNames objects;                     // the same
    std::vector<NamedCamera> cameras;        // at least one; the first is where a viewer starts
    std::optional<Framing> framing;          // where no file names the first camera and it looks at the scene from outside
    std::vector<CameraPath> paths;           // may be empty
    std::vector<std::string> warnings;       // what the loader changed, ignored or added
    AtRest atRest;
    Variants variants;
    std::vector<FileExtension> extensions;  // of its format, as the file lists them
    Bounds bounds;                          // world space; without planes and balls that are ground to the rest
    float farthestSurface = 0.0f;           // largest |x| + |y| + |z| of shapes
    uint32_t nestedBodies = 0;              // bodies that touch another by their boxes, if there are several media
    std::vector<Bounds> bodyBounds;         // of all bodies, in the world, where some are nested
    float aoRadius = 1.0f;                  // metres: what aoRadius = 1 means in this scene
    float exposure = 0.0f;                  // EV that suits the scene, added to the viewer's
    bool fromFile = false;                  // somebody else's model, not one of the scenes that come along
    bool inStudio = false;                  // from a file without any light: `environment` is the studio
    bool litByFile = false;                 // from a file that brings lights or bright glow, of whatever unit
    uint64_t contentHash = 0;               // of every array above

    /// Where a camera may stand: within 10,000 radii of the scene's middle (from there it fills the narrowest field of view),
    /// at least 10 km, and where lengths still have squares in float.
    Bounds cameraRange() const;
    /// The largest |x| + |y| + |z| of a ray's origin: no camera and no surface lies farther out. Every ray within it is finite
    /// in the space of every instance (SceneBuilder sees to that); others are not traced.
    float rayReach() const;
    /// Triangles over all instances; those that stand for shapes are none.
    uint64_t triangleCount() const;
    /// Bytes held by the arrays.
    uint64_t bytes() const;
};

}  // namespace heliograph
