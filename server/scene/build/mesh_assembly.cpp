#include "server/scene/build/mesh_assembly.h"

#include "server/base/error.h"
#include "server/scene/build/shape_mesh.h"
#include "server/scene/build/transform.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <sstream>

namespace heliograph {

namespace {

// Float has 24 bits: beyond this ratio of distance to size, baking would leave under 14 bits for the shape.
constexpr double FARTHEST_BAKED = 1e3;
constexpr double SMALLEST_SIZE = 1e-18, LARGEST_SIZE = 1e18;
constexpr uint64_t MOST_NAMED = 8;  // instances that are left out
// Copies of shared meshes made because an instance has no inverse, in triangles.
constexpr uint64_t MOST_COPIED_TRIANGLES = uint64_t(1) << 24;

Bounds boundsOf(std::span<const vec3> points, const Placement& placement) {
    return tbb::parallel_reduce(
        tbb::blocked_range<size_t>(0, points.size(), 8192), Bounds{},
        [&](const tbb::blocked_range<size_t>& range, Bounds bounds) {
            for (size_t i = range.begin(); i < range.end(); i++) bounds.grow(vec3(placement.point(points[i])));
            return bounds;
        },
        [](Bounds a, const Bounds& b) {
            if (!b.empty()) a.grow(b.low), a.grow(b.high);
            return a;
        });
}

bool farFromOrigin(const Bounds& bounds) {
    const double extent = glm::length(glm::dvec3(bounds.high) - glm::dvec3(bounds.low));
    return glm::length(glm::dvec3(bounds.center())) > FARTHEST_BAKED * extent;
}

/// A colour as VertexAttributes has it and what that leaves: see unpackColor in shaders/kernel/surface.glsl.
struct PackedColor {
    uint32_t word = 0xffffffffu;
    float rest = 0.0f;
};

PackedColor packed(vec4 color) {
    const auto shares = [](float x) { return static_cast<uint32_t>(std::lround(std::clamp(x, 0.0f, 1.0f) * (255.0 * 256.0))); };
    const uint32_t r = shares(color.x), g = shares(color.y), b = shares(color.z);
    const uint32_t a = static_cast<uint32_t>(std::lround(std::clamp(color.w, 0.0f, 1.0f) * 255.0f));
    return {r >> 8 | g >> 8 << 8 | b >> 8 << 16 | a << 24, static_cast<float>((r & 255u) | (g & 255u) << 8 | (b & 255u) << 16)};
}

/// An instance of a shared mesh or of a shape.
struct PlacedCopy {
    uint32_t shared = 0;  // index into the shared copies
    Placement placement;
    const PlacedMesh* source = nullptr;
    std::optional<ShapeSpace> shape{};
};

/// One copy of a mesh in the scene's arrays.
struct Copy {
    const MeshData* mesh = nullptr;
    const std::string* name = nullptr;  // of the one that is placed; of shared ones nothing
    Placement placement;                // identity where the copy stays in object space
    vec3 begin{0.0f};                   // where that begins
    uint64_t firstVertex = 0;
    std::array<uint64_t, 3> triangles{};      // by opacity class
    std::array<uint64_t, 3> firstTriangle{};  // by opacity class
};

class Assembler {
public:
    Assembler(SceneDraft& draft, const std::vector<uint32_t>& opacity)
        : draft_(draft), scene_(draft.scene), opacity_(opacity) {}

