#include "server/scene/load/gltf_nodes.h"

#include "server/base/error.h"
#include "server/scene/build/default_camera.h"
#include "server/scene/load/far_origin.h"
#include "server/scene/load/gltf_accessor.h"
#include "server/scene/load/gltf_mesh.h"
#include "server/scene/load/gltf_shapes.h"
#include "server/scene/load/gltf_textures.h"

#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>

#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <tuple>

namespace heliograph {

namespace {

using glm::dmat4;
using glm::dquat;
using glm::dvec3;

constexpr int DEEPEST_TREE = 4096;
constexpr double NARROWEST_SPOT = 1e-3;  // radians: the cosine of less has no digits left in 32 bits
constexpr size_t MOST_INSTANCES = 500'000;
constexpr const char* SHAPES = "HELIOGRAPH_shapes";
constexpr uint64_t VERTICES_OF_SHAPE = 4096;  // and corners, of the triangles that stand for it

dmat4 composed(dvec3 translation, dquat rotation, dvec3 scale) {
    const double length = glm::length(rotation);
    rotation = length > 0.0 && std::isfinite(length) ? rotation / length : dquat(1.0, 0.0, 0.0, 0.0);
    dmat4 m = glm::mat4_cast(rotation);
    for (int c = 0; c < 3; c++) m[c] *= scale[c];
    m[3] = glm::dvec4(translation, 1.0);
    return m;
}

dmat4 localTransform(const tinygltf::Node& node) {
    if (node.matrix.size() == 16) {
        dmat4 m(1.0);
        for (int i = 0; i < 16; i++) m[i / 4][i % 4] = node.matrix[static_cast<size_t>(i)];
        for (int c = 0; c < 4; c++) m[c][3] = c == 3 ? 1.0 : 0.0;
        return m;
    }
    dvec3 translation(0.0), scale(1.0);
    dquat rotation(1.0, 0.0, 0.0, 0.0);
    if (node.translation.size() == 3) translation = dvec3(node.translation[0], node.translation[1], node.translation[2]);
    if (node.scale.size() == 3) scale = dvec3(node.scale[0], node.scale[1], node.scale[2]);
    if (node.rotation.size() == 4) rotation = dquat(node.rotation[3], node.rotation[0], node.rotation[1], node.rotation[2]);
    return composed(translation, rotation, scale);
}

vec3 direction(const dmat4& m, int column, double sign) {
    const dvec3 axis(m[column]);
    const double length = glm::length(axis);
    return length > 0.0 ? vec3(axis * (sign / length)) : vec3(0.0f);
}

/// What stands for 1 in normalized integers.
double largestOf(int componentType) {
    switch (componentType) {
        case TINYGLTF_COMPONENT_TYPE_BYTE: return 127.0;
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE: return 255.0;
        case TINYGLTF_COMPONENT_TYPE_SHORT: return 32767.0;
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: return 65535.0;
        default: return 1.0;
    }
}

class NodeWalker {
public:
    NodeWalker(const GltfDocument& document, const std::vector<uint32_t>& materials, SceneBuilder& builder,
               const Progress& progress)
        : document_(document), materials_(materials), builder_(builder), progress_(progress), reader_(document, builder) {}

    void walk() {
        const std::vector<int> roots = rootNodes();
        const dvec3 origin = originOf(roots);
        if (origin != dvec3(0.0)) builder_.warn(movedBy(origin));
        size_t visited = 0;
        visit(roots, glm::translate(dmat4(1.0), -origin), [&](const tinygltf::Node& node, int index, const dmat4& toWorld) {
            place(node, index, toWorld);
            report(progress_, "nodes", double(++visited) / double(document_.model.nodes.size()));
        });
        std::set<int> drawn;
        for (const auto& [key, parts] : parts_) drawn.insert(key.first);
        const size_t left = document_.model.meshes.size() - drawn.size();
        if (left > 0) builder_.warn(std::to_string(left) + " meshes are not placed by the scene: not read");
    }

private:
    using Visitor = std::function<void(const tinygltf::Node& node, int index, const dmat4& toWorld)>;

    /// The nodes from the roots on, parents before their children.
    void visit(const std::vector<int>& roots, const dmat4& root, const Visitor& visitor) const {
        struct Step {
            int node;
            dmat4 toWorld;
            int depth;
        };
        std::vector<Step> steps;
        for (size_t i = roots.size(); i-- > 0;) steps.push_back({roots[i], root, 0});
        while (!steps.empty()) {
            const Step step = steps.back();
            steps.pop_back();
            if (step.depth > DEEPEST_TREE)
                throw InputError(document_.at(pointerOf(step.node)),
                                 "the node tree is deeper than " + std::to_string(DEEPEST_TREE));
            const tinygltf::Node& node = document_.model.nodes[static_cast<size_t>(step.node)];
            const dmat4 toWorld = step.toWorld * localTransform(node);
            visitor(node, step.node, toWorld);
            for (size_t i = node.children.size(); i-- > 0;) steps.push_back({node.children[i], toWorld, step.depth + 1});
        }
    }

