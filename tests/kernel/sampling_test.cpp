#include "tests/kernel/kernel_access.h"

#include "server/film/error_model.h"
#include "server/scene/kernel_tables.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;

EveryKernel kernel = bareKernel();

/// Greatest difference between the share of points in [0, x) x [0, y) and its area, over the corners that the points give.
double starDiscrepancy(const std::vector<glm::dvec2>& points) {
    double worst = 0.0;
    std::vector<double> xs{1.0}, ys{1.0};
    for (glm::dvec2 p : points) xs.push_back(p.x), ys.push_back(p.y);
    for (double x : xs) {
        for (double y : ys) {
            double open = 0.0, closed = 0.0;
            for (glm::dvec2 p : points) {
                open += p.x < x && p.y < y;
                closed += p.x <= x && p.y <= y;
            }
            const double n = static_cast<double>(points.size());
            worst = std::max({worst, std::abs(open / n - x * y), std::abs(closed / n - x * y)});
        }
    }
    return worst;
}

/// Area of the part of the unit square around 0 where c x + s y < offset.
double areaBelow(double c, double s, double offset) {
    const double a = std::max(std::abs(c), std::abs(s)), b = std::min(std::abs(c), std::abs(s));
    const double t = offset + (a + b) / 2.0;
    auto square = [](double z) { return z > 0.0 ? z * z : 0.0; };
    return (square(t) - square(t - a) - square(t - b) + square(t - a - b)) / (2.0 * a * b);
}

// What a film tells of its error rests on it (film/error_model.h).
TEST(Sampling, EdgesErrAsTheFilmTakesThemTo) {
    constexpr uint32_t SAMPLES = 1024, LINES = 4000;
    Random chance(5);
    std::vector<double> squares(SAMPLES + 1, 0.0);
    double variance = 0.0;
    for (uint32_t line = 0; line < LINES;) {
        const double angle = chance.number(0.0, 2.0 * EXACT_PI), offset = chance.number(-0.8, 0.8);
        const double c = std::cos(angle), s = std::sin(angle);
        if (std::abs(offset) >= (std::abs(c) + std::abs(s)) / 2.0) continue;  // passes the pixel
        line++;
        const double area = areaBelow(c, s, offset);
        variance += area * (1.0 - area);
        uint32_t below = 0;
        for (uint32_t n = 1; n <= SAMPLES; n++) {
            const vec2 p = kernel.pixelJitter(n - 1);
            below += c * (static_cast<double>(p.x) - 0.5) + s * (static_cast<double>(p.y) - 0.5) < offset;
            const double error = static_cast<double>(below) / n - area;
            squares[n] += error * error;
        }
    }
    for (uint32_t n = 1; n <= SAMPLES; n *= 2) EXPECT_NEAR(squares[n] / variance / edgeDecay(n), 1.0, 0.07) << n;
}

TEST(Sampling, JitterStartsAtThePixelsCentre) {
    EXPECT_EQ(kernel.pixelJitter(0).x, 0.5f);
    EXPECT_EQ(kernel.pixelJitter(0).y, 0.5f);
}

TEST(Sampling, JitterStaysInThePixel) {
    for (uint32_t i = 0; i < 200000; i++) {
        const vec2 j = kernel.pixelJitter(i);
        ASSERT_TRUE(j.x >= 0.0f && j.x < 1.0f && j.y >= 0.0f && j.y < 1.0f) << i;
    }
    const vec2 last = kernel.pixelJitter(0xffffffffu);
    EXPECT_TRUE(last.x >= 0.0f && last.x < 1.0f && last.y >= 0.0f && last.y < 1.0f);
}

TEST(Sampling, JitterFollowsTheR2Sequence) {
    const double g = 1.32471795724474602596;  // root of x^3 = x + 1
    for (uint32_t i = 0; i < 65536; i++) {
        const vec2 j = kernel.pixelJitter(i);
        const double x = 0.5 + i / g, y = 0.5 + i / (g * g);
        const auto apart = [](double a, double b) {
            const double d = std::abs(a - b - std::floor(a - b + 0.5));
            return d;
        };
        ASSERT_LT(apart(j.x, x), 3e-5) << i;  // the step is rounded to 2^-32: 65536 of them lose 2^-17 at most
        ASSERT_LT(apart(j.y, y), 3e-5) << i;
    }
}

TEST(Sampling, JitterCoversThePixelFarMoreEvenlyThanChance) {
    Random random(3);
    for (uint32_t count : {64u, 256u}) {
        std::vector<glm::dvec2> points;
        for (uint32_t i = 0; i < count; i++) points.emplace_back(kernel.pixelJitter(i).x, kernel.pixelJitter(i).y);
        double chance = 0.0;
        for (int set = 0; set < 10; set++) {
            std::vector<glm::dvec2> scattered;
            for (uint32_t i = 0; i < count; i++) scattered.emplace_back(random.number(0.0, 1.0), random.number(0.0, 1.0));
            chance += starDiscrepancy(scattered) / 10.0;
        }
        EXPECT_LT(starDiscrepancy(points), count == 64 ? 0.08 : 0.025);
        EXPECT_LT(starDiscrepancy(points), 0.6 * chance) << count << " points";
    }
}

