#include "server/device/vulkan/tree/bvh_builder.h"

#include "server/base/error.h"
#include "server/device/vulkan/tree/bvh_tree.h"
#include "server/scene/shape.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <stdexcept>

namespace heliograph {

namespace {

struct EmbreeBuilder {
    RTCDevice device = rtcNewDevice("set_affinity=0");
    EmbreeBuilder() {
        if (!device) throw std::runtime_error("Embree could not start");
    }
    ~EmbreeBuilder() { rtcReleaseDevice(device); }
    EmbreeBuilder(const EmbreeBuilder&) = delete;
};

RTCBuildPrimitive primitiveOf(vec3 low, vec3 high, uint32_t geometry, uint32_t primitive) {
    return {low.x, low.y, low.z, geometry, high.x, high.y, high.z, primitive};
}

// Boxes of a mesh's triangles, as modelled.
void addTriangles(const Scene& scene, const Mesh& mesh, uint32_t geometry, RTCBuildPrimitive* out) {
    tbb::parallel_for(0u, mesh.triangleCount, [&](uint32_t i) {
        uvec4 corners = scene.triangles[size_t(mesh.firstTriangle) + i];
        vec3 a = vec3(scene.positions[corners.x]);
        vec3 b = vec3(scene.positions[corners.y]);
        vec3 c = vec3(scene.positions[corners.z]);
        out[i] = primitiveOf(glm::min(glm::min(a, b), c), glm::max(glm::max(a, b), c), geometry, i);
    });
}

Box meshBox(const Scene& scene, const Mesh& mesh) {
    Box box;
    for (uint32_t i = 0; i < mesh.triangleCount; i++)
        for (int corner = 0; corner < 3; corner++) {
            vec3 p = vec3(scene.positions[scene.triangles[size_t(mesh.firstTriangle) + i][corner]]);
            box.grow({p, p});
        }
    return box;
}

// World box of a placed mesh, wider by more than what the transform of a ray into the mesh loses.
Box placedBox(const Instance& instance, const Box& mesh) {
    const vec4 rows[3] = {instance.toWorld0, instance.toWorld1, instance.toWorld2};
    Box box;
    for (int axis = 0; axis < 3; axis++) {
        double low = rows[axis].w, high = rows[axis].w, size = std::abs(double(rows[axis].w));
        for (int i = 0; i < 3; i++) {
            double a = double(rows[axis][i]) * mesh.low[i], b = double(rows[axis][i]) * mesh.high[i];
            low += std::min(a, b);
            high += std::max(a, b);
            size += std::max(std::abs(a), std::abs(b));
        }
        double slack = 4e-6 * size;
        box.low[axis] = static_cast<float>(low - slack);
        box.high[axis] = static_cast<float>(high + slack);
    }
    return box;
}

bool isPlaced(const Instance& instance) { return (instance.flags & INSTANCE_IDENTITY) == 0; }

std::vector<RTCBuildPrimitive> rootPrimitives(const Scene& scene) {
    std::vector<Box> boxes(scene.meshes.size());
    std::vector<bool> boxed(scene.meshes.size(), false);
    std::vector<size_t> starts;
    size_t total = 0;
    for (const Instance& instance : scene.instances) {
        const Mesh& mesh = scene.meshes[instance.mesh];
        starts.push_back(total);
        if (mesh.triangleCount > 0) total += isPlaced(instance) ? 1 : mesh.triangleCount;
    }
    std::vector<RTCBuildPrimitive> primitives(total);
    for (uint32_t i = 0; i < scene.instances.size(); i++) {
        const Instance& instance = scene.instances[i];
        const Mesh& mesh = scene.meshes[instance.mesh];
        if (mesh.triangleCount == 0) continue;
        if (!isPlaced(instance)) {
            addTriangles(scene, mesh, i, &primitives[starts[i]]);
            continue;
        }
        if (isShape(instance)) {
            const Bounds box = shapeBounds(instance);
            primitives[starts[i]] = primitiveOf(box.low, box.high, TreeNode::INSTANCE_MARK, i);
            continue;
        }
        if (!boxed[instance.mesh]) boxes[instance.mesh] = meshBox(scene, mesh);
        boxed[instance.mesh] = true;
        Box box = placedBox(instance, boxes[instance.mesh]);
        primitives[starts[i]] = primitiveOf(box.low, box.high, TreeNode::INSTANCE_MARK, i);
    }
    return primitives;
}

struct Part {
    BinaryTree tree;
    TreeLayout layout;
    uint32_t mesh;
};

Part makePart(RTCDevice device, std::vector<RTCBuildPrimitive> primitives, uint32_t mesh, const BvhOptions& options) {
    BinaryTree tree(device, primitives, std::min(options.maxLeaf, MAX_LEAF), options.quality);
    TreeLayout layout(tree.root(), options.width);
    return {std::move(tree), layout, mesh};
}

void checkSize(const Scene& scene) {
    uint64_t triangles = 0;
    for (const Instance& instance : scene.instances)
        if (!isPlaced(instance)) triangles += scene.meshes[instance.mesh].triangleCount;
    triangles += scene.triangles.size();
    if (triangles >= MAX_TRIANGLES)
        throw InputError("scene", std::to_string(triangles) + " triangles", "fewer than " + std::to_string(MAX_TRIANGLES));
}

}  // namespace

Bvh buildBvh(const Scene& scene, const BvhOptions& options, const Progress& progress) {
    checkSize(scene);
    report(progress, "building the acceleration structure", 0.0);
    EmbreeBuilder embree;
    std::vector<Part> parts;
    parts.push_back(makePart(embree.device, rootPrimitives(scene), NO_INDEX, options));
    Bvh bvh;
    bvh.width = options.width;
    bvh.meshRoots.assign(scene.meshes.size(), NO_INDEX);
    std::vector<bool> placed(scene.meshes.size(), false);
    for (const Instance& instance : scene.instances) {
        const Mesh& mesh = scene.meshes[instance.mesh];
        if (!isPlaced(instance) || isShape(instance) || mesh.triangleCount == 0 || placed[instance.mesh]) continue;
        placed[instance.mesh] = true;
        std::vector<RTCBuildPrimitive> primitives(mesh.triangleCount);
        addTriangles(scene, mesh, NO_INDEX, primitives.data());
        parts.push_back(makePart(embree.device, std::move(primitives), instance.mesh, options));
    }
    report(progress, "writing the acceleration structure", 0.6);
    size_t nodes = 0, triangles = 0, meshDepth = 0;
    std::vector<std::pair<uint32_t, uint32_t>> begins;
    for (const Part& part : parts) {
        begins.emplace_back(static_cast<uint32_t>(nodes), static_cast<uint32_t>(triangles));
        if (part.mesh != NO_INDEX) {
            bvh.meshRoots[part.mesh] = static_cast<uint32_t>(nodes);
            meshDepth = std::max<size_t>(meshDepth, part.layout.depth());
        }
        nodes += part.layout.nodes();
        triangles += part.layout.triangles();
    }
    if (options.width == 4 && nodes >= MAX_WIDE_NODES)
        throw InputError("scene", std::to_string(nodes) + " nodes of the tree", "fewer than " + std::to_string(MAX_WIDE_NODES));
    bvh.nodes = Words16(nodes * WORDS16_PER_NODE);
    bvh.triangles = Words16(triangles * WORDS16_PER_TRIANGLE);
    for (size_t i = 0; i < parts.size(); i++)
        parts[i].layout.emit(scene, parts[i].mesh, bvh, begins[i].first, begins[i].second);
    // A node leaves at most one entry behind; beside them the end mark and, inside an instance, the way out.
    bvh.stackDepth = static_cast<uint32_t>(parts[0].layout.depth() + meshDepth + 2 + 1);
    return bvh;
}

}  // namespace heliograph