    /// Where the scene has its own origin: by the boxes that the file says its meshes have, and by its first camera.
    dvec3 originOf(const std::vector<int>& roots) const {
        FarBox box;
        std::optional<dvec3> camera;
        visit(roots, dmat4(1.0), [&](const tinygltf::Node& node, int index, const dmat4& toWorld) {
            if (node.camera >= 0 && !camera) camera = dvec3(toWorld[3]);
            const auto shape = node.extensions.find(SHAPES);
            if (shape != node.extensions.end()) addShapeBounds(shape->second, index, toWorld, box);
            if (node.mesh < 0) return;
            for (const tinygltf::Primitive& primitive : document_.model.meshes[static_cast<size_t>(node.mesh)].primitives)
                addBounds(primitive, toWorld, box);
        });
        const dvec3 origin = heliograph::originOf(box);
        return origin == dvec3(0.0) && camera ? originNear(*camera) : origin;
    }

    void addBounds(const tinygltf::Primitive& primitive, const dmat4& toWorld, FarBox& box) const {
        const auto found = primitive.attributes.find("POSITION");
        if (found == primitive.attributes.end()) return;
        const tinygltf::Accessor& accessor = document_.model.accessors[static_cast<size_t>(found->second)];
        const std::vector<double>* ends[] = {&accessor.minValues, &accessor.maxValues};
        if (ends[0]->size() != 3 || ends[1]->size() != 3) return;
        const double unit = accessor.normalized ? largestOf(accessor.componentType) : 1.0;
        for (unsigned corner = 0; corner < 8; corner++) {
            glm::dvec4 at(0.0, 0.0, 0.0, 1.0);
            for (unsigned k = 0; k < 3; k++) at[static_cast<int>(k)] = (*ends[corner >> k & 1])[k] / unit;
            box.add(dvec3(toWorld * at));
        }
    }

    /// The corners of a shape's box, or where a plane passes.
    void addShapeBounds(const tinygltf::Value& extension, int index, const dmat4& toWorld, FarBox& box) const {
        const GltfShape shape = readGltfShape(extension, document_.at(shapePointer(index)), builder_);
        const double reach = shape.form.kind == SHAPE_PLANE ? 0.0 : 1.0;
        for (unsigned corner = 0; corner < 8; corner++) {
            glm::dvec4 at(0.0, 0.0, 0.0, 1.0);
            for (unsigned k = 0; k < 3; k++)
                at[static_cast<int>(k)] = (corner >> k & 1 ? reach : -reach) * shape.size[static_cast<int>(k)];
            box.add(dvec3(toWorld * at));
        }
    }

    static std::string pointerOf(int node) { return "/nodes/" + std::to_string(node); }
    static std::string shapePointer(int node) { return pointerOf(node) + "/extensions/" + SHAPES; }

    /// The default scene's roots; without scenes every node that is nobody's child.
    std::vector<int> rootNodes() const {
        const tinygltf::Model& model = document_.model;
        if (!model.scenes.empty())
            return model.scenes[model.defaultScene >= 0 ? static_cast<size_t>(model.defaultScene) : 0].nodes;
        if (!model.nodes.empty()) builder_.warn("the file has no scene: all its nodes are shown");
        std::vector<bool> isChild(model.nodes.size(), false);
        for (const tinygltf::Node& node : model.nodes) {
            for (int child : node.children) isChild[static_cast<size_t>(child)] = true;
        }
        std::vector<int> roots;
        for (size_t i = 0; i < model.nodes.size(); i++) {
            if (!isChild[i]) roots.push_back(static_cast<int>(i));
        }
        return roots;
    }

    void place(const tinygltf::Node& node, int index, const dmat4& toWorld) {
        if (node.mesh >= 0) placeMesh(node, index, toWorld);
        if (node.camera >= 0) placeCamera(node, toWorld);
        const auto shape = node.extensions.find(SHAPES);
        if (shape != node.extensions.end()) placeShape(shape->second, node, index, toWorld);
        const auto light = node.extensions.find("KHR_lights_punctual");
        if (light != node.extensions.end()) placeLight(light->second, index, toWorld);
    }

    void placeMesh(const tinygltf::Node& node, int index, const dmat4& toWorld) {
        const std::vector<uint32_t>& parts = meshParts(node);
        placeParts(parts, node, index, toWorld, dmat4(1.0));
    }