TEST(Sampling, CosineHemisphereGivesUnitVectorsAboveTheHorizon) {
    Random random(1);
    for (int i = 0; i < 100000; i++) {
        const vec3 d = kernel.cosineHemisphere(random.real(0.0f, 0.99999994f), random.real(0.0f, 0.99999994f));
        ASSERT_NEAR(glm::length(dvec3(d)), 1.0, 5e-7);
        ASSERT_GT(d.z, 0.0f);
    }
    EXPECT_EQ(kernel.cosineHemisphere(0.0f, 0.3f).z, 1.0f);
}

// Under the density z / pi, z has the distribution function z^2: mean 2/3, and every bin of z^2 is equally full.
TEST(Sampling, CosineHemisphereHasTheDensityItClaims) {
    const uint32_t side = 512;
    double sum = 0.0;
    std::vector<uint32_t> heights(16), turns(16);
    for (uint32_t y = 0; y < side; y++) {
        for (uint32_t x = 0; x < side; x++) {
            const vec3 d = kernel.cosineHemisphere((float(x) + 0.5f) / side, (float(y) + 0.5f) / side);
            sum += d.z;
            heights[std::min(15, int(16.0 * d.z * d.z))]++;
            turns[int(16.0 * (std::atan2(double(d.y), double(d.x)) / (2.0 * EXACT_PI) + 1.0)) % 16]++;
        }
    }
    EXPECT_NEAR(sum / (side * side), 2.0 / 3.0, 1e-5);
    for (int i = 0; i < 16; i++) {
        EXPECT_NEAR(heights[i], side * side / 16.0, side) << i;
        EXPECT_NEAR(turns[i], side * side / 16.0, side) << i;
    }
}

// A (0,2)-sequence: any 2^k points in a row (from a multiple of 2^k) have one in every elementary interval of area 2^-k.
TEST(Sampling, SobolTableHasOnePointInEveryElementaryInterval) {
    const std::vector<uvec2>& table = sobolTable();
    ASSERT_EQ(table.size(), size_t(EveryKernel::SOBOL_COUNT));
    for (uint32_t bits = 1; bits <= 8; bits++) {
        const uint32_t count = 1u << bits;
        for (uint32_t first = 0; first < table.size(); first += count) {
            for (uint32_t across = 0; across <= bits; across++) {
                std::set<uint32_t> cells;
                for (uint32_t i = first; i < first + count; i++) {
                    const uint32_t x = across == 0 ? 0 : table[i].x >> (32 - across);
                    const uint32_t y = across == bits ? 0 : table[i].y >> (32 - (bits - across));
                    cells.insert(x << (bits - across) | y);
                }
                ASSERT_EQ(cells.size(), count) << count << " points from " << first << ", " << across << " bits across";
            }
        }
    }
}

// The table and what is computed beyond it are one sequence.
TEST(Sampling, TheSequenceGoesOnWhereItsTableEnds) {
    kernel.scene.sobol = sobolTable().data();
    for (uint32_t i = 0; i < EveryKernel::SOBOL_COUNT; i++) ASSERT_EQ(kernel.sobolBeyond(i), sobolTable()[i]) << i;
    EXPECT_EQ(kernel.sobolPoint(5), sobolTable()[5]);
    EXPECT_EQ(kernel.sobolPoint(4096 + 5), kernel.sobolBeyond(4096 + 5));
    constexpr uint32_t LOG = 16, COUNT = 1u << LOG;
    for (uint32_t first : {0u, COUNT, 0x80000000u}) {
        for (uint32_t across : {0u, 3u, 8u, 11u, 16u}) {
            std::vector<bool> taken(COUNT, false);
            for (uint32_t i = first; i < first + COUNT; i++) {
                const uvec2 p = kernel.sobolPoint(i);
                const uint32_t x = across == 0 ? 0 : p.x >> (32 - across), y = across == LOG ? 0 : p.y >> (32 - LOG + across);
                const uint32_t cell = x << (LOG - across) | y;
                ASSERT_FALSE(taken[cell]) << "point " << i << ", " << across << " bits across";
                taken[cell] = true;
            }
        }
    }
}

