// Cases 18, 25, 30, 31, 32, 34 and 35: single functions of the kernel and the film against formulas in more digits.

#include "server/film/film.h"
#include "server/scene/kernel_tables.h"
#include "tests/hard/cases.h"
#include "tests/hard/exact.h"
#include "tests/hard/tracer.h"
#include "tests/image/picture.h"

#include <algorithm>

namespace heliograph::hard {

namespace {

using test::EveryKernel;
using test::Random;

/// Reflectance of an interface by Fresnel's formulas on these very floats; 1 beyond the critical angle.
double exactFresnel(float cosI, float eta) {
    const Quad c = cosI, e = eta, radicand = 1 - e * e * (1 - c * c);
    if (radicand < 0) return 1.0;
    const Quad t = squareRoot(radicand), parallel = (c - e * t) / (c + e * t), across = (e * c - t) / (e * c + t);
    return static_cast<double>((parallel * parallel + across * across) / 2);
}

/// As textbooks write it: by sines.
double naiveFresnel(float cosI, float eta) {
    const float sinT = eta * std::sqrt(1.0f - cosI * cosI), cosT = std::sqrt(1.0f - sinT * sinT);
    const float parallel = (cosI - eta * cosT) / (cosI + eta * cosT), across = (eta * cosI - cosT) / (eta * cosI + cosT);
    return 0.5f * (parallel * parallel + across * across);
}

}  // namespace

void criticalAngle(Run& run) {
    EveryKernel kernel = test::bareKernel();
    const double critical = std::asin(1.0 / 1.5);
    const int64_t reach = static_cast<int64_t>(run.count(100, 100)), parts = static_cast<int64_t>(run.count(100, 10000));
    for (int64_t i = -reach * parts; i <= reach * parts; i++) {
        const double off = 1e-6 * static_cast<double>(i) / static_cast<double>(parts);
        const auto cosI = static_cast<float>(std::cos(critical + off));
        float cosT = 0.0f;
        const float own = kernel.fresnelDielectric(cosI, 1.5f, cosT);
        const double exact = exactFresnel(cosI, 1.5f);
        // The cosine's own rounding moves the angle: what counts is how far that float is from the edge.
        const double from = std::fabs(std::acos(double(cosI)) - critical);
        const char* metric = from <= 1e-6 ? "R within 1e-6 rad of the edge" : "R beyond 1e-6 rad";
        const double bound = from <= 1e-6 ? 2e-3 : 1e-5;
        run.most(column::OWN, metric, std::fabs(own - exact), bound, 1);
        run.most(column::NAIVE, metric, std::fabs(naiveFresnel(cosI, 1.5f) - exact), bound, 1);
    }
}

void bentNormals(Run& run) {
    EveryKernel kernel = test::bareKernel();
    kernel.frame.effects = EFFECT_REFLECTIONS;
    kernel.frame.maxReflections = 4;
    Random random(25);
    const uint64_t n = run.count(1000000, 50000000);
    uint64_t below = 0, naive = 0;
    for (uint64_t i = 0; i < n; i++) {
        EveryKernel::Surface s{};
        EveryKernel::Shading m{};
        EveryKernel::PathState p{}, next{};
        s.geometricNormal = random.direction();
        p.direction = random.direction();
        if (glm::dot(p.direction, s.geometricNormal) > 0.0f) p.direction = -p.direction;
        do m.facet = random.direction();
        while (glm::dot(m.facet, s.geometricNormal) < 0.17f);  // tilted up to 80 degrees
        p.throughput = vec3(1.0f);
        vec3 radiance(0.0f);
        kernel.followReflection(p, s, m, vec3(1.0f), 1.0f, next, radiance);
        below += !(glm::dot(next.direction, s.geometricNormal) > 0.0f);
        naive += !(glm::dot(p.direction - m.facet * (2.0f * glm::dot(m.facet, p.direction)), s.geometricNormal) > 0.0f);
    }
    run.rate(column::OWN, "reflected below the surface", below, n, 0.0);
    run.rate(column::NAIVE, "reflected below the surface", naive, n, 0.0);
}

void textureCoordinates(Run& run) {
    EveryKernel kernel = test::bareKernel();
    Random random(30);
    const float odd[] = {0.0f,      1.0f, -1.0f,  -0.0f,   1e30f,       -1e30f, INFINITY,
                         -INFINITY, NAN,  1e-40f, -1e-40f, 0.99999994f, -1e-8f};
    for (uint64_t i = 0; i < run.count(1000000, 100000000); i++) {
        const bool strange = i < std::size(odd);
        const float u = strange ? odd[i] : static_cast<float>(random.magnitude(1e-6, 1e4)) * (i % 2 ? 1.0f : -1.0f);
        const double exact = double(u) - std::floor(double(u));
        const auto count = [&](const char* column, float x) {
            run.rate(column, "outside of the image", !(x >= 0.0f && x <= 1.0f), 1, 0.0);
            if (!(std::fabs(u) <= 1e4f)) return;
            // 1 and 0 are one place. An ulp below 1 is what the result itself can hold.
            const double off = std::fabs(double(x) - exact);
            run.most(column, "wrapped coordinate", std::min(off, 1.0 - off), 6e-8, 1);
        };
        count(column::OWN, kernel.wrapCoordinate(u, WRAP_REPEAT));
        count(column::NAIVE, std::fmod(u, 1.0f));
    }
}

namespace {

/// An image that is even but for one texel of the first row, at the pole, and one in its middle.
std::shared_ptr<const Scene> skyWithBrightPole() {
    SceneBuilder builder("sky");
    ImageData image;
    image.width = 64, image.height = 32;
    for (uint32_t i = 0; i < image.width * image.height; i++) {
        const float bright = i == 5 ? 4000.0f : i == 16 * 64 + 9 ? 300.0f : 0.2f + 0.01f * float(i % 64);
        image.rgb32f.insert(image.rgb32f.end(), 3, bright);
    }
    builder.setEnvironmentImage(builder.addImage(image));
    builder.addInstance(builder.addMesh(test::icosphere(0)), mat4(1.0f));
    return builder.finish();
}

/// The table by which directions are chosen: its densities add up to 1, and 1 / density is 4 pi in the mean.
void environmentDensities(Run& run) {
    const auto scene = skyWithBrightPole();
    EveryKernel kernel = test::bareKernel();
    kernel.scene = sceneView(*scene);
    const Environment& e = scene->environment;
    if (e.lightColumns == 0) throw std::logic_error("the sky of case 31 has no table");
    double sum = 0.0, naive = 0.0;
    const double across = 2.0 * test::EXACT_PI / e.lightColumns, down = test::EXACT_PI / e.lightRows;
    for (uint32_t y = 0; y < e.lightRows; y++) {
        for (uint32_t x = 0; x < e.lightColumns; x++) {
            const double polar = (y + 0.5) * down, turn = ((x + 0.5) / e.lightColumns - 0.5) * 2.0 * test::EXACT_PI;
            const vec3 d(glm::dvec3(std::sin(polar) * std::sin(turn), std::cos(polar), -std::sin(polar) * std::cos(turn)));
            const double density = double(kernel.environmentDensity(d));
            sum += density * across * (std::cos(y * down) - std::cos((y + 1) * down));
            naive += density * across * down;  // as if rows were of one size
        }
    }
    run.most(column::OWN, "sum of densities off 1", std::fabs(sum - 1.0), 1e-4, uint64_t(e.lightColumns) * e.lightRows);
    run.most(column::NAIVE, "sum of densities off 1", std::fabs(naive - 1.0), 1e-4, uint64_t(e.lightColumns) * e.lightRows);
    double solidAngle = 0.0;
    const uint32_t n = 1u << 22;
    for (uint32_t i = 0; i < n; i++) {
        const auto place = kernel.environmentPlaceAt(kernel.lightNumbers(uvec2(i >> 12, 3u), 0u, 0u, i & 4095u));
        solidAngle += 1.0 / double(place.density);
        const double other = double(kernel.environmentDensity(place.direction));
        run.rate(column::OWN, "chosen with another density than asked", std::fabs(other / double(place.density) - 1.0) > 1e-3,
                 1,
                 1e-3);  // at borders of cells, which round
    }
    run.most(column::OWN, "solid angle of the sphere, relative", std::fabs(solidAngle / n / (4.0 * test::EXACT_PI) - 1.0), 1e-3,
             n);
}

}  // namespace

void environmentPoles(Run& run) {
    environmentDensities(run);
    EveryKernel kernel = test::bareKernel();
    Environment environment{};
    kernel.scene.environment = &environment;
    Random random(31);
    const vec3 poles[] = {{0, 1, 0},      {0, -1, 0},        {0, 1.0000001f, 0}, {0, -1.0000001f, 0},
                          {1e-20f, 1, 0}, {-0.0f, 1, -0.0f}, {0, 0, 1},          {-0.0f, 0, 1}};
    for (uint64_t i = 0; i < run.count(500000, 50000000); i++) {
        vec3 d = i < std::size(poles) ? poles[i] : random.direction();
        if (i >= std::size(poles) && i % 2) d = glm::normalize(vec3(d.x * 1e-3f, d.y < 0 ? -1.0f : 1.0f, d.z * 1e-3f));
        const double v = std::acos(std::clamp(double(d.y) / glm::length(glm::dvec3(d)), -1.0, 1.0)) / test::EXACT_PI;
        const double u = std::atan2(double(d.x), -double(d.z)) / (2.0 * test::EXACT_PI) + 0.5;
        const double ring = std::sin(v * test::EXACT_PI);  // a turn near a pole moves little
        const auto count = [&](const char* column, vec2 place) {
            run.rate(column, "not finite", !(std::isfinite(place.x) && std::isfinite(place.y)), 1, 0.0);
            const double turn = std::fabs(place.x - u), wrapped = std::min(turn, std::fabs(1.0 - turn));
            run.most(column, "off by texels of an image of 2048",
                     2048.0 * std::max(wrapped * ring, std::fabs(place.y - v) / 2.0), 0.25, 1);
        };
        count(column::OWN, kernel.environmentPlace(d));
        count(column::NAIVE, vec2(std::atan2(d.x, -d.z) / 6.2831853f + 0.5f, std::acos(d.y) / 3.1415927f));
    }
}

namespace {

/// Direction through a pixel by a camera of degrees, all in float.
vec3 naiveDirection(const Camera& camera, uvec2 size, uint32_t x, uint32_t y) {
    const float half = std::tan(camera.fieldOfView * 0.5f * 0.017453292f);
    const vec3 right = glm::normalize(glm::cross(camera.forward, camera.up)), up = glm::cross(right, camera.forward);
    const float sx = (2.0f * (float(x) + 0.5f) / float(size.x) - 1.0f) * half * float(size.x) / float(size.y);
    const float sy = (1.0f - 2.0f * (float(y) + 0.5f) / float(size.y)) * half;
    return glm::normalize(camera.forward + right * sx + up * sy);
}

bool refuses(float fieldOfView) {
    Camera camera;
    camera.fieldOfView = fieldOfView;
    try {
        checkedCamera(camera);
    } catch (const std::exception&) {
        return true;
    }
    return false;
}

}  // namespace

namespace {

/// Pictures a thousand times as wide as high, and as high as wide.
void thinPictures(Run& run) {
    EveryKernel kernel = test::bareKernel();
    Random random(321);
    for (uvec2 size : {uvec2(8000, 8), uvec2(8, 8000)}) {
        for (float degrees : {0.01f, 60.0f, 179.0f}) {
            Camera camera;
            camera.forward = random.direction();
            camera.up = random.direction();
            camera.fieldOfView = degrees;
            camera = checkedCamera(camera);
            kernel.frame.camera = kernelCamera(camera, size);
            kernel.frame.resolution = size;
            for (int i = 0; i < 8000; i++) {
                const uint32_t x = random.below(size.x), y = random.below(size.y);
                const glm::dvec3 exact = test::rayThrough(camera, size, x, y);
                const double pixel = glm::length(test::rayThrough(camera, size, x + 1, y) - exact);
                const double off = glm::length(glm::dvec3(kernel.cameraDirection(float(x) + 0.5f, float(y) + 0.5f)) - exact);
                run.rate(column::OWN, "directions of 1:1000 that are no unit vectors", !(std::isfinite(off) && off < 0.5), 1,
                         0.0);
                // What float holds of a direction, where pixels lie closer than that.
                run.most(column::OWN, "off at 1:1000 / (pixel / 1000 + 2 ulp)", off / (1e-3 * pixel + 0x1p-22), 1.0, 1);
            }
        }
    }
}

}  // namespace

void fieldOfView(Run& run) {
    thinPictures(run);
    EveryKernel kernel = test::bareKernel();
    const uvec2 size(1920, 1080);
    Random random(32);
    for (int turn = 0; turn < 8; turn++) {
        for (float degrees : {0.01f, 60.0f, 179.0f}) {
            Camera camera;
            camera.forward = random.direction();
            camera.up = random.direction();
            camera.fieldOfView = degrees;
            camera = checkedCamera(camera);
            kernel.frame.camera = kernelCamera(camera, size);
            kernel.frame.resolution = size;
            vec3 before[2] = {vec3(0.0f), vec3(0.0f)};
            for (uint32_t x = 0; x < size.x; x++) {
                const uint32_t y = 37 * turn % size.y;
                const vec3 both[] = {kernel.cameraDirection(float(x) + 0.5f, float(y) + 0.5f),
                                     naiveDirection(camera, size, x, y)};
                const char* columns[] = {column::OWN, column::NAIVE};
                const glm::dvec3 exact = test::rayThrough(camera, size, x, y), aside = test::rayThrough(camera, size, x + 1, y);
                for (int i = 0; i < 2; i++) {
                    const double pixel = glm::length(aside - exact);
                    const double off = glm::length(glm::normalize(glm::dvec3(both[i])) - exact) / pixel;
                    if (degrees == 179.0f) run.most(columns[i], "pixels off at 179 degrees", off, 1e-3, 1);
                    if (degrees == 0.01f && x > 0)
                        run.rate(columns[i], "neighbours with one direction at 0.01 degrees", both[i] == before[i], 1, 0.0);
                    before[i] = both[i];
                }
            }
        }
    }
    uint64_t taken = 0;
    for (float degrees : {0.0f, -1.0f, 180.0f, 360.0f, NAN, INFINITY}) taken += !refuses(degrees);
    run.rate(column::OWN, "angles that are none are taken", taken, 6, 0.0);
    // The naive one draws them: turned about, all alike, or as no numbers.
    uint64_t wrong = 0;
    for (float degrees : {0.0f, -1.0f, 180.0f, 360.0f, NAN, INFINITY}) {
        Camera camera;
        camera.fieldOfView = degrees;
        const vec3 left = naiveDirection(camera, size, 0, 540), right = naiveDirection(camera, size, 1919, 540);
        wrong += !(right.x - left.x > 1e-3f);
    }
    run.rate(column::NAIVE, "angles that are none are taken", wrong, 6, 0.0);
}

void accumulation(Run& run) {
    Film film;
    film.reset(uvec2(8, 8), 1);
    const auto n = static_cast<uint32_t>(run.count(1000000, 16777217));
    TileResult result;
    result.tile.size = uvec2(8, 8);
    result.tile.generation = 1;
    result.radianceSum.assign(64, vec4(0.1f, 0.1f, 0.1f, 0.01f));
    float naive = 0.0f;
    std::vector<vec4> pixels;
    for (uint32_t i = 0; i < n; i++) {
        result.tile.firstSample = i;
        if (!film.add(result)) run.rate(column::OWN, "samples refused", 1, 1, 0.0);
        naive += 0.1f;
        if (i + 1 != 1000 && i + 1 != 10000 && i + 1 != 100000 && i + 1 != n) continue;
        film.develop(pixels);
        run.most(column::OWN, "drift of the mean", std::fabs(double(pixels[9].x) / double(0.1f) - 1.0), 1e-5, i + 1);
        run.most(column::NAIVE, "drift of the mean", std::fabs(double(naive) / (double(0.1f) * (i + 1)) - 1.0), 1e-5, i + 1);
    }
}

namespace {

/// Slope of the variance of a mean over 64 pixels against the number of samples, both as logarithms; least squares.
double slopeOfVariance(EveryKernel& kernel, int least, int most) {
    double sx = 0, sy = 0, sxx = 0, sxy = 0;
    int n = 0;
    for (int k = least; k <= most; k += 2, n++) {
        double sum = 0.0, squares = 0.0;
        for (uint32_t pixel = 0; pixel < 64; pixel++) {
            double mean = 0.0;
            for (uint32_t i = 0; i < 1u << k; i++) {
                const vec4 u = kernel.lightNumbers(uvec2(pixel % 8, pixel / 8), 0u, 0u, i);
                mean += double(u.x) * double(u.y) > 0.3 ? 1.0 : 0.0;  // an edge across both numbers
            }
            mean = std::ldexp(mean, -k);
            sum += mean, squares += mean * mean;
        }
        const double x = k * std::log(2.0), y = std::log(std::max(squares / 64 - sum / 64 * (sum / 64), 1e-300));
        sx += x, sy += y, sxx += x * x, sxy += x * y;
    }
    return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

}  // namespace

void sampler(Run& run) {
    {
        EveryKernel kernel = test::bareKernel();
        kernel.frame.seed = 1;
        run.most(column::OWN, "slope of the variance + 1", slopeOfVariance(kernel, 6, run.plan().nightly ? 20 : 16) + 1.0, 0.05,
                 64);
    }
    EveryKernel kernel = test::bareKernel();
    // Beyond 2^24 a sample's number is no float any more.
    const uint32_t first = (1u << 24) - 1000;
    const auto n = static_cast<uint32_t>(run.count(1u << 18, 1u << 22));
    std::vector<uint64_t> points;
    std::vector<float> naive;
    uint64_t one = 0, naiveOne = 0;
    for (uint32_t i = 0; i < n; i++) {
        const uvec2 p = kernel.sobolPoint(first + i);
        points.push_back(uint64_t(p.x) << 32 | p.y);
        one += kernel.unitFloat(p.x) >= 1.0f || kernel.unitFloat(~(p.x >> 20)) >= 1.0f;
        naiveOne += static_cast<float>(~(p.x >> 20)) * 0x1p-32f >= 1.0f;
        naive.push_back(static_cast<float>(first + i));
    }
    const auto repeats = [](auto& values) {
        std::sort(values.begin(), values.end());
        return static_cast<uint64_t>(values.end() - std::unique(values.begin(), values.end()));
    };
    run.rate(column::OWN, "points twice beyond 2^24", repeats(points), n, 0.0);
    run.rate(column::NAIVE, "points twice beyond 2^24", repeats(naive), n, 0.0);
    run.rate(column::OWN, "numbers that reach 1", one, n, 0.0);
    run.rate(column::NAIVE, "numbers that reach 1", naiveOne, n, 0.0);
    // The error of a mean over a sequence falls at least as one over the root: of x * y over the square, in 2^k points.
    for (int k = 8; k <= (run.plan().nightly ? 24 : 20); k += 4) {
        double sum = 0.0;
        for (uint32_t i = 0; i < 1u << k; i++) {
            const uvec2 p = kernel.sobolPoint(i);
            sum += double(kernel.unitFloat(p.x)) * double(kernel.unitFloat(p.y));
        }
        const double count = std::ldexp(1.0, k), error = std::fabs(sum / count - 0.25);
        run.most(column::OWN, "error of a mean / that of chance", error * std::sqrt(count) / 0.22, 1.0, 1u << k);
    }
}

}  // namespace heliograph::hard