    void assemble() {
        choose();
        layOut();
        for (const Copy& copy : baked_) write(copy);
        for (const Copy& copy : shared_) write(copy);
        for (const Mesh& mesh : scene_.meshes) dropCoincident(mesh);
        placeInstances();
        report();
        draft_.meshes = {};
        draft_.placed = {};
    }

private:
    /// Decides for every placed mesh: baked, instance or dropped.
    void choose() {
        std::vector<uint32_t> uses(draft_.meshes.size(), 0);
        for (const PlacedMesh& placed : draft_.placed) uses[placed.mesh]++;
        sharedIndex_.assign(draft_.meshes.size(), {NO_INDEX, NO_INDEX});
        for (const PlacedMesh& placed : draft_.placed) {
            const MeshData& mesh = draft_.meshes[placed.mesh];
            if (mesh.indices.empty()) continue;
            const Placement placement = placementOf(placed.toWorld);
            if (!placement.finite || placement.collapsed()) {
                drop(placed);
                continue;
            }
            const Bounds bounds = instanceBounds(mesh, placement, uses[placed.mesh]);
            if (!hasUsableSize(mesh, placement, bounds)) {
                drop(placed);
                continue;
            }
            if (mesh.shape) {
                (mesh.shape->kind == SHAPE_PLANE ? planes_ : shapes_).push_back({&placed, placement, bounds});
                continue;
            }
            bool bake = placement.identity ? uses[placed.mesh] == 1 : uses[placed.mesh] == 1 && !farFromOrigin(bounds);
            grow(scene_.bounds, bounds);
            if (bake) {
                baked_.push_back(copyOf(mesh, placement, &placed.name));
            } else {
                instances_.push_back({sharedCopy(placed.mesh, false), placement, &placed});
            }
        }
        growByShapes(scene_, shapes_, planes_);
        for (const PlacedShape& shape : shapes_) addShape(shape);
        for (const PlacedShape& plane : planes_) addShape(plane);
        copyUntraceable();
    }

    /// Index of the copy that instances of a mesh share. `pole`: of a ball, from there.
    uint32_t sharedCopy(uint32_t mesh, bool pole) {
        uint32_t& index = sharedIndex_[mesh][pole ? 1 : 0];
        if (index == NO_INDEX) {
            index = static_cast<uint32_t>(shared_.size());
            shared_.push_back(copyOf(draft_.meshes[mesh], Placement{}, nullptr));
            if (pole) shared_.back().begin.y = 1.0f;
        }
        return index;
    }

    void addShape(const PlacedShape& shape) {
        const PlacedMesh& placed = *shape.source;
        const MeshData& mesh = draft_.meshes[placed.mesh];
        if (!shape.placement.invertible) {  // flat: its triangles stand for it, of a plane there are none
            if (mesh.shape->kind == SHAPE_PLANE) drop(placed);
            else baked_.push_back(copyOf(mesh, shape.placement, &placed.name));
            return;
        }
        // A plane is drawn as far as rays go.
        const ShapeSpace space = shapeSpaceOf(*mesh.shape, shape.placement, 0.25 * double(scene_.rayReach()));
        instances_.push_back({sharedCopy(placed.mesh, (space.flags & SHAPE_POLE) != 0), space.placement, &placed, space});
    }

    /// Instances without a usable inverse, or in whose space the farthest rays would leave float, become copies.
    void copyUntraceable() {
        const float reach = scene_.rayReach();
        uint64_t copied = 0;
        std::erase_if(instances_, [&](const PlacedCopy& instance) {
            if (traceable(instance.placement, reach)) return false;
            const MeshData& mesh = *shared_[instance.shared].mesh;
            copied += mesh.indices.size();
            const bool endless = mesh.shape && mesh.shape->kind == SHAPE_PLANE;
            if (copied <= MOST_COPIED_TRIANGLES && !endless)
                baked_.push_back(copyOf(mesh, placementOf(instance.source->toWorld), &instance.source->name));
            else drop(*instance.source);
            return true;
        });
        dropUnusedShared();
    }

    /// Meshes of which no instance is left are not laid out.
    void dropUnusedShared() {
        std::vector<uint32_t> place(shared_.size(), NO_INDEX);
        for (const PlacedCopy& instance : instances_) place[instance.shared] = 0;
        uint32_t kept = 0;
        for (size_t i = 0; i < shared_.size(); i++) {
            if (place[i] == NO_INDEX) continue;
            if (i != kept) shared_[kept] = std::move(shared_[i]);
            place[i] = kept++;
        }
        shared_.resize(kept);
        for (PlacedCopy& instance : instances_) instance.shared = place[instance.shared];
    }