// The mean of a smooth function over more points than the table has goes on falling; with a table that begins anew it would stay
// where 4096 points left it.
TEST(Sampling, TheErrorGoesOnFallingBeyondTheTable) {
    kernel.scene.sobol = sobolTable().data();
    auto errorOf = [](uint32_t count) {
        double squares = 0.0;
        constexpr uint32_t PIXELS = 32;
        for (uint32_t pixel = 0; pixel < PIXELS; pixel++) {
            const uint32_t shift = kernel.hashPixel({pixel, 7}, 1);
            double sum = 0.0;
            for (uint32_t i = 0; i < count; i++) {
                const uvec2 p = kernel.shuffledPoint(i, shift);
                const double u = kernel.unitFloat(p.x ^ shift), v = kernel.unitFloat(p.y ^ kernel.hashUint(shift));
                sum += std::exp(u) * std::sin(3.0 * v);
            }
            const double truth = (std::exp(1.0) - 1.0) * (1.0 - std::cos(3.0)) / 3.0, off = sum / count / truth - 1.0;
            squares += off * off;
        }
        return std::sqrt(squares / PIXELS);
    };
    EXPECT_LT(errorOf(65536), 0.25 * errorOf(4096));
}

TEST(Sampling, DigitShiftKeepsTheStrata) {
    const std::vector<uvec2>& table = sobolTable();
    for (uint32_t shift : {0x12345678u, 0xdeadbeefu, 0xffffffffu}) {
        std::set<uint32_t> columns, rows;
        for (uint32_t i = 0; i < 16; i++) {
            columns.insert(uint32_t(kernel.unitFloat(table[i].x ^ shift) * 16.0f));
            rows.insert(uint32_t(kernel.unitFloat(table[i].y ^ kernel.hashUint(shift)) * 16.0f));
        }
        EXPECT_EQ(columns.size(), 16u);
        EXPECT_EQ(rows.size(), 16u);
    }
}

TEST(Sampling, ShuffledPointsKeepTheirStrata) {
    kernel.scene.sobol = kernelTable().data();
    for (uint32_t seed : {0u, 1u, 0x12345678u, 0xffffffffu}) {
        for (uint32_t log = 2; log <= 16; log += 2) {
            const uint32_t side = 1u << (log / 2);
            std::set<uint32_t> cells;
            for (uint32_t i = 0; i < side * side; i++) {
                const uvec2 point = kernel.shuffledPoint(i, seed);
                cells.insert((point.x >> (32 - log / 2)) * side + (point.y >> (32 - log / 2)));
            }
            EXPECT_EQ(cells.size(), side * side)
                << "one of the first " << side * side << " points in each square, seed " << seed;
        }
    }
}

// Two orders of the table have nothing to do with each other: pairs of them fill the square as chance would. (Pairs of one order
// with two digit shifts lie on lines: 16 of 256 cells.)
TEST(Sampling, ShufflesAreIndependentOfEachOther) {
    kernel.scene.sobol = kernelTable().data();
    int tried = 0;
    double greatest = 0.0, sum = 0.0;
    for (uint32_t seed = 1; seed <= 64; seed++) {
        int cells[256] = {};
        for (uint32_t i = 0; i < 4096; i++) {
            const uint32_t a = kernel.shuffledPoint(i, kernel.hashUint(seed)).x >> 28,
                           b = kernel.shuffledPoint(i, kernel.hashUint(seed + 1000)).x >> 28;
            cells[a * 16 + b]++;
        }
        double chiSquare = 0.0;
        for (int n : cells) chiSquare += (n - 16.0) * (n - 16.0) / 16.0;
        greatest = std::max(greatest, chiSquare);
        sum += chiSquare;
        tried++;
    }
    // By chance, with rows and columns that sum to 256 each: 225 on average, deviation 21; on lines it would be 61440.
    EXPECT_LT(sum / tried, 300.0);
    EXPECT_LT(greatest, 1500.0);
}

TEST(Sampling, SamplesOfAPixelTakeTheSequenceInARow) {
    EveryKernel k = bareKernel();
    k.frame.aoSamples = 9;
    std::set<uint32_t> seen;
    for (uint32_t sample = 0; sample < 455; sample++)
        for (uint32_t i = 0; i < 9; i++) EXPECT_TRUE(seen.insert(k.occlusionNumber(sample, i)).second);
    EXPECT_EQ(*seen.rbegin(), 455u * 9u - 1u);
}

TEST(Sampling, OcclusionDirectionsLeaveTheFacet) {
    Random random(2);
    const std::vector<uvec2>& table = sobolTable();
    for (int i = 0; i < 100000; i++) {
        const vec3 normal = random.direction();
        vec3 facet = kernel.normalize3(normal + random.inCube(0.9f));
        if (glm::dot(facet, normal) < 0.0f) facet = -facet;
        vec3 t, b;
        kernel.orthonormalBasis(normal, t, b);
        const vec3 d = kernel.occlusionDirection(table[i % table.size()], random.word(), normal, facet, t, b);
        ASSERT_GE(glm::dot(d, facet), -2e-7f);
        ASSERT_NEAR(glm::length(dvec3(d)), 1.0, 2e-6);
    }
}

}  // namespace
}  // namespace heliograph::TEST_FILE
