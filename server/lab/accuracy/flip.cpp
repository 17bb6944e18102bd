#include "server/lab/accuracy/flip.h"

#include "server/kernel/kernel_types.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <stdexcept>

namespace heliograph {

namespace {

using glm::dvec2;
using glm::dvec3;
using std::numbers::pi;

// Constants of the paper: table 1 (contrast sensitivity), sections 4.1.3 (colour) and 4.2 (features), 4.3 (both).
constexpr double QC = 0.7, PC = 0.4, PT = 0.95;
constexpr double FEATURE_WIDTH = 0.082;  // degrees
constexpr double QF = 0.5;
const dvec3 WHITE(0.950428545, 1.0, 1.088900371);  // D65, XYZ

/// A plane of values with borders that repeat.
template <typename Value>
struct Plane {
    int width = 0, height = 0;
    std::vector<Value> values;
    Plane(int w, int h) : width(w), height(h), values(static_cast<size_t>(w) * h) {}
    Value& at(int x, int y) { return values[static_cast<size_t>(y) * width + x]; }
    const Value& near(int x, int y) const {
        return values[static_cast<size_t>(std::clamp(y, 0, height - 1)) * width + std::clamp(x, 0, width - 1)];
    }
};

/// Weights for -radius..radius.
using Weights = std::vector<double>;

template <typename Value>
Plane<Value> filtered(const Plane<Value>& from, const Weights& across, const Weights& down) {
    const int rx = static_cast<int>(across.size() / 2), ry = static_cast<int>(down.size() / 2);
    Plane<Value> rows(from.width, from.height), result(from.width, from.height);
    for (int y = 0; y < from.height; y++) {
        for (int x = 0; x < from.width; x++) {
            Value sum(0.0);
            for (int i = -rx; i <= rx; i++) sum += across.begin()[i + rx] * from.near(x + i, y);
            rows.at(x, y) = sum;
        }
    }
    for (int y = 0; y < from.height; y++) {
        for (int x = 0; x < from.width; x++) {
            Value sum(0.0);
            for (int i = -ry; i <= ry; i++) sum += down.begin()[i + ry] * rows.near(x, y + i);
            result.at(x, y) = sum;
        }
    }
    return result;
}

double linearOfCode(uint8_t code) {
    const double s = code / 255.0;
    return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}

// Rec. 709 primaries under D65 (IEC 61966-2-1), as exact fractions.
const glm::dmat3 TO_XYZ = glm::transpose(glm::dmat3(10135552.0 / 24577794.0, 8788810.0 / 24577794.0, 4435075.0 / 24577794.0,  //
                                                    2613072.0 / 12288897.0, 8788810.0 / 12288897.0, 887015.0 / 12288897.0,    //
                                                    1425312.0 / 73733382.0, 8788810.0 / 73733382.0, 70074185.0 / 73733382.0));
const glm::dmat3 FROM_XYZ = glm::inverse(TO_XYZ);

/// Linear RGB to YCxCz, the opponent space that the contrast sensitivities are for (section 4.1.1).
dvec3 opponent(dvec3 rgb) {
    const dvec3 t = (TO_XYZ * rgb) / WHITE;
    return {116.0 * t.y - 16.0, 500.0 * (t.x - t.y), 200.0 * (t.y - t.z)};
}

dvec3 rgbOfOpponent(dvec3 o) {
    const double y = (o.x + 16.0) / 116.0;
    return FROM_XYZ * (WHITE * dvec3(y + o.y / 500.0, y, y - o.z / 200.0));
}

/// CIE L*a*b* with colour that counts less in the dark (Hunt's effect, section 4.1.2).
dvec3 huntLab(dvec3 rgb) {
    auto f = [](double t) {
        constexpr double DELTA = 6.0 / 29.0;
        return t > DELTA * DELTA * DELTA ? std::cbrt(t) : t / (3.0 * DELTA * DELTA) + 4.0 / 29.0;
    };
    const dvec3 t = (TO_XYZ * rgb) / WHITE;
    const double lightness = 116.0 * f(t.y) - 16.0;
    return {lightness, 0.01 * lightness * 500.0 * (f(t.x) - f(t.y)), 0.01 * lightness * 200.0 * (f(t.y) - f(t.z))};
}

/// Distance for colours that are far apart: city block in lightness, Euclidean in colour (HyAB, section 4.1.2).
double hyab(dvec3 a, dvec3 b) { return std::abs(a.x - b.x) + glm::length(dvec2(a.y - b.y, a.z - b.z)); }

/// One term of a contrast sensitivity: a sqrt(pi / b) exp(-pi^2 d^2 / b), d in degrees.
struct Sensitivity {
    double a, b;
};

struct Gaussian {
    Weights weights;  // of one direction, not normalised
    double scale;     // of both directions together
};

Gaussian gaussian(Sensitivity s, int radius, double pixelsPerDegree) {
    Gaussian g{Weights(), s.a * std::sqrt(pi / s.b)};
    for (int i = -radius; i <= radius; i++) {
        const double d = i / pixelsPerDegree;
        g.weights.push_back(std::exp(-pi * pi * d * d / s.b));
    }
    return g;
}

/// What the eye still sees of one opponent channel: a sum of two Gaussians of weight 1 together (section 4.1.1).
Plane<double> seen(const Plane<double>& channel, std::array<Sensitivity, 2> terms, double pixelsPerDegree) {
    constexpr double LARGEST_B = 0.04;
    const int radius = static_cast<int>(std::ceil(3.0 * std::sqrt(LARGEST_B / (2.0 * pi * pi)) * pixelsPerDegree));
    Plane<double> result(channel.width, channel.height);
    double total = 0.0;
    for (const Sensitivity& term : terms) {
        if (term.a == 0.0) continue;
        const Gaussian g = gaussian(term, radius, pixelsPerDegree);
        const double sum = std::accumulate(g.weights.begin(), g.weights.end(), 0.0);
        total += g.scale * sum * sum;
        const Plane<double> part = filtered(channel, g.weights, g.weights);
        for (size_t i = 0; i < part.values.size(); i++) result.values[i] += g.scale * part.values[i];
    }
    for (double& value : result.values) value /= total;
    return result;
}

/// A picture as its three opponent channels.
struct Opponent {
    std::array<Plane<double>, 3> channels;
    explicit Opponent(const DisplayImage& image)
        : channels{Plane<double>(static_cast<int>(image.width), static_cast<int>(image.height)),
                   Plane<double>(static_cast<int>(image.width), static_cast<int>(image.height)),
                   Plane<double>(static_cast<int>(image.width), static_cast<int>(image.height))} {
        for (size_t i = 0; i < channels[0].values.size(); i++) {
            const uint8_t* code = &image.rgba[4 * i];
            const dvec3 value = opponent({linearOfCode(code[0]), linearOfCode(code[1]), linearOfCode(code[2])});
            for (int k = 0; k < 3; k++) channels[static_cast<size_t>(k)].values[i] = value[k];
        }
    }
};

/// The colours that the eye sees at this distance, ready for hyab (sections 4.1.1 and 4.1.2).
std::vector<dvec3> seenColours(const Opponent& picture, double pixelsPerDegree) {
    const Plane<double> y = seen(picture.channels[0], {{{1.0, 0.0047}, {0.0, 1e-5}}}, pixelsPerDegree);
    const Plane<double> cx = seen(picture.channels[1], {{{1.0, 0.0053}, {0.0, 1e-5}}}, pixelsPerDegree);
    const Plane<double> cz = seen(picture.channels[2], {{{34.1, 0.04}, {13.5, 0.025}}}, pixelsPerDegree);
    std::vector<dvec3> colours(y.values.size());
    for (size_t i = 0; i < colours.size(); i++) {
        const dvec3 rgb = rgbOfOpponent({y.values[i], cx.values[i], cz.values[i]});
        colours[i] = huntLab(glm::clamp(rgb, dvec3(0.0), dvec3(1.0)));
    }
    return colours;
}

/// Scales the weights so that those above 0 add up to 1 and those below to -1 (section 4.2.1).
void balance(Weights& weights) {
    double above = 0.0, below = 0.0;
    for (double w : weights) (w > 0.0 ? above : below) += w;
    for (double& w : weights) w /= w > 0.0 ? above : -below;
}

/// Strength of edges (x) and of points (y) at each pixel (section 4.2.1).
std::vector<dvec2> features(const Plane<double>& y, double pixelsPerDegree) {
    const double deviation = 0.5 * FEATURE_WIDTH * pixelsPerDegree;
    const int radius = static_cast<int>(std::ceil(3.0 * deviation));
    Weights smooth, edge, point;
    for (int i = -radius; i <= radius; i++) {
        const double square = i * i / (deviation * deviation), g = std::exp(-0.5 * square);
        smooth.push_back(g);
        edge.push_back(-i * g);
        point.push_back((square - 1.0) * g);
    }
    const double sum = std::accumulate(smooth.begin(), smooth.end(), 0.0);
    for (double& w : smooth) w /= sum;
    balance(edge);
    balance(point);
    Plane<double> grey(y.width, y.height);
    for (size_t i = 0; i < grey.values.size(); i++) grey.values[i] = (y.values[i] + 16.0) / 116.0;
    const Plane<double> edgeX = filtered(grey, edge, smooth), edgeY = filtered(grey, smooth, edge);
    const Plane<double> pointX = filtered(grey, point, smooth), pointY = filtered(grey, smooth, point);
    std::vector<dvec2> result(grey.values.size());
    for (size_t i = 0; i < result.size(); i++) {
        result[i] = {std::hypot(edgeX.values[i], edgeY.values[i]), std::hypot(pointX.values[i], pointY.values[i])};
    }
    return result;
}

/// The most that two colours can differ: pure green and pure blue (section 4.1.3).
double largestColourError() { return std::pow(hyab(huntLab({0.0, 1.0, 0.0}), huntLab({0.0, 0.0, 1.0})), QC); }

/// Colour errors to 0..1; small ones keep most of the range (section 4.1.3).
double redistributed(double error, double largest) {
    const double bend = PC * largest;
    return error < bend ? PT / bend * error : PT + (error - bend) / (largest - bend) * (1.0 - PT);
}

}  // namespace

std::vector<float> flipMap(const DisplayImage& reference, const DisplayImage& test, double pixelsPerDegree) {
    if (reference.width != test.width || reference.height != test.height || reference.width == 0 || reference.height == 0) {
        throw std::invalid_argument("FLIP: pictures must be of one size, not empty");
    }
    const Opponent first(reference), second(test);
    const std::vector<dvec3> colours = seenColours(first, pixelsPerDegree), others = seenColours(second, pixelsPerDegree);
    const std::vector<dvec2> marks = features(first.channels[0], pixelsPerDegree);
    const std::vector<dvec2> otherMarks = features(second.channels[0], pixelsPerDegree);
    const double largest = largestColourError();
    std::vector<float> map(colours.size());
    for (size_t i = 0; i < map.size(); i++) {
        const double colour = redistributed(std::pow(hyab(colours[i], others[i]), QC), largest);
        const dvec2 apart = glm::abs(marks[i] - otherMarks[i]);
        const double feature = std::pow(std::max(apart.x, apart.y) / std::numbers::sqrt2, QF);
        map[i] = static_cast<float>(std::clamp(std::pow(colour, 1.0 - feature), 0.0, 1.0));  // section 4.3
    }
    return map;
}

double meanFlip(const std::vector<float>& map) {
    return map.empty() ? 0.0 : std::accumulate(map.begin(), map.end(), 0.0) / static_cast<double>(map.size());
}

}  // namespace heliograph
