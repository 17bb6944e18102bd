#include "server/scene/media/nested_media.h"

#include "server/scene/build/transform.h"
#include "server/scene/media/grown_walls.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace heliograph {

namespace {

constexpr uint64_t MOST_EXACT_POINTS = uint64_t(1) << 24;  // of boxes; beyond that the corners of the mesh's own box serve
constexpr uint64_t MOST_COMPARED = uint64_t(1) << 24;      // pairs of boxes; beyond that all bodies count as nested
constexpr double MOST_OF_BODY = 0x1p-11;                   // of its size a wall moves, however far from the origin it is

bool isBody(const Material& m) {
    return (m.flags & MATERIAL_VOLUME) != 0 && (m.flags & MATERIAL_UNLIT) == 0 && m.transmission > 0.0f && m.metallic < 1.0f;
}

/// What makes two media the same.
using Medium = std::array<double, 5>;  // priority, index of refraction, absorption
Medium mediumOf(const Material& m) {
    return {double(m.priority), double(m.ior), double(m.absorption.x), double(m.absorption.y), double(m.absorption.z)};
}

/// Triangles of one material in a mesh that is placed.
struct Body {
    uint32_t placed = 0;
    uint32_t material = 0;
    Bounds bounds;
    double reach = 0.0;  // of its farthest corner from the origin
    bool nested = false;
};

class Nesting {
public:
    explicit Nesting(SceneDraft& draft) : draft_(draft), scene_(draft.scene) {}

    void run() {
        for (uint32_t i = 0; i < draft_.placed.size(); i++) addBodies(i);
        if (bodies_.empty()) return;
        const bool touch = findNested();
        if (media_.size() > MOST_MEDIA) {
            if (touch)
                addWarning(draft_, std::to_string(media_.size()) + " media of bodies that stand in each other; at most " +
                                       std::to_string(MOST_MEDIA) + ": each is drawn as if in air");
            return;
        }
        number();
        if (!touch) return;
        for (const Body& body : bodies_) {
            scene_.nestedBodies += body.nested;
            scene_.bodyBounds.push_back(body.bounds);
        }
        growWalls();
    }

private:
    void addBodies(uint32_t placed) {
        const PlacedMesh& place = draft_.placed[placed];
        const MeshData& mesh = draft_.meshes[place.mesh];
        const Placement placement = placementOf(place.toWorld);
        if (!placement.finite) return;
        points_ += mesh.indices.size() * 3;
        std::map<uint32_t, double> volumes;  // six times, in the mesh's space, by material
        std::map<uint32_t, Bounds> local;
        for (size_t t = 0; t < mesh.indices.size(); t++) {
            const uint32_t material = mesh.materials.empty() ? 0 : mesh.materials[t];
            if (!isBody(scene_.materials[material])) continue;
            const vec3 a = mesh.positions[mesh.indices[t].x], b = mesh.positions[mesh.indices[t].y],
                       c = mesh.positions[mesh.indices[t].z];
            volumes[material] += glm::dot(dvec3(a), glm::cross(dvec3(b), dvec3(c)));
            for (vec3 p : {a, b, c}) local[material].grow(points_ < MOST_EXACT_POINTS ? vec3(placement.point(p)) : p);
        }
        for (const auto& [material, volume] : volumes) {
            Body body{placed, material, local[material]};
            if (points_ >= MOST_EXACT_POINTS) body.bounds = boxOf(placement, local[material]);
            body.reach = glm::length(dvec3(glm::max(glm::abs(body.bounds.low), glm::abs(body.bounds.high))));
            bodies_.push_back(body);
            double& largest = media_[mediumOf(scene_.materials[material])];
            largest = std::max(largest, std::abs(volume * placement.determinant));
        }
    }

    static Bounds boxOf(const Placement& placement, const Bounds& box) {
        Bounds bounds;
        for (int i = 0; i < 8; i++)
            bounds.grow(vec3(placement.point(
                vec3(i & 1 ? box.high.x : box.low.x, i & 2 ? box.high.y : box.low.y, i & 4 ? box.high.z : box.low.z))));
        return bounds;
    }