    /// Leaves it out and says so, by name for the first few.
    void drop(const PlacedMesh& placed) {
        if (dropped_++ >= MOST_NAMED) return;
        std::ostringstream text;
        text << "instance '" << placed.name << "' was left out: axes";
        for (int i = 0; i < 3; i++) {
            const vec4 axis = placed.toWorld[i];
            text << (i > 0 ? ", " : " ") << "[" << axis.x << ", " << axis.y << ", " << axis.z << "]";
        }
        text << "; allowed: finite, and a mesh of 1e-18 to 1e18 across";
        addWarning(draft_, text.str());
    }

    /// Squared lengths and areas of the mesh, as it stands in the world, are floats.
    static bool hasUsableSize(const MeshData& mesh, Placement placement, const Bounds& bounds) {
        if (!(glm::length(dvec3(bounds.low)) + glm::length(dvec3(bounds.high)) < LARGEST_SIZE)) return false;
        if (bounds.low != bounds.high) return sizeOf(bounds) > SMALLEST_SIZE;
        placement.offset = dvec3(0.0);  // smaller than the rounding of its place
        return sizeOf(boundsOf(mesh.positions, placement)) > SMALLEST_SIZE;
    }
    static double sizeOf(const Bounds& bounds) { return glm::length(dvec3(bounds.high) - dvec3(bounds.low)); }

    static void grow(Bounds& into, const Bounds& bounds) {
        if (bounds.empty()) return;
        into.grow(bounds.low);
        into.grow(bounds.high);
    }

    /// Exact, but for crowds of instances: those take the corners of the mesh's own box.
    Bounds instanceBounds(const MeshData& mesh, const Placement& placement, uint32_t uses) {
        if (static_cast<uint64_t>(uses) * mesh.positions.size() < uint64_t(1) << 26) return boundsOf(mesh.positions, placement);
        if (&mesh != boxed_) {
            boxed_ = &mesh;
            box_ = boundsOf(mesh.positions, Placement{});
        }
        Bounds bounds;
        for (int i = 0; i < 8; i++) {
            bounds.grow(vec3(placement.point(
                vec3(i & 1 ? box_.high.x : box_.low.x, i & 2 ? box_.high.y : box_.low.y, i & 4 ? box_.high.z : box_.low.z))));
        }
        return bounds;
    }

    uint32_t materialOf(const MeshData& mesh, size_t triangle) const {
        return mesh.materials.empty() ? 0 : mesh.materials[triangle];
    }

    static bool seeThrough(const MeshData& mesh) {
        return std::any_of(mesh.colors.begin(), mesh.colors.end(), [](vec4 c) { return c.w < 1.0f; });
    }

    /// Vertex alpha makes holes in a blended or cut-out material that would be solid by itself.
    uint32_t classOf(const MeshData& mesh, size_t triangle, bool alphaColors) const {
        const uint32_t material = materialOf(mesh, triangle), flags = scene_.materials[material].flags;
        if (alphaColors && (flags & MATERIAL_ALPHA_BLEND) != 0) return OPACITY_TRANSPARENT;
        if (alphaColors && (flags & MATERIAL_ALPHA_MASK) != 0 && opacity_[material] == OPACITY_OPAQUE) return OPACITY_MASKED;
        return opacity_[material];
    }

    Copy copyOf(const MeshData& mesh, const Placement& placement, const std::string* name) const {
        Copy copy;
        copy.mesh = &mesh;
        copy.name = name;
        copy.placement = placement;
        const bool alphaColors = seeThrough(mesh);
        for (size_t i = 0; i < mesh.indices.size(); i++) copy.triangles[classOf(mesh, i, alphaColors)]++;
        return copy;
    }

