#include "server/scene/generate/generate.h"
#include "server/scene/shape.h"

#include "server/base/error.h"
#include "server/request/camera.h"
#include "tests/support/places.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <tuple>

namespace heliograph::TEST_FILE {
namespace {

std::shared_ptr<const Scene> generated(const std::string& name) {
    static std::map<std::string, std::shared_ptr<const Scene>> made;
    std::shared_ptr<const Scene>& scene = made[name];
    if (!scene) {
        SceneBuilder builder(name);
        generateScene(name, builder);
        scene = builder.finish();
    }
    return scene;
}

struct WorldTriangle {
    std::array<vec3, 3> corner;
    std::array<vec3, 3> normal;
    uint32_t material;
    uint32_t instance;
    vec3 cross() const { return glm::cross(corner[1] - corner[0], corner[2] - corner[0]); }
    vec3 center() const { return (corner[0] + corner[1] + corner[2]) / 3.0f; }
};

std::vector<WorldTriangle> worldTriangles(const Scene& scene) {
    std::vector<WorldTriangle> list;
    for (uint32_t i = 0; i < scene.instances.size(); ++i) {
        const Instance& instance = scene.instances[i];
        if (isShape(instance)) continue;
        const Mesh& mesh = scene.meshes[instance.mesh];
        const mat4 rows(instance.toWorld0, instance.toWorld1, instance.toWorld2, vec4(0, 0, 0, 1));
        const mat4 toWorld = glm::transpose(rows);
        const mat3 normals = glm::transpose(glm::inverse(mat3(toWorld)));
        for (uint32_t t = mesh.firstTriangle; t < mesh.firstTriangle + mesh.triangleCount; ++t) {
            const uvec4 triangle = scene.triangles[t];
            WorldTriangle world{.material = triangle.w, .instance = i};
            for (int c = 0; c < 3; ++c) {
                world.corner[size_t(c)] = vec3(toWorld * vec4(vec3(scene.positions[triangle[c]]), 1.0f));
                world.normal[size_t(c)] = glm::normalize(normals * scene.attributes[triangle[c]].normal);
            }
            list.push_back(world);
        }
    }
    return list;
}

std::string describe(const Scene& scene, const WorldTriangle& t) {
    std::ostringstream text;
    text << scene.materialNames[t.material] << " at (" << t.center().x << ", " << t.center().y << ", " << t.center().z << ")";
    return text.str();
}

// ---- triangles that lie on each other ----

using Flat = std::vector<glm::dvec2>;

double area(const Flat& polygon) {
    double sum = 0.0;
    for (size_t i = 0; i < polygon.size(); ++i) {
        const glm::dvec2 a = polygon[i], b = polygon[(i + 1) % polygon.size()];
        sum += a.x * b.y - a.y * b.x;
    }
    return 0.5 * sum;
}

/// Area common to two counter-clockwise triangles. Sutherland & Hodgman, "Reentrant Polygon Clipping" (1974).
double commonArea(Flat subject, const Flat& clip) {
    for (size_t e = 0; e < clip.size() && !subject.empty(); ++e) {
        const glm::dvec2 from = clip[e], to = clip[(e + 1) % clip.size()];
        auto side = [&](glm::dvec2 p) { return (to.x - from.x) * (p.y - from.y) - (to.y - from.y) * (p.x - from.x); };
        Flat kept;
        for (size_t i = 0; i < subject.size(); ++i) {
            const glm::dvec2 a = subject[i], b = subject[(i + 1) % subject.size()];
            const double sa = side(a), sb = side(b);
            if (sa >= 0.0) kept.push_back(a);
            if ((sa > 0.0 && sb < 0.0) || (sa < 0.0 && sb > 0.0)) kept.push_back(a + (b - a) * (sa / (sa - sb)));
        }
        subject = kept;
    }
    return subject.size() < 3 ? 0.0 : std::abs(area(subject));
}

/// The triangle in the plane of its two coordinates that vary most, counter-clockwise.
Flat flattened(const WorldTriangle& t, int dropped) {
    Flat flat;
    for (const vec3& c : t.corner) flat.push_back({double(c[(dropped + 1) % 3]), double(c[(dropped + 2) % 3])});
    if (area(flat) < 0.0) std::swap(flat[1], flat[2]);
    return flat;
}

float longestEdge(const WorldTriangle& t) {
    return std::max({glm::length(t.corner[1] - t.corner[0]), glm::length(t.corner[2] - t.corner[1]),
                     glm::length(t.corner[0] - t.corner[2])});
}

/// Pairs that lie in one plane (to `gap` metres) and share more than a strip of `width` metres along the smaller one.
/// Rounding makes neighbours share slivers of a micrometre.
std::vector<std::pair<size_t, size_t>> overlappingPairs(const std::vector<WorldTriangle>& list, float gap, double width) {
    using Key = std::tuple<int, int, int, int>;
    std::map<Key, std::vector<size_t>> planes;
    for (size_t i = 0; i < list.size(); ++i) {
        vec3 n = list[i].cross();
        const float length = glm::length(n);
        if (length < 1e-7f) continue;
        n /= length;
        const vec3 magnitude = glm::abs(n);
        const int largest =
            magnitude.x > magnitude.y ? (magnitude.x > magnitude.z ? 0 : 2) : (magnitude.y > magnitude.z ? 1 : 2);
        if (n[largest] < 0.0f) n = -n;
        const float d = glm::dot(n, list[i].center());
        // Two overlapping sets of slabs: planes closer than half a slab share at least one.
        for (int half = 0; half < 2; ++half) {
            const int slab = int(std::floor(d / (2.0f * gap) + 0.5f * float(half))) * 2 + half;
            planes[{int(std::lround(n.x * 1000.0f)), int(std::lround(n.y * 1000.0f)), int(std::lround(n.z * 1000.0f)), slab}]
                .push_back(i);
        }
    }
    std::set<std::pair<size_t, size_t>> found;
    for (auto& [key, members] : planes) {
        const vec3 n = glm::abs(vec3(float(std::get<0>(key)), float(std::get<1>(key)), float(std::get<2>(key))));
        const int dropped = n.x > n.y ? (n.x > n.z ? 0 : 2) : (n.y > n.z ? 1 : 2), axis = (dropped + 1) % 3;
        auto low = [&](size_t i, int a) {
            return std::min({list[i].corner[0][a], list[i].corner[1][a], list[i].corner[2][a]});
        };
        auto high = [&](size_t i, int a) {
            return std::max({list[i].corner[0][a], list[i].corner[1][a], list[i].corner[2][a]});
        };
        std::sort(members.begin(), members.end(), [&](size_t a, size_t b) { return low(a, axis) < low(b, axis); });
        const int other = (dropped + 2) % 3;
        for (size_t i = 0; i < members.size(); ++i) {
            const Flat flat = flattened(list[members[i]], dropped);
            for (size_t j = i + 1; j < members.size() && low(members[j], axis) < high(members[i], axis); ++j) {
                if (low(members[j], other) >= high(members[i], other) || high(members[j], other) <= low(members[i], other))
                    continue;
                const double edge = std::min(longestEdge(list[members[i]]), longestEdge(list[members[j]]));
                if (commonArea(flat, flattened(list[members[j]], dropped)) > width * edge)
                    found.insert(std::minmax(members[i], members[j]));
            }
        }
    }
    return {found.begin(), found.end()};
}

// ---- paths ----

float distanceToTriangle(vec3 p, const WorldTriangle& t) {
    // Closest point by Voronoi regions; C. Ericson, "Real-Time Collision Detection" (2005), 5.1.5.
    const vec3 a = t.corner[0], b = t.corner[1], c = t.corner[2], ab = b - a, ac = c - a, ap = p - a;
    const float d1 = glm::dot(ab, ap), d2 = glm::dot(ac, ap);
    if (d1 <= 0 && d2 <= 0) return glm::length(p - a);
    const vec3 bp = p - b;
    const float d3 = glm::dot(ab, bp), d4 = glm::dot(ac, bp);
    if (d3 >= 0 && d4 <= d3) return glm::length(p - b);
    const float vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return glm::length(p - (a + ab * (d1 / (d1 - d3))));
    const vec3 cp = p - c;
    const float d5 = glm::dot(ab, cp), d6 = glm::dot(ac, cp);
    if (d6 >= 0 && d5 <= d6) return glm::length(p - c);
    const float vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return glm::length(p - (a + ac * (d2 / (d2 - d6))));
    const float va = d3 * d6 - d5 * d4;
    if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return glm::length(p - (b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)))));
    const float sum = va + vb + vc;
    return sum > 0 ? glm::length(p - (a + ab * (vb / sum) + ac * (vc / sum))) : glm::length(p - a);
}

