#include "server/scene/generate/glass_parts.h"

#include "server/scene/generate/blob.h"
#include "server/scene/generate/shapes.h"

#include <algorithm>
#include <cmath>

namespace heliograph::generate {

namespace {

/// The profile with `steps` pieces between its points, along a Catmull-Rom spline; radii stay >= 0.
Polyline smoothed(const Polyline& profile, int steps) {
    Polyline fine;
    for (size_t i = 0; i + 1 < profile.size(); ++i) {
        const vec2 p0 = profile[i == 0 ? 0 : i - 1], p1 = profile[i], p2 = profile[i + 1],
                   p3 = profile[std::min(i + 2, profile.size() - 1)];
        for (int j = 0; j < steps; ++j) {
            const float t = float(j) / float(steps);
            vec2 p = 0.5f * (2.0f * p1 + t * (p2 - p0) + t * t * (2.0f * p0 - 5.0f * p1 + 4.0f * p2 - p3) +
                             t * t * t * (3.0f * p1 - p0 - 3.0f * p2 + p3));
            if (j == 0) p = p1;
            p.x = std::max(p.x, 0.0f);
            fine.push_back(p);
        }
    }
    fine.push_back(profile.back());
    return fine;
}

void addGlassBody(MeshWriter& writer, const Polyline& profile, uint32_t segments) {
    addLathe(writer, profile, {.segments = segments, .creaseDegrees = 62.0f, .textureSize = 0.1f});
}

Polyline joined(std::initializer_list<Polyline> parts) {
    Polyline all;
    for (const Polyline& part : parts) all.insert(all.end(), part.begin(), part.end());
    return all;
}

}  // namespace

void addWineGlass(MeshWriter& writer) {
    const Polyline foot = smoothed({{0.036f, 0.0008f}, {0.0368f, 0.0018f}, {0.0355f, 0.0030f}, {0.020f, 0.0050f},
                                    {0.0075f, 0.0100f}, {0.0042f, 0.0220f}, {0.0038f, 0.0550f}, {0.0042f, 0.0820f},
                                    {0.0075f, 0.0930f}, {0.0200f, 0.1030f}, {0.0335f, 0.1210f}, {0.0400f, 0.1450f},
                                    {0.0402f, 0.1650f}, {0.0365f, 0.1950f}, {0.0330f, 0.2180f}, {0.0325f, 0.2190f},
                                    {0.0319f, 0.2180f}},
                                   2);
    const Polyline bowl = smoothed({{0.0353f, 0.1950f}, {0.0389f, 0.1650f}, {0.0387f, 0.1455f}, {0.0322f, 0.1222f},
                                    {0.0187f, 0.1048f}, {0.0070f, 0.0985f}, {0.0f, 0.0975f}},
                                   3);
    addGlassBody(writer, joined({{{0.0f, 0.0008f}, {0.018f, 0.0008f}}, foot, bowl}), 56);
}

void addTumbler(MeshWriter& writer) {
    const Polyline outside = smoothed({{0.0300f, 0.0f}, {0.0325f, 0.0008f}, {0.0335f, 0.0030f}, {0.0360f, 0.0300f},
                                       {0.0390f, 0.0650f}, {0.0415f, 0.0985f}, {0.0408f, 0.0998f}, {0.0397f, 0.0985f}},
                                      3);
    const Polyline inside = smoothed({{0.0372f, 0.0650f}, {0.0342f, 0.0300f}, {0.0318f, 0.0150f}, {0.0290f, 0.0125f},
                                      {0.0150f, 0.0118f}, {0.0f, 0.0115f}},
                                     3);
    addGlassBody(writer, joined({{{0.0f, 0.0f}, {0.015f, 0.0f}}, outside, inside}), 48);
}

void addCarafe(MeshWriter& writer) {
    const Polyline outside = smoothed({{0.0500f, 0.0f}, {0.0570f, 0.0030f}, {0.0600f, 0.0120f}, {0.0660f, 0.0500f},
                                       {0.0640f, 0.0900f}, {0.0470f, 0.1300f}, {0.0290f, 0.1620f}, {0.0235f, 0.1950f},
                                       {0.0265f, 0.2350f}, {0.0355f, 0.2620f}, {0.0352f, 0.2636f}, {0.0336f, 0.2625f}},
                                      3);
    const Polyline inside = smoothed({{0.0243f, 0.2360f}, {0.0212f, 0.1950f}, {0.0266f, 0.1610f}, {0.0445f, 0.1290f},
                                      {0.0615f, 0.0890f}, {0.0635f, 0.0500f}, {0.0575f, 0.0160f}, {0.0480f, 0.0090f},
                                      {0.0240f, 0.0110f}, {0.0f, 0.0140f}},
                                     3);
    addGlassBody(writer, joined({{{0.0f, 0.0f}, {0.025f, 0.0f}}, outside, inside}), 56);
}

void addRabbit(MeshWriter& writer) {
    // Modelled one unit tall up to the crown of the ears, then scaled.
    auto earAxes = [](float side) {
        const vec3 along = glm::normalize(vec3(-0.42f, 0.90f, 0.16f * side)),
                   across = glm::normalize(glm::cross(along, vec3(1.0f, 0.25f, 0.25f * side)));
        return mat3(across, along, glm::cross(across, along));
    };
    const mat3 leftEar = earAxes(1.0f), rightEar = earAxes(-1.0f);
    const DistanceField rabbit = [=](vec3 p) {
        float d = ellipsoid(p, {-0.07f, 0.30f, 0.0f}, {0.33f, 0.29f, 0.24f});
        d = softUnion(d, ellipsoid(p, {0.17f, 0.34f, 0.0f}, {0.17f, 0.25f, 0.17f}), 0.16f);
        for (float s : {-1.0f, 1.0f}) {
            d = softUnion(d, ellipsoid(p, {-0.17f, 0.22f, 0.16f * s}, {0.20f, 0.20f, 0.115f}), 0.07f);
            d = softUnion(d, capsule(p, {-0.16f, 0.045f, 0.19f * s}, {0.10f, 0.042f, 0.20f * s}, 0.048f), 0.07f);
            d = softUnion(d, capsule(p, {0.23f, 0.28f, 0.085f * s}, {0.28f, 0.06f, 0.085f * s}, 0.052f), 0.07f);
            d = softUnion(d, capsule(p, {0.28f, 0.042f, 0.085f * s}, {0.37f, 0.038f, 0.09f * s}, 0.042f), 0.04f);
        }
        float head = ellipsoid(p, {0.31f, 0.665f, 0.0f}, {0.165f, 0.140f, 0.130f});
        head = softUnion(head, ellipsoid(p, {0.425f, 0.625f, 0.0f}, {0.085f, 0.072f, 0.078f}), 0.09f);
        for (float s : {-1.0f, 1.0f})
            head = softUnion(head, ellipsoid(p, {0.36f, 0.71f, 0.098f * s}, vec3(0.034f)), 0.03f);
        head = softUnion(head, ellipsoid(p, {0.145f, 0.925f, 0.095f}, {0.064f, 0.215f, 0.036f}, leftEar), 0.05f);
        head = softUnion(head, ellipsoid(p, {0.145f, 0.925f, -0.095f}, {0.064f, 0.215f, 0.036f}, rightEar), 0.05f);
        d = softUnion(d, head, 0.12f);
        d = softUnion(d, ellipsoid(p, {-0.40f, 0.20f, 0.0f}, vec3(0.095f)), 0.05f);
        return softIntersection(d, -p.y, 0.02f);  // it sits flat
    };
    const mat4 before = writer.transform();
    writer.setTransform(before * scaled(0.26f));
    addBlob(writer, {-0.60f, -0.06f, -0.40f}, {0.62f, 1.26f, 0.40f}, 0.0162f, rabbit);
    writer.setTransform(before);
}

void addTeapot(MeshWriter& writer) {
    const Polyline body = smoothed({{0.0f, 0.004f}, {0.045f, 0.003f}, {0.062f, 0.0f}, {0.066f, 0.004f},
                                    {0.070f, 0.012f}, {0.098f, 0.045f}, {0.110f, 0.085f}, {0.098f, 0.125f},
                                    {0.070f, 0.150f}, {0.058f, 0.155f}},
                                   4);
    const Polyline lid = smoothed({{0.0585f, 0.1560f}, {0.0620f, 0.1600f}, {0.0590f, 0.1650f}, {0.035f, 0.1780f},
                                   {0.014f, 0.1830f}, {0.0085f, 0.1890f}, {0.0130f, 0.1970f}, {0.0165f, 0.2060f},
                                   {0.0110f, 0.2150f}, {0.0f, 0.2175f}},
                                  4);
    addLathe(writer, joined({body, lid}), {.segments = 56, .creaseDegrees = 50.0f, .textureSize = 0.1f});
    auto tube = [&](const std::vector<vec3>& points, const std::vector<float>& radii, bool caps) {
        std::vector<vec3> curve;
        std::vector<float> radius;
        const size_t n = points.size();
        for (size_t i = 0; i + 1 < n; ++i) {
            for (int j = 0; j < 8; ++j) {
                const float t = float(j) / 8.0f;
                const vec3 p0 = points[i == 0 ? 0 : i - 1], p1 = points[i], p2 = points[i + 1],
                           p3 = points[std::min(i + 2, n - 1)];
                curve.push_back(0.5f * (2.0f * p1 + t * (p2 - p0) + t * t * (2.0f * p0 - 5.0f * p1 + 4.0f * p2 - p3) +
                                        t * t * t * (3.0f * p1 - p0 - 3.0f * p2 + p3)));
                radius.push_back(glm::mix(radii[i], radii[i + 1], t * t * (3.0f - 2.0f * t)));
            }
        }
        curve.push_back(points.back()), radius.push_back(radii.back());
        addSweep(writer, framesAlong(curve, radius, false), circleSection(20), {.caps = caps, .creaseDegrees = 60.0f});
    };
    tube({{0.085f, 0.050f, 0.0f}, {0.125f, 0.062f, 0.0f}, {0.150f, 0.105f, 0.0f}, {0.172f, 0.148f, 0.0f},
          {0.192f, 0.160f, 0.0f}},
         {0.032f, 0.026f, 0.017f, 0.0135f, 0.012f}, true);
    tube({{-0.085f, 0.125f, 0.0f}, {-0.125f, 0.142f, 0.0f}, {-0.165f, 0.130f, 0.0f}, {-0.172f, 0.092f, 0.0f},
          {-0.140f, 0.056f, 0.0f}, {-0.095f, 0.046f, 0.0f}},
         {0.010f, 0.0105f, 0.011f, 0.0105f, 0.010f, 0.010f}, true);
}

void addTorusKnot(MeshWriter& writer) {
    constexpr int STEPS = 360;
    std::vector<vec3> curve;
    for (int i = 0; i < STEPS; ++i) {
        const float t = 6.2831853f * float(i) / float(STEPS), ring = 0.105f + 0.046f * std::cos(3.0f * t);
        curve.push_back({ring * std::cos(2.0f * t), ring * std::sin(2.0f * t), 0.046f * std::sin(3.0f * t)});
    }
    addSweep(writer, framesAlong(curve, std::vector<float>(STEPS, 0.024f), true), circleSection(26),
             {.closedPath = true, .creaseDegrees = 40.0f});
}

}  // namespace heliograph::generate