    void placeShape(const tinygltf::Value& extension, const tinygltf::Node& node, int index, const dmat4& toWorld) {
        const GltfShape shape = readGltfShape(extension, document_.at(shapePointer(index)), builder_);
        const size_t material = shape.material >= 0 ? static_cast<size_t>(shape.material) : materials_.size() - 1;
        const auto [found, isNew] = shapes_.try_emplace({shape.form.kind, shape.form.capped, material});
        if (isNew) {
            reader_.account(VERTICES_OF_SHAPE, shapePointer(index));
            found->second.push_back(builder_.addShape(shape.form, materials_[material]));
        }
        placeParts(found->second, node, index, toWorld, glm::scale(dmat4(1.0), shape.size));
    }

    /// `size`: applied before all else.
    void placeParts(const std::vector<uint32_t>& parts, const tinygltf::Node& node, int index, const dmat4& toWorld,
                    const dmat4& size) {
        const auto crowd = node.extensions.find("EXT_mesh_gpu_instancing");
        const std::vector<dmat4> copies =
            crowd == node.extensions.end() ? std::vector<dmat4>{dmat4(1.0)} : instanceTransforms(crowd->second, index);
        instances_ += copies.size() * parts.size();
        if (instances_ > MOST_INSTANCES)
            throw InputError(document_.at(pointerOf(index)), "more than " + std::to_string(MOST_INSTANCES) + " instances");
        for (const dmat4& copy : copies) {
            for (uint32_t part : parts)
                builder_.addInstance(part, mat4(toWorld * copy * size), node.name.empty() ? pointerOf(index) : node.name);
        }
    }

    /// The builder's meshes for the mesh of a node, one per primitive. Nodes with the same mesh and weights share them.
    const std::vector<uint32_t>& meshParts(const tinygltf::Node& node) {
        const tinygltf::Mesh& mesh = document_.model.meshes[static_cast<size_t>(node.mesh)];
        const std::vector<double>& weights = node.weights.empty() ? mesh.weights : node.weights;
        const auto [found, isNew] = parts_.try_emplace({node.mesh, weights});
        if (!isNew) return found->second;
        for (size_t i = 0; i < mesh.primitives.size(); i++) {
            const tinygltf::Primitive& primitive = mesh.primitives[i];
            const std::string pointer = "/meshes/" + std::to_string(node.mesh) + "/primitives/" + std::to_string(i);
            MeshData data = reader_.read(primitive, weights, pointer);
            if (data.indices.empty()) continue;
            warnMissingSets(primitive, data, pointer);
            const size_t material = primitive.material >= 0 ? static_cast<size_t>(primitive.material) : materials_.size() - 1;
            data.materials.assign(data.indices.size(), materials_[material]);
            found->second.push_back(builder_.addMesh(std::move(data)));
        }
        return found->second;
    }

    void warnMissingSets(const tinygltf::Primitive& primitive, const MeshData& data, const std::string& pointer) {
        if (primitive.material < 0) return;
        const tinygltf::Material& m = document_.model.materials[static_cast<size_t>(primitive.material)];
        const auto check = [&](const TextureUse& use) {
            if (use.index < 0 || use.texCoord > 1) return;
            const bool missing = use.texCoord == 1 ? data.uv1.empty() : data.uv0.empty();
            if (missing)
                builder_.warn(pointer + " has no TEXCOORD_" + std::to_string(use.texCoord) + " for its material's texture");
        };
        check(TextureUse(m.pbrMetallicRoughness.baseColorTexture));
        check(TextureUse(m.pbrMetallicRoughness.metallicRoughnessTexture));
        check(TextureUse(m.normalTexture));
        check(TextureUse(m.emissiveTexture));
    }

    /// EXT_mesh_gpu_instancing: one transform per element of the attributes.
    std::vector<dmat4> instanceTransforms(const tinygltf::Value& extension, int node) {
        struct Attribute {
            const char* name;
            int components;
            std::unique_ptr<GltfAccessor> accessor;
        };
        Attribute attributes[] = {{"TRANSLATION", 3, nullptr}, {"ROTATION", 4, nullptr}, {"SCALE", 3, nullptr}};
        const std::string where = document_.at(pointerOf(node) + "/extensions/EXT_mesh_gpu_instancing/attributes");
        size_t count = 0;
        for (Attribute& attribute : attributes) {
            const int index = static_cast<int>(numberOf(extension.Get("attributes"), attribute.name, -1.0));
            if (index < 0) continue;
            attribute.accessor = std::make_unique<GltfAccessor>(document_, index);
            if (attribute.accessor->components() != attribute.components || attribute.accessor->isMatrix())
                throw InputError(where + "/" + attribute.name, std::to_string(attribute.accessor->components()) + " components",
                                 std::to_string(attribute.components));
            if (count != 0 && attribute.accessor->count() != count)
                throw InputError(where + "/" + attribute.name, std::to_string(attribute.accessor->count()) + " elements",
                                 std::to_string(count));
            count = attribute.accessor->count();
        }
        if (count > MOST_INSTANCES)
            throw InputError(where, std::to_string(count) + " instances", "at most " + std::to_string(MOST_INSTANCES));
        std::vector<dmat4> transforms(count);
        for (size_t i = 0; i < count; i++) {
            vec3 translation(0.0f), scale(1.0f);
            vec4 rotation(0.0f, 0.0f, 0.0f, 1.0f);
            if (attributes[0].accessor) attributes[0].accessor->readFloats(i, 3, false, &translation[0]);
            if (attributes[1].accessor) attributes[1].accessor->readFloats(i, 4, true, &rotation[0]);
            if (attributes[2].accessor) attributes[2].accessor->readFloats(i, 3, false, &scale[0]);
            transforms[i] = composed(dvec3(translation), dquat(rotation.w, rotation.x, rotation.y, rotation.z), dvec3(scale));
        }
        return transforms;
    }

