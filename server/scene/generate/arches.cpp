#include "server/scene/generate/arches.h"

#include <algorithm>
#include <cmath>

namespace heliograph::generate {

float Arch::rise() const {
    const float center = radius - halfSpan;
    return std::sqrt(radius * radius - center * center);
}

float Arch::heightAt(float x) const {
    const float d = std::abs(x) + radius - halfSpan;
    return std::sqrt(std::max(0.0f, radius * radius - d * d));
}

std::vector<Arch::Point> Arch::leftHalf(uint32_t steps) const {
    const float center = radius - halfSpan,
                sweep = std::acos(-center / radius);  // angle from the springing to the apex
    std::vector<Point> points;
    for (uint32_t i = 0; i <= steps; ++i) {
        const float angle = (3.14159265f - sweep) * float(i) / float(steps);
        const vec2 normal(-std::cos(angle), std::sin(angle));
        points.push_back({vec2(center, 0.0f) + radius * normal, normal});
    }
    points.front().position = vec2(-halfSpan, 0.0f);
    points.back().position = vec2(0.0f, rise());
    return points;
}

Polyline Arch::outline(uint32_t stepsPerHalf) const {
    const std::vector<Point> half = leftHalf(stepsPerHalf);
    Polyline line;
    for (const Point& point : half) line.push_back(point.position);
    for (size_t i = half.size() - 1; i-- > 0;) line.push_back({-half[i].position.x, half[i].position.y});
    return line;
}

namespace {

/// The panel's face at depth z; `side` +1 looks along +z, -1 along -z.
void addPanelFace(MeshWriter& writer, const ArchedPanel& p, float z, float side) {
    auto rectangle = [&](float x0, float y0, float x1, float y1) {
        if (x1 - x0 < 1e-5f || y1 - y0 < 1e-5f) return;
        const vec2 a = side > 0 ? vec2(x0, x1) : vec2(x1, x0);
        writer.flatQuad({a.x, y0, z}, {a.y, y0, z}, {a.y, y1, z}, {a.x, y1, z}, {a.x, y0}, {a.y, y0}, {a.y, y1},
                        {a.x, y1});
    };
    const float left = p.center - p.arch.halfSpan, right = p.center + p.arch.halfSpan;
    const float levels[4] = {p.y0, p.sill, p.springing, p.y1};
    for (int i = 0; i < 3; ++i) {
        rectangle(p.x0, levels[i], left, levels[i + 1]);
        rectangle(right, levels[i], p.x1, levels[i + 1]);
    }
    rectangle(left, p.y0, right, p.sill);
    const Polyline line = p.arch.outline(p.steps);
    for (size_t i = 0; i + 1 < line.size(); ++i) {
        vec2 a = line[i] + vec2(p.center, p.springing), b = line[i + 1] + vec2(p.center, p.springing);
        if (side < 0) std::swap(a, b);
        writer.flatQuad({a.x, a.y, z}, {b.x, b.y, z}, {b.x, p.y1, z}, {a.x, p.y1, z}, a, b, {b.x, p.y1}, {a.x, p.y1});
    }
}

}  // namespace

void addArchedPanel(MeshWriter& writer, const ArchedPanel& p) {
    if (p.frontFace) addPanelFace(writer, p, p.front, 1.0f);
    if (p.backFace) addPanelFace(writer, p, p.back, -1.0f);
    if (!p.soffit) return;
    const float r = p.arch.halfSpan;
    const Polyline reveal = {{0.0f, p.back}, {0.0f, p.front}};
    const mat4 before = writer.transform();
    writer.setTransform(before * placed({p.center, p.springing, 0.0f}));
    addArchMoulding(writer, p.arch, reveal, p.steps, p.springing - p.sill);
    writer.setTransform(before);
    if (p.sill > p.y0) {
        writer.flatQuad({p.center - r, p.sill, p.front}, {p.center + r, p.sill, p.front},
                        {p.center + r, p.sill, p.back}, {p.center - r, p.sill, p.back});
    }
}

void addArchMoulding(MeshWriter& writer, const Arch& arch, const Polyline& profile, uint32_t stepsPerHalf, float leg,
                     float creaseDegrees) {
    const float crease = std::cos(glm::radians(creaseDegrees));
    std::vector<vec2> normals;  // (outward, z) of each piece
    for (size_t j = 0; j + 1 < profile.size(); ++j) {
        const vec2 d = glm::normalize(profile[j + 1] - profile[j]);
        normals.push_back({-d.y, d.x});
    }
    auto blended = [&](size_t a, size_t b) {
        if (b >= normals.size() || glm::dot(normals[a], normals[b]) < crease) return normals[a];
        return glm::normalize(normals[a] + normals[b]);
    };
    float across = 0.0f;
    for (size_t j = 0; j < normals.size(); ++j) {
        const float width = glm::length(profile[j + 1] - profile[j]);
        const vec2 nFrom = blended(j, j - 1), nTo = blended(j, j + 1);  // j - 1 wraps to a huge index for j = 0
        const auto from = arch.offset(profile[j].x).leftHalf(stepsPerHalf),
                   to = arch.offset(profile[j + 1].x).leftHalf(stepsPerHalf);
        for (float side : {1.0f, -1.0f}) {
            uint32_t previousFrom = 0, previousTo = 0;
            float along = -leg;
            const int first = leg > 0.0f ? -1 : 0;
            for (int i = first; i <= int(stepsPerHalf); ++i) {
                auto corner = [&](const std::vector<Arch::Point>& points, vec2 n, vec2 offset, float v) {
                    const Arch::Point& p = points[size_t(std::max(i, 0))];
                    const float y = i < 0 ? -leg : p.position.y;
                    return writer.vertex({side * p.position.x, y, offset.y},
                                         {side * p.normal.x * n.x, p.normal.y * n.x, n.y}, {along, v});
                };
                const uint32_t a = corner(from, nFrom, profile[j], across),
                               b = corner(to, nTo, profile[j + 1], across + width);
                if (i > first) {
                    if (side > 0) writer.quad(previousFrom, a, b, previousTo);
                    else writer.quad(previousFrom, previousTo, b, a);
                }
                previousFrom = a, previousTo = b;
                if (i >= 0 && i < int(stepsPerHalf))
                    along += glm::length(from[size_t(i) + 1].position - from[size_t(i)].position);
                else if (i < 0) along = 0.0f;
            }
        }
        across += width;
    }
}

void addGroinVault(MeshWriter& writer, const Arch& arch, float halfZ, uint32_t stepsPerHalf) {
    const auto half = arch.leftHalf(stepsPerHalf);
    const float stretch = halfZ / arch.halfSpan;
    for (int web = 0; web < 4; ++web) {       // 0, 1: along +z, -z; 2, 3: along +x, -x
        const float end = web & 1 ? -1.0f : 1.0f;
        for (float side : {1.0f, -1.0f}) {    // the two halves of the web's arch
            uint32_t previousInner = 0, previousOuter = 0;
            for (uint32_t i = 0; i <= stepsPerHalf; ++i) {
                const vec2 p = half[i].position, n = half[i].normal;
                const float across = side * p.x, inner = end * std::abs(p.x), outer = end * arch.halfSpan;
                vec3 a, b, normal;
                if (web < 2) {
                    a = {across, p.y, inner * stretch}, b = {across, p.y, outer * stretch};
                    normal = {-side * n.x, -n.y, 0.0f};
                } else {
                    a = {inner, p.y, across * stretch}, b = {outer, p.y, across * stretch};
                    normal = {0.0f, -n.y, -side * n.x / stretch};
                }
                const uint32_t ia = writer.vertex(a, normal, {std::abs(inner), 1.6f * p.y + p.x});
                const uint32_t ib = writer.vertex(b, normal, {std::abs(outer), 1.6f * p.y + p.x});
                if (i > 0) {
                    const bool flip = (side * end > 0.0f) != (web < 2);
                    auto emit = [&](uint32_t u, uint32_t v, uint32_t w) {
                        flip ? writer.triangle(u, v, w) : writer.triangle(u, w, v);
                    };
                    if (i > 1) emit(previousInner, previousOuter, ib);  // the first strip starts in a point
                    emit(previousInner, ib, ia);
                }
                previousInner = ia, previousOuter = ib;
            }
        }
    }
}

void addDiagonalRibs(MeshWriter& writer, const Arch& arch, float halfZ, uint32_t stepsPerHalf, float halfWidth,
                     float depth) {
    const Polyline section = {{-halfWidth, 0.06f}, {-halfWidth, -0.4f * depth}, {-0.35f * halfWidth, -depth},
                              {0.35f * halfWidth, -depth}, {halfWidth, -0.4f * depth}, {halfWidth, 0.06f}};
    const auto half = arch.leftHalf(stepsPerHalf);
    const float stretch = halfZ / arch.halfSpan;
    for (float sx : {1.0f, -1.0f}) {
        for (float sz : {1.0f, -1.0f}) {
            const vec3 outward = glm::normalize(vec3(sx, 0.0f, sz * stretch));  // from the crown to this springing
            const float lengthen = std::sqrt(1.0f + stretch * stretch);
            std::vector<SweepFrame> frames;
            for (uint32_t i = 0; i <= stepsPerHalf; ++i) {
                const vec2 p = half[i].position, n = half[i].normal;
                // In the diagonal's vertical plane the curve is the arch, stretched horizontally.
                const vec3 up = glm::normalize(outward * (-n.x / lengthen) + vec3(0.0f, n.y, 0.0f));
                frames.push_back({vec3(-sx * p.x, p.y, -sz * p.x * stretch), vec3(0.0f), up, vec3(0.0f)});
            }
            for (size_t i = 0; i < frames.size(); ++i) {
                const size_t a = i == 0 ? 0 : i - 1, b = std::min(i + 1, frames.size() - 1);
                const vec3 forward = glm::normalize(frames[b].position - frames[a].position);
                frames[i].right = frames[i].normalRight = glm::normalize(glm::cross(frames[i].up, forward));
            }
            // Opposite ribs are mitred where they meet, or their sides would lie on each other.
            frames.back().up = vec3(0.0f, 1.0f / frames.back().up.y, 0.0f);
            addSweep(writer, frames, section, {.closedSection = false, .creaseDegrees = 20.0f});
        }
    }
}

}  // namespace heliograph::generate