    /// Gives every copy its place and makes the Mesh entries: first the baked ones, by class, then the shared ones.
    void layOut() {
        uint64_t vertices = 0, triangles = 0;
        for (auto* copies : {&baked_, &shared_}) {
            for (Copy& copy : *copies) {
                copy.firstVertex = vertices;
                vertices += copy.mesh->positions.size();
                if (!copy.mesh->tangents.empty()) anyTangents_ = true;
            }
            if (copies == &baked_) bakedVertices_ = vertices;
        }
        for (int c = 0; c < 3; c++) {
            const uint64_t first = triangles;
            bool tangents = false;
            for (Copy& copy : baked_) {
                copy.firstTriangle[c] = triangles;
                if (copy.triangles[c] > 0) scene_.objects.addTriangles(static_cast<uint32_t>(triangles), *copy.name);
                triangles += copy.triangles[c];
                tangents |= copy.triangles[c] > 0 && !copy.mesh->tangents.empty();
            }
            bakedMesh_[c] = addMesh(first, triangles - first, 0, bakedVertices_, c, tangents);
        }
        sharedMesh_.resize(shared_.size());
        for (size_t i = 0; i < shared_.size(); i++) {
            Copy& copy = shared_[i];
            for (int c = 0; c < 3; c++) {
                copy.firstTriangle[c] = triangles;
                triangles += copy.triangles[c];
                sharedMesh_[i][c] = addMesh(copy.firstTriangle[c], copy.triangles[c], copy.firstVertex,
                                            copy.mesh->positions.size(), c, !copy.mesh->tangents.empty());
            }
        }
        if (triangles > MOST_TRIANGLES || vertices > MOST_VERTICES) {
            throw InputError(scene_.name,
                             std::to_string(triangles) + " triangles and " + std::to_string(vertices) + " vertices",
                             "at most " + std::to_string(MOST_TRIANGLES) + " of each");
        }
        scene_.positions.assign(vertices + 1, vec4(0.0f));  // one to spare: Embree reads 16 bytes at the last one
        scene_.attributes.resize(vertices);
        if (anyTangents_) scene_.tangents.assign(vertices, vec4(0.0f));
        scene_.triangles.resize(triangles);
    }

    uint32_t addMesh(uint64_t firstTriangle, uint64_t count, uint64_t firstVertex, uint64_t vertexCount, int opacity,
                     bool tangents) {
        if (count == 0) return NO_INDEX;
        Mesh mesh{};
        mesh.firstTriangle = static_cast<uint32_t>(firstTriangle);
        mesh.triangleCount = static_cast<uint32_t>(count);
        mesh.firstVertex = static_cast<uint32_t>(firstVertex);
        mesh.vertexCount = static_cast<uint32_t>(vertexCount);
        mesh.opacity = static_cast<uint32_t>(opacity);
        mesh.hasTangents = tangents ? 1 : 0;
        scene_.meshes.push_back(mesh);
        return static_cast<uint32_t>(scene_.meshes.size() - 1);
    }

    void write(const Copy& copy) {
        tbb::parallel_for(tbb::blocked_range<size_t>(0, copy.mesh->positions.size(), 4096),
                          [&](const tbb::blocked_range<size_t>& range) {
                              for (size_t i = range.begin(); i < range.end(); i++) writeVertex(copy, i);
                          });
        const MeshData& mesh = *copy.mesh;
        const bool alphaColors = seeThrough(mesh);
        const bool flip = copy.placement.determinant < 0.0;
        std::array<uint64_t, 3> at = copy.firstTriangle;
        const uint32_t base = static_cast<uint32_t>(copy.firstVertex);
        for (size_t i = 0; i < mesh.indices.size(); i++) {
            const uvec3 t = mesh.indices[i] + base;
            scene_.triangles[at[classOf(mesh, i, alphaColors)]++] =
                flip ? uvec4(t.x, t.z, t.y, materialOf(mesh, i)) : uvec4(t.x, t.y, t.z, materialOf(mesh, i));
        }
        if (!copy.placement.invertible) repairNormals(copy);
    }

    void writeVertex(const Copy& copy, size_t i) {
        const MeshData& mesh = *copy.mesh;
        const Placement& placement = copy.placement;
        const size_t at = copy.firstVertex + i;
        const PackedColor color = mesh.colors.empty() ? PackedColor{} : packed(mesh.colors[i]);
        scene_.positions[at] =
            vec4(placement.identity ? mesh.positions[i] - copy.begin : vec3(placement.point(mesh.positions[i])), color.rest);
        VertexAttributes attributes{};
        attributes.normal = placement.identity ? mesh.normals[i] : vec3(placement.normal(mesh.normals[i]));
        if (!mesh.uv0.empty()) attributes.u0 = mesh.uv0[i].x, attributes.v0 = mesh.uv0[i].y;
        if (!mesh.uv1.empty()) attributes.u1 = mesh.uv1[i].x, attributes.v1 = mesh.uv1[i].y;
        attributes.color = color.word;
        scene_.attributes[at] = attributes;
        if (!mesh.tangents.empty()) scene_.tangents[at] = turnedTangent(placement, mesh.tangents[i]);
    }