    void placeCamera(const tinygltf::Node& node, const dmat4& toWorld) {
        const tinygltf::Camera& from = document_.model.cameras[static_cast<size_t>(node.camera)];
        const bool parallel = from.type == "orthographic";
        const double halfHeight = std::abs(from.orthographic.ymag);
        if ((from.type != "perspective" && !parallel) || (parallel && !(halfHeight >= 1e-9 && halfHeight <= 1e9))) {
            builder_.warn("camera '" + from.name + "' of type '" + from.type.substr(0, 40) + "' is not offered" +
                          (parallel ? ": ymag " + std::to_string(from.orthographic.ymag) + "; allowed: 1e-9 to 1e9" : ""));
            return;
        }
        NamedCamera camera;
        camera.name = !from.name.empty() ? from.name : !node.name.empty() ? node.name : "camera " + std::to_string(++cameras_);
        camera.position = vec3(toWorld[3]);
        camera.forward = direction(toWorld, 2, -1.0);
        camera.up = direction(toWorld, 1, 1.0);
        if (parallel) return builder_.addCamera(parallelCamera(camera, static_cast<float>(halfHeight)));
        camera.fieldOfView = static_cast<float>(from.perspective.yfov * 180.0 / std::numbers::pi);
        builder_.addCamera(camera);
    }

    void placeLight(const tinygltf::Value& extension, int node, const dmat4& toWorld) {
        const double index = numberOf(extension, "light", -1.0);
        if (index < 0.0) return;
        const std::string where = document_.at(pointerOf(node) + "/extensions/KHR_lights_punctual/light");
        if (!(index < double(document_.model.lights.size())))
            throw InputError(where, std::to_string(index), "an index below " + std::to_string(document_.model.lights.size()));
        const tinygltf::Light& from = document_.model.lights[static_cast<size_t>(index)];
        Light light{};
        light.position = vec3(toWorld[3]);
        light.direction = direction(toWorld, 2, -1.0);
        light.range = static_cast<float>(from.range);
        light.cosInner = 1.0f;
        if (index < double(document_.lightRadii.size())) light.radius = document_.lightRadii[static_cast<size_t>(index)];
        for (int i = 0; i < 3; i++)
            light.intensity[i] =
                static_cast<float>((from.color.size() == 3 ? from.color[static_cast<size_t>(i)] : 1.0) * from.intensity);
        if (from.type == "directional") {
            light.type = LIGHT_DIRECTIONAL;
        } else if (from.type == "point") {
            light.type = LIGHT_POINT;
            light.direction = vec3(0.0f, -1.0f, 0.0f);
        } else if (from.type == "spot") {
            light.type = LIGHT_SPOT;
            double outer = from.spot.outerConeAngle;
            if (outer < NARROWEST_SPOT) {
                builder_.warn("light '" + from.name + "': a cone narrower than 0.001 radians is drawn as wide as that");
                outer = NARROWEST_SPOT;
            }
            light.cosInner = static_cast<float>(std::cos(from.spot.innerConeAngle));
            light.cosOuter = static_cast<float>(std::cos(outer));
        } else {
            throw InputError(where, "light type '" + from.type.substr(0, 40) + "'", "directional, point or spot");
        }
        builder_.addLight(light);
    }

    const GltfDocument& document_;
    const std::vector<uint32_t>& materials_;
    SceneBuilder& builder_;
    const Progress& progress_;
    GltfMeshReader reader_;
    std::map<std::pair<int, std::vector<double>>, std::vector<uint32_t>> parts_;
    std::map<std::tuple<uint32_t, bool, size_t>, std::vector<uint32_t>> shapes_;  // by kind, caps and material of the file
    size_t instances_ = 0;
    int cameras_ = 0;
};

}  // namespace

void addGltfNodes(const GltfDocument& document, const std::vector<uint32_t>& materials, SceneBuilder& builder,
                  const Progress& progress) {
    NodeWalker(document, materials, builder, progress).walk();
}

}  // namespace heliograph
