#include "server/scene/load/polygon.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace heliograph::TEST_FILE {
namespace {

using glm::dvec3;

dvec3 doubled(const std::vector<dvec3>& corners, const uvec3& t) {
    return glm::cross(corners[t.y] - corners[t.x], corners[t.z] - corners[t.x]);
}

/// The triangles cover the polygon once: all turn as it does, and their areas add up to its.
void expectCovered(const std::vector<dvec3>& corners, PolygonCutter& cutter) {
    dvec3 whole(0.0);
    for (size_t i = 0; i < corners.size(); i++)
        whole += glm::cross(corners[i] - corners[0], corners[(i + 1) % corners.size()] - corners[0]);
    double area = 0.0;
    const auto triangles = cutter.cut(corners);
    EXPECT_EQ(triangles.size(), corners.size() - 2);
    for (const uvec3& t : triangles) {
        EXPECT_GE(glm::dot(doubled(corners, t), whole), -1e-9 * glm::dot(whole, whole)) << t.x << " " << t.y << " " << t.z;
        area += glm::length(doubled(corners, t));
    }
    EXPECT_NEAR(area, glm::length(whole), 1e-6 * glm::length(whole));
}

std::vector<dvec3> flat(std::initializer_list<glm::dvec2> corners) {
    std::vector<dvec3> result;
    for (const auto& corner : corners) result.emplace_back(corner, 0.0);
    return result;
}

TEST(PolygonCutter, CutsQuadrilateralsAlongTheirShorterDiagonalInside) {
    PolygonCutter cutter;
    auto cut = [&](std::initializer_list<glm::dvec2> corners) { return cutter.cut(flat(corners))[0]; };
    EXPECT_EQ(cut({{0, 0}, {1, 0}, {1, 1}, {0, 1}}), uvec3(0, 1, 2));
    EXPECT_EQ(cut({{0, 0}, {4, 0}, {5, 1}, {1, 1}}), uvec3(0, 1, 3));
    EXPECT_EQ(cut({{0, 0}, {2, 4}, {0, 1}, {-2, 4}}), uvec3(0, 1, 2)) << "an arrow's head: only this one lies inside";
    EXPECT_EQ(cut({{-2, 4}, {0, 0}, {2, 4}, {0, 1}}), uvec3(0, 1, 3));
}

TEST(PolygonCutter, CoversConcaveOutlinesFromEitherSideAndInAnyPlane) {
    PolygonCutter cutter;
    const auto u = flat({{0, 0}, {3, 0}, {3, 3}, {2, 3}, {2, 1}, {1, 1}, {1, 3}, {0, 3}});
    std::vector<dvec3> comb = flat({{0, 0}, {20, 0}});
    for (int i = 20; i > 0; i--) comb.emplace_back(i - 0.5, i % 2 ? 1.0 : 9.0, 0.0);
    for (std::vector<dvec3> outline : {u, comb}) {
        for (int turns = 0; turns < 3; turns++) {
            expectCovered(outline, cutter);
            expectCovered({outline.rbegin(), outline.rend()}, cutter);
            for (dvec3& at : outline) at = dvec3(at.y, at.z + 0.3 * at.x, at.x);
        }
    }
    EXPECT_EQ(cutter.givenUp(), 0u);
}

TEST(PolygonCutter, CoversStarsOfAnyCount) {
    PolygonCutter cutter;
    std::mt19937 random(7);
    std::uniform_real_distribution<double> radius(0.2, 1.0);
    for (size_t count : {5u, 6u, 19u, 255u, 256u, 400u, 2000u}) {
        std::vector<dvec3> star;
        for (size_t i = 0; i < count; i++) {
            const double angle = 6.283185307 * static_cast<double>(i) / static_cast<double>(count), r = radius(random);
            star.emplace_back(r * std::cos(angle), r * std::sin(angle), 0.0);
        }
        expectCovered(star, cutter);
    }
}

TEST(PolygonCutter, EndsWithOutlinesThatNoTrianglesCover) {
    PolygonCutter cutter;
    const std::vector<dvec3> same(50, dvec3(1.0)), crossed = flat({{0, 0}, {4, 4}, {4, 0}, {0, 4}, {2, 9}, {9, 2}});
    const std::vector<dvec3> line = flat({{0, 0}, {1, 0}, {2, 0}, {3, 0}, {1.5, 0}, {0.5, 0}}), none(5, dvec3(NAN));
    for (const auto& corners : {same, crossed, line, none}) EXPECT_EQ(cutter.cut(corners).size(), corners.size() - 2);
    EXPECT_TRUE(cutter.cut(std::span(same).first(2)).empty());
    // A zigzag of as many corners as a line may have is a fan before it takes seconds.
    std::vector<dvec3> zigzag;
    for (int i = 0; i < 200'000; i++) zigzag.emplace_back(i, i % 2 ? 1.0 : 0.0, 0.0);
    zigzag.emplace_back(100'000.0, 1e6, 0.0);
    EXPECT_EQ(cutter.cut(zigzag).size(), zigzag.size() - 2);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