    static vec4 turnedTangent(const Placement& placement, vec4 tangent) {
        const dvec3 turned = placement.linear * dvec3(tangent.x, tangent.y, tangent.z);
        const double length = glm::length(turned);
        const float sign = placement.determinant < 0.0 ? -tangent.w : tangent.w;
        return length > 0.0 ? vec4(vec3(turned / length), sign) : vec4(0.0f, 0.0f, 0.0f, sign);
    }

    /// A flattening transform can leave a vertex normal of length 0: such a vertex takes the normal of a triangle at
    /// it.
    void repairNormals(const Copy& copy) {
        for (int c = 0; c < 3; c++) {
            for (uint64_t i = copy.firstTriangle[c]; i < copy.firstTriangle[c] + copy.triangles[c]; i++) {
                const uvec4 t = scene_.triangles[i];
                const auto corner = [&](uint32_t v) { return dvec3(vec3(scene_.positions[v])); };
                dvec3 normal = glm::cross(corner(t.y) - corner(t.x), corner(t.z) - corner(t.x));
                const double length = glm::length(normal);
                normal = length > 0.0 ? normal / length : dvec3(0.0, 1.0, 0.0);
                for (int k = 0; k < 3; k++) {
                    vec3& own = scene_.attributes[t[k]].normal;
                    if (own == vec3(0.0f)) own = vec3(normal);
                }
            }
        }
    }

    vec3 cornerOf(uint32_t triangle, int k) const { return vec3(scene_.positions[scene_.triangles[triangle][k % 3]]) + 0.0f; }

    /// Of triangles with the same corners one is drawn, the first, on every device and by every tree: the others lose their area.
    void dropCoincident(const Mesh& mesh) {
        std::vector<std::pair<uint64_t, uint32_t>> order(mesh.triangleCount);
        tbb::parallel_for(uint32_t(0), mesh.triangleCount, [&](uint32_t i) {
            for (int k = 0; k < 3; k++) {
                const uvec3 bits = glm::floatBitsToUint(cornerOf(mesh.firstTriangle + i, k));
                const uint64_t hash = (bits.x * 0x9e3779b97f4a7c15u ^ bits.y) * 0xbf58476d1ce4e5b9u ^ bits.z;
                order[i].first += (hash ^ hash >> 31) * 0x94d049bb133111ebu;  // whichever corner comes first
            }
            order[i].second = mesh.firstTriangle + i;
        });
        tbb::parallel_sort(order.begin(), order.end());
        constexpr size_t MOST_IN_ONE_PLACE = 8;  // that are drawn; more are not compared
        std::vector<uint32_t> drawn;
        for (size_t i = 0; i < order.size(); i++) {
            if (i == 0 || order[i].first != order[i - 1].first) drawn.clear();
            const uint32_t own = order[i].second;
            const bool hidden = std::ranges::any_of(drawn, [&](uint32_t other) { return hides(mesh, other, own); });
            if (hidden) scene_.triangles[own] = uvec4(uvec3(scene_.triangles[own].x), scene_.triangles[own].w), coincident_++;
            else if (drawn.size() < MOST_IN_ONE_PLACE) drawn.push_back(own);
        }
    }

    /// From both sides where both have one material without an inside. What has holes or lets light through hides its like alone.
    bool hides(const Mesh& mesh, uint32_t first, uint32_t second) const {
        const vec3 a = cornerOf(first, 0), b = cornerOf(first, 1), c = cornerOf(first, 2);
        int k = 0;
        while (k < 3 && cornerOf(second, k) != a) k++;
        const vec3 next = cornerOf(second, k + 1), last = cornerOf(second, k + 2);
        const bool turned = next == c && last == b;
        if (k == 3 || a == b || b == c || c == a || (!turned && (next != b || last != c))) return false;
        const uint32_t material = scene_.triangles[first].w;
        if (material != scene_.triangles[second].w) return !turned && mesh.opacity == OPACITY_OPAQUE;
        return !turned || (scene_.materials[material].flags & MATERIAL_VOLUME) == 0;
    }