/// Index of the triangle nearest to p and its distance; looks no further than `reach`.
std::pair<float, size_t> nearest(const std::vector<WorldTriangle>& list, vec3 p, float reach) {
    std::pair<float, size_t> best{reach, list.size()};
    for (size_t i = 0; i < list.size(); ++i) {
        const auto& c = list[i].corner;
        const vec3 low = glm::min(c[0], glm::min(c[1], c[2])) - best.first,
                   high = glm::max(c[0], glm::max(c[1], c[2])) + best.first;
        if (glm::any(glm::lessThan(p, low)) || glm::any(glm::greaterThan(p, high))) continue;
        const float d = distanceToTriangle(p, list[i]);
        if (d < best.first) best = {d, i};
    }
    return best;
}

class GeneratedScene : public testing::TestWithParam<std::string> {
protected:
    static bool ofEffect() { return GetParam().starts_with("effects/"); }
};

TEST_P(GeneratedScene, HasAsManyTrianglesAsItsDescriptionSays) {
    static const std::map<std::string, std::pair<uint64_t, uint64_t>> range = {{"courtyard", {60000, 70000}},
                                                                               {"cathedral", {70000, 80000}},
                                                                               {"glass", {90000, 100000}},
                                                                               {"cornell", {30, 10000}},
                                                                               {"effects/shapes", {0, 0}}};
    const auto [low, high] =
        ofEffect() && !range.contains(GetParam()) ? std::pair<uint64_t, uint64_t>(30, 20000) : range.at(GetParam());
    EXPECT_GE(generated(GetParam())->triangleCount(), low);
    EXPECT_LE(generated(GetParam())->triangleCount(), high);
}