    static bool touching(const Body& a, const Body& b) {
        const auto slack = static_cast<float>(4.0 * WALL_OVERLAP * std::max(a.reach, b.reach));
        const bool before = glm::any(glm::greaterThan(a.bounds.low - slack, b.bounds.high));
        return !before && !glm::any(glm::greaterThan(b.bounds.low - slack, a.bounds.high));
    }

    /// Marks bodies whose box touches that of another; true if there are two media among them that touch.
    bool findNested() {
        std::ranges::stable_sort(bodies_, {}, [](const Body& body) { return body.bounds.low.x; });
        bool several = false;
        uint64_t compared = 0;
        float widest = 0.0f;  // slack of the sweep
        for (const Body& body : bodies_) widest = std::max(widest, static_cast<float>(4.0 * WALL_OVERLAP * body.reach));
        for (size_t i = 0; i < bodies_.size(); i++) {
            for (size_t j = i + 1; j < bodies_.size() && bodies_[j].bounds.low.x - widest <= bodies_[i].bounds.high.x; j++) {
                if (++compared > MOST_COMPARED) {
                    for (Body& body : bodies_) body.nested = true;
                    return media_.size() > 1;
                }
                if (!touching(bodies_[i], bodies_[j])) continue;
                bodies_[i].nested = bodies_[j].nested = true;
                several |= mediumOf(scene_.materials[bodies_[i].material]) != mediumOf(scene_.materials[bodies_[j].material]);
            }
        }
        return several;
    }

    /// From 1, the lowest priority first; among equals the largest body.
    void number() {
        std::vector<std::pair<Medium, double>> order(media_.begin(), media_.end());
        std::ranges::stable_sort(order, [](const auto& a, const auto& b) {
            return a.first[0] != b.first[0] ? a.first[0] < b.first[0] : a.second > b.second;
        });
        std::map<Medium, uint32_t> numbers;
        for (size_t i = 0; i < order.size(); i++) numbers[order[i].first] = static_cast<uint32_t>(i + 1);
        for (uint32_t m = static_cast<uint32_t>(scene_.materials.size()); m-- > 0;) {
            Material& material = scene_.materials[m];
            const auto found = numbers.find(mediumOf(material));
            if (!isBody(material) || found == numbers.end()) continue;
            material.medium = found->second;
            scene_.materials[found->second - 1].mediumMaterial = m;  // of several the first stays
        }
    }

    void growWalls() {
        std::map<std::pair<uint32_t, uint32_t>, double> distances;  // by mesh and material, in the mesh's space
        for (const Body& body : bodies_) {
            if (!body.nested) continue;
            const Placement placement = placementOf(draft_.placed[body.placed].toWorld);
            const double shortest = std::min(
                {glm::length(placement.linear[0]), glm::length(placement.linear[1]), glm::length(placement.linear[2])});
            if (!(shortest > 0.0)) continue;
            const double rank = double(scene_.materials[body.material].medium) / double(media_.size());
            double& distance = distances[{draft_.placed[body.placed].mesh, body.material}];
            const double size = glm::length(dvec3(body.bounds.high) - dvec3(body.bounds.low));
            distance = std::max(distance, std::min(body.reach * WALL_OVERLAP * (1.0 + rank), size * MOST_OF_BODY) / shortest);
        }
        for (const auto& [key, distance] : distances) {
            MeshData& mesh = draft_.meshes[key.first];
            if (!mesh.shape) moveWalls(mesh, key.second, distance);
        }
    }

    SceneDraft& draft_;
    Scene& scene_;
    std::vector<Body> bodies_;
    std::map<Medium, double> media_;  // six times the volume of the largest body
    uint64_t points_ = 0;
};

}  // namespace

void nestMedia(SceneDraft& draft) { Nesting(draft).run(); }

}  // namespace heliograph