    void placeInstances() {
        for (uint32_t mesh : bakedMesh_) {
            if (mesh != NO_INDEX) scene_.instances.push_back(instanceOf(Placement{}, mesh, scene_.meshes[mesh].firstTriangle));
        }
        for (const PlacedCopy& copy : instances_) {
            for (uint32_t mesh : sharedMesh_[copy.shared]) {
                if (mesh == NO_INDEX) continue;
                scene_.objects.addInstance(static_cast<uint32_t>(scene_.instances.size()), copy.source->name);
                scene_.instances.push_back(instanceOf(copy.placement, mesh, scene_.meshes[mesh].firstTriangle));
                if (copy.shape) makeShape(scene_.instances.back(), *copy.shape);
            }
        }
    }

    void makeShape(Instance& instance, const ShapeSpace& space) const {
        instance.flags = (instance.flags & INSTANCE_MIRRORED) | space.flags;
        instance.flags |= scene_.meshes[instance.mesh].opacity * SHAPE_OPACITY;
        instance.toObject0.w = space.extra.x;
        instance.toObject1.w = space.extra.y;
        instance.toObject2.w = space.extra.z;
    }

    void report() {
        if (dropped_ > 0) {
            addWarning(draft_,
                       std::to_string(dropped_) + " instances were left out: their transform is not finite or leaves no area");
        }
        if (coincident_ > 0)
            addWarning(draft_,
                       std::to_string(coincident_) + " triangles lie exactly on others: of each place the first is drawn");
        if (!scene_.bounds.empty()) return;
        addWarning(draft_, "the scene has no triangles");
        scene_.bounds.low = vec3(-1.0f);
        scene_.bounds.high = vec3(1.0f);
    }

    SceneDraft& draft_;
    Scene& scene_;
    const std::vector<uint32_t>& opacity_;
    std::vector<Copy> baked_;
    std::vector<Copy> shared_;
    std::vector<std::array<uint32_t, 2>> sharedIndex_;  // draft mesh -> shared_, and as a ball from its pole
    std::vector<PlacedShape> shapes_;                   // but planes
    std::vector<PlacedShape> planes_;
    std::vector<PlacedCopy> instances_;
    std::array<uint32_t, 3> bakedMesh_{NO_INDEX, NO_INDEX, NO_INDEX};
    std::vector<std::array<uint32_t, 3>> sharedMesh_;
    uint64_t bakedVertices_ = 0;
    uint64_t dropped_ = 0;
    uint64_t coincident_ = 0;
    bool anyTangents_ = false;
    const MeshData* boxed_ = nullptr;  // the mesh that box_ belongs to
    Bounds box_;
};

}  // namespace

std::vector<uint32_t> opacityClasses(const Scene& scene, const std::vector<bool>& imageHasAlpha) {
    const auto hasAlpha = [&](uint32_t texture) { return texture != NO_INDEX && imageHasAlpha[scene.textures[texture].image]; };
    std::vector<uint32_t> classes;
    for (const Material& m : scene.materials) {
        uint32_t opacity = OPACITY_OPAQUE;
        const bool partial = m.baseColor.w < 1.0f || hasAlpha(m.baseTexture) || m.opacityTexture != NO_INDEX;
        if ((m.flags & MATERIAL_ALPHA_MASK) != 0 && (partial || m.alphaCutoff > 1.0f)) opacity = OPACITY_MASKED;
        if ((m.flags & MATERIAL_ALPHA_BLEND) != 0 && partial) opacity = OPACITY_TRANSPARENT;
        if (m.transmission > 0.0f) opacity = OPACITY_TRANSPARENT;
        classes.push_back(opacity);
    }
    return classes;
}

void assembleMeshes(SceneDraft& draft, const std::vector<uint32_t>& opacity) { Assembler(draft, opacity).assemble(); }

}  // namespace heliograph