TEST_P(GeneratedScene, NeedsNoRepair) {
    const auto scene = generated(GetParam());
    EXPECT_TRUE(scene->warnings.empty()) << scene->warnings.front();
}

TEST_P(GeneratedScene, IsTheSameEveryTime) {
    SceneBuilder builder(GetParam());
    generateScene(GetParam(), builder);
    EXPECT_EQ(builder.finish()->contentHash, generated(GetParam())->contentHash);
}

TEST_P(GeneratedScene, FitsItsMemory) { EXPECT_LE(generated(GetParam())->texels.size() * 4, size_t(26) << 20); }

TEST_P(GeneratedScene, HasLightsCamerasAndAPath) {
    const auto scene = generated(GetParam());
    EXPECT_FALSE(scene->lights.empty());
    EXPECT_GE(scene->cameras.size(), 2u);
    ASSERT_FALSE(scene->paths.empty());
    for (const CameraPath& path : scene->paths) {
        EXPECT_TRUE(path.closed) << path.name;
        EXPECT_GE(path.seconds, 10.0f) << path.name;
        EXPECT_LE(path.seconds, 20.0f) << path.name;
    }
    EXPECT_GT(scene->aoRadius, 0.0f);
}

TEST_P(GeneratedScene, HasNoTwoSurfacesInOnePlaceOfAPlane) {
    const auto scene = generated(GetParam());
    const std::vector<WorldTriangle> list = worldTriangles(*scene);
    const auto pairs = overlappingPairs(list, 1e-4f, 2e-5);
    std::string text;
    for (size_t i = 0; i < std::min<size_t>(pairs.size(), 8); ++i)
        text += "\n  " + describe(*scene, list[pairs[i].first]) + " and " + describe(*scene, list[pairs[i].second]);
    EXPECT_EQ(pairs.size(), 0u) << text;
}

TEST_P(GeneratedScene, HasNormalsOnTheSideOfTheFaces) {
    const auto scene = generated(GetParam());
    size_t wrong = 0;
    std::string first;
    for (const WorldTriangle& t : worldTriangles(*scene)) {
        if (scene->materialNames[t.material] == "leaves") continue;  // lit as the ball of their crown, not as blades
        const vec3 face = t.cross();
        if (glm::length(face) < 1e-9f) continue;
        if (glm::dot(face, t.normal[0] + t.normal[1] + t.normal[2]) > 0.0f) continue;
        if (wrong++ == 0) first = describe(*scene, t);
    }
    EXPECT_EQ(wrong, 0u) << first;
}

TEST_P(GeneratedScene, HasClosedGlassBodies) {
    const auto scene = generated(GetParam());
    using Corner = std::tuple<float, float, float>;
    std::map<std::pair<uint32_t, uint32_t>, std::map<std::pair<Corner, Corner>, int>> bodies;  // (instance, material): edges
    std::map<std::pair<uint32_t, uint32_t>, double> volume;
    for (const WorldTriangle& t : worldTriangles(*scene)) {
        if ((scene->materials[t.material].flags & MATERIAL_VOLUME) == 0) continue;
        const auto body = std::make_pair(t.instance, t.material);
        for (size_t c = 0; c < 3; ++c) {
            auto key = [](vec3 p) { return Corner{p.x, p.y, p.z}; };
            const Corner a = key(t.corner[c]), b = key(t.corner[(c + 1) % 3]);
            if (a < b) bodies[body][{a, b}] += 1;
            else bodies[body][{b, a}] -= 1;
        }
        volume[body] += double(glm::dot(t.corner[0], glm::cross(t.corner[1], t.corner[2]))) / 6.0;
    }
    for (const auto& [body, edges] : bodies) {
        const auto open = std::count_if(edges.begin(), edges.end(), [](const auto& edge) { return edge.second != 0; });
        EXPECT_EQ(open, 0) << scene->materialNames[body.second] << ", instance " << body.first;
        EXPECT_GT(volume[body], 0.0) << scene->materialNames[body.second] << " is inside out";
    }
    const bool bodied = GetParam() == "effects/nested-glass" || GetParam() == "effects/layers";
    EXPECT_EQ(bodies.empty(), GetParam() == "courtyard" || GetParam() == "cathedral" || (ofEffect() && !bodied));
}

TEST_P(GeneratedScene, KeepsItsCamerasAndPathsClearOfEverything) {
    const auto scene = generated(GetParam());
    const std::vector<WorldTriangle> list = worldTriangles(*scene);
    const float clearance = GetParam() == "glass" ? 0.01f : (GetParam() == "cornell" ? 0.05f : 0.15f);
    auto check = [&](const std::string& what, vec3 p) {
        const auto [distance, index] = nearest(list, p, clearance);
        if (index == list.size()) return true;
        ADD_FAILURE() << what << " (" << p.x << ", " << p.y << ", " << p.z << ") is " << distance << " m from "
                      << describe(*scene, list[index]);
        return false;
    };
    for (const NamedCamera& camera : scene->cameras) check(camera.name, camera.position);
    for (const CameraPath& path : scene->paths) {
        for (int i = 0; i < 400; ++i) {
            if (!check(path.name + " " + std::to_string(i / 4) + " %", cameraOnPath(path, i / 400.0, 60.0f).position)) break;
        }
    }
}

TEST_P(GeneratedScene, IsDescribedAsItIs) {
    std::ifstream file(sourceFolder() / "scenes/README.md");
    std::string line, rows;
    while (std::getline(file, line))
        if (line.starts_with("| `" + GetParam() + "`")) rows += line + "\n";
    const auto scene = generated(GetParam());
    for (const NamedCamera& camera : scene->cameras) EXPECT_NE(rows.find(camera.name), std::string::npos) << camera.name;
    for (const CameraPath& path : scene->paths) {
        const std::string text = path.name + " (" + std::to_string(int(path.seconds)) + ")";
        EXPECT_NE(rows.find(text), std::string::npos) << text;
    }
}

std::vector<std::string> names() {
    std::vector<std::string> list;
    for (const SceneRecipe& recipe : generatedRecipes()) list.push_back(recipe.name);
    return list;
}

INSTANTIATE_TEST_SUITE_P(All, GeneratedScene, testing::ValuesIn(names()), [](const auto& info) {
    std::string word = info.param;
    std::replace_if(
        word.begin(), word.end(), [](char c) { return c == '/' || c == '-'; }, '_');
    return word;
});

TEST(GenerateScene, NamesTheKnownScenesForAnUnknownOne) {
    SceneBuilder builder("castle");
    try {
        generateScene("castle", builder);
        FAIL() << "accepted";
    } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("courtyard"), std::string::npos) << error.what();
    }
}

TEST(OverlappingPairs, FindsFacesThatLieOnEachOtherAndNotThoseThatTouch) {
    auto triangle = [](vec3 a, vec3 b, vec3 c) { return WorldTriangle{.corner = {a, b, c}, .material = 0, .instance = 0}; };
    const WorldTriangle a = triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    EXPECT_EQ(overlappingPairs({a, triangle({0.2f, 0.2f, 0}, {0, 1, 0}, {1, 0, 0})}, 1e-4f, 2e-5).size(), 1u);
    EXPECT_EQ(
        overlappingPairs({a, triangle({0.1f, 0.1f, 0.00002f}, {0.1f, 0.9f, 0.00002f}, {0.9f, 0.1f, 0.00002f})}, 1e-4f, 2e-5)
            .size(),
        1u);
    EXPECT_EQ(overlappingPairs({a, triangle({1, 1, 0}, {0, 1, 0}, {1, 0, 0})}, 1e-4f, 2e-5).size(), 0u);
    EXPECT_EQ(
        overlappingPairs({a, triangle({0.1f, 0.1f, 0.001f}, {0.9f, 0.1f, 0.001f}, {0.1f, 0.9f, 0.001f})}, 1e-4f, 2e-5).size(),
        0u);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
