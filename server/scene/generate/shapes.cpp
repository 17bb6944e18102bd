#include "server/scene/generate/shapes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace heliograph::generate {

namespace {

constexpr float PI = std::numbers::pi_v<float>;

/// One straight piece of a profile with the normals at its ends and the length before it.
struct ProfilePiece {
    vec2 from, to;
    vec2 normalFrom, normalTo;
    float lengthFrom, lengthTo;
};

vec2 rightOf(vec2 direction) { return vec2(direction.y, -direction.x); }

/// Cuts a profile into pieces and shares normals between pieces that meet at less than the crease angle.
std::vector<ProfilePiece> piecesOf(const Polyline& profile, bool closed, float creaseDegrees) {
    std::vector<ProfilePiece> pieces;
    const size_t count = closed ? profile.size() : profile.size() - 1;
    float length = 0.0f;
    for (size_t i = 0; i < count; ++i) {
        const vec2 from = profile[i], to = profile[(i + 1) % profile.size()];
        const float step = glm::length(to - from);
        if (step < 1e-7f) continue;
        const vec2 normal = rightOf((to - from) / step);
        pieces.push_back({from, to, normal, normal, length, length + step});
        length += step;
    }
    const float crease = std::cos(glm::radians(creaseDegrees));
    std::vector<vec2> flat;
    for (const ProfilePiece& piece : pieces) flat.push_back(piece.normalFrom);
    for (size_t i = 0; i < pieces.size(); ++i) {
        if (i + 1 == pieces.size() && !closed) break;
        const size_t next = (i + 1) % pieces.size();
        if (glm::dot(flat[i], flat[next]) < crease) continue;
        pieces[i].normalTo = pieces[next].normalFrom = glm::normalize(flat[i] + flat[next]);
    }
    return pieces;
}

}  // namespace

void addBox(MeshWriter& writer, vec3 low, vec3 high, uint32_t faces) {
    const vec3 l = low, h = high;
    auto face = [&](uint32_t bit, vec3 a, vec3 b, vec3 c, vec3 d, auto uv) {
        if (faces & bit) writer.flatQuad(a, b, c, d, uv(a), uv(b), uv(c), uv(d));
    };
    auto alongX = [](vec3 p) { return vec2(p.z, p.y); };
    auto alongY = [](vec3 p) { return vec2(p.x, p.z); };
    auto alongZ = [](vec3 p) { return vec2(p.x, p.y); };
    face(BOX_LEFT, {l.x, l.y, l.z}, {l.x, l.y, h.z}, {l.x, h.y, h.z}, {l.x, h.y, l.z}, alongX);
    face(BOX_RIGHT, {h.x, l.y, h.z}, {h.x, l.y, l.z}, {h.x, h.y, l.z}, {h.x, h.y, h.z}, alongX);
    face(BOX_BOTTOM, {l.x, l.y, l.z}, {h.x, l.y, l.z}, {h.x, l.y, h.z}, {l.x, l.y, h.z}, alongY);
    face(BOX_TOP, {l.x, h.y, h.z}, {h.x, h.y, h.z}, {h.x, h.y, l.z}, {l.x, h.y, l.z}, alongY);
    face(BOX_BACK, {h.x, l.y, l.z}, {l.x, l.y, l.z}, {l.x, h.y, l.z}, {h.x, h.y, l.z}, alongZ);
    face(BOX_FRONT, {l.x, l.y, h.z}, {h.x, l.y, h.z}, {h.x, h.y, h.z}, {l.x, h.y, h.z}, alongZ);
}

void addBeveledBox(MeshWriter& writer, vec3 low, vec3 high, float bevel) {
    const vec3 center = 0.5f * (low + high), outer = 0.5f * (high - low), inner = outer - vec3(bevel);
    auto emit = [&](std::vector<vec3> corners, vec3 outward) {
        if (glm::dot(glm::cross(corners[1] - corners[0], corners[2] - corners[0]), outward) < 0.0f)
            std::reverse(corners.begin(), corners.end());
        const vec3 n = glm::abs(outward);
        std::vector<uint32_t> ids;
        for (const vec3& corner : corners) {
            const vec3 p = center + corner;
            const vec2 uv = n.y > 0.9f ? vec2(p.x, p.z) : (n.x > n.z ? vec2(p.z, p.y) : vec2(p.x, p.y));
            ids.push_back(writer.vertex(p, outward, uv));
        }
        for (size_t i = 2; i < ids.size(); ++i) writer.triangle(ids[0], ids[i - 1], ids[i]);
    };
    for (int axis = 0; axis < 3; ++axis) {
        const int b = (axis + 1) % 3, c = (axis + 2) % 3;
        for (float side : {-1.0f, 1.0f}) {
            vec3 normal(0.0f), p0, p1, p2, p3;
            normal[axis] = side;
            p0[axis] = p1[axis] = p2[axis] = p3[axis] = side * outer[axis];
            p0[b] = p3[b] = -inner[b], p1[b] = p2[b] = inner[b];
            p0[c] = p1[c] = -inner[c], p2[c] = p3[c] = inner[c];
            emit({p0, p1, p2, p3}, normal);
            // The two bevels between this face and the faces of axis b, along axis c.
            for (float other : {-1.0f, 1.0f}) {
                vec3 tilt(0.0f), q0, q1, q2, q3;
                tilt[axis] = side, tilt[b] = other;
                q0[axis] = q1[axis] = side * outer[axis], q2[axis] = q3[axis] = side * inner[axis];
                q0[b] = q1[b] = other * inner[b], q2[b] = q3[b] = other * outer[b];
                q0[c] = q3[c] = -inner[c], q1[c] = q2[c] = inner[c];
                emit({q0, q1, q2, q3}, glm::normalize(tilt));
            }
        }
    }
    for (int corner = 0; corner < 8; ++corner) {
        const vec3 s(corner & 1 ? 1.0f : -1.0f, corner & 2 ? 1.0f : -1.0f, corner & 4 ? 1.0f : -1.0f);
        emit({s * vec3(outer.x, inner.y, inner.z), s * vec3(inner.x, outer.y, inner.z),
              s * vec3(inner.x, inner.y, outer.z)},
             glm::normalize(s));
    }
}

void addLathe(MeshWriter& writer, const Polyline& profile, const LatheOptions& options) {
    float girth = 0.0f;
    for (const vec2& point : profile) girth = std::max(girth, 2.0f * PI * point.x);
    girth = std::max(1.0f, std::round(girth / options.textureSize)) * options.textureSize;
    const float start = glm::radians(options.startDegrees);
    const uint32_t n = options.segments;
    for (const ProfilePiece& piece : piecesOf(profile, options.closed, options.creaseDegrees)) {
        std::vector<uint32_t> low, high;
        for (uint32_t i = 0; i <= n; ++i) {
            const float angle =
                start + 2.0f * PI * float(i % n) / float(n);  // the seam's two columns agree in every bit
            const float c = std::cos(angle), s = std::sin(angle), u = girth * float(i) / float(n);
            low.push_back(writer.vertex({piece.from.x * c, piece.from.y, -piece.from.x * s},
                                        {piece.normalFrom.x * c, piece.normalFrom.y, -piece.normalFrom.x * s},
                                        {u, piece.lengthFrom}));
            high.push_back(writer.vertex({piece.to.x * c, piece.to.y, -piece.to.x * s},
                                         {piece.normalTo.x * c, piece.normalTo.y, -piece.normalTo.x * s},
                                         {u, piece.lengthTo}));
        }
        for (uint32_t i = 0; i < n; ++i) {
            if (piece.from.x > 0.0f) writer.triangle(low[i], low[i + 1], high[i + 1]);
            if (piece.to.x > 0.0f) writer.triangle(low[i], high[i + 1], high[i]);
        }
    }
}

void addSweep(MeshWriter& writer, std::span<const SweepFrame> frames, const Polyline& section,
              const SweepOptions& options) {
    const std::vector<ProfilePiece> pieces = piecesOf(section, options.closedSection, options.creaseDegrees);
    const size_t steps = options.closedPath ? frames.size() : frames.size() - 1;
    auto at = [&](const SweepFrame& f, vec2 p) { return f.position + p.x * f.right + p.y * f.up; };
    auto normalAt = [&](const SweepFrame& f, vec2 n) {
        return n.x * glm::normalize(f.normalRight) + n.y * glm::normalize(f.up);
    };
    for (const ProfilePiece& piece : pieces) {
        float along = 0.0f;
        uint32_t previousFrom = 0, previousTo = 0;
        for (size_t i = 0; i <= steps; ++i) {
            const SweepFrame& f = frames[i % frames.size()];
            if (i > 0) along += glm::length(f.position - frames[i - 1].position);
            const float size = glm::length(f.right);
            const uint32_t from =
                writer.vertex(at(f, piece.from), normalAt(f, piece.normalFrom), {along, piece.lengthFrom * size});
            const uint32_t to =
                writer.vertex(at(f, piece.to), normalAt(f, piece.normalTo), {along, piece.lengthTo * size});
            if (i > 0) writer.quad(previousFrom, previousTo, to, from);
            previousFrom = from, previousTo = to;
        }
    }
    if (!options.caps) return;
    auto cap = [&](const SweepFrame& f, bool forward) {
        const vec3 normal = glm::cross(f.right, f.up) * (forward ? 1.0f : -1.0f);
        std::vector<uint32_t> ids;
        for (const vec2& p : section) ids.push_back(writer.vertex(at(f, p), normal, p * glm::length(f.right)));
        for (size_t i = 2; i < ids.size(); ++i) {
            if (forward) writer.triangle(ids[0], ids[i - 1], ids[i]);
            else writer.triangle(ids[0], ids[i], ids[i - 1]);
        }
    };
    cap(frames.front(), false);
    cap(frames.back(), true);
}

std::vector<SweepFrame> framesAlong(std::span<const vec3> curve, std::span<const float> radius, bool closed) {
    const size_t n = curve.size();
    auto tangentAt = [&](size_t i) {
        const size_t before = closed ? (i + n - 1) % n : (i == 0 ? 0 : i - 1),
                     after = closed ? (i + 1) % n : std::min(i + 1, n - 1);
        return glm::normalize(curve[after] - curve[before]);
    };
    // Rotates `v` as the shortest turn from `a` to `b` does.
    auto carried = [](vec3 v, vec3 a, vec3 b) {
        const vec3 axis = glm::cross(a, b);
        const float c = glm::dot(a, b);
        return v * c + glm::cross(axis, v) + axis * (glm::dot(axis, v) / (1.0f + c));
    };
    std::vector<SweepFrame> frames(n);
    vec3 tangent = tangentAt(0);
    const vec3 helper = std::abs(tangent.y) < 0.9f ? vec3(0, 1, 0) : vec3(1, 0, 0);
    vec3 right = glm::normalize(glm::cross(helper, tangent));
    const vec3 firstRight = right;
    for (size_t i = 0; i < n; ++i) {
        const vec3 next = tangentAt(i);
        right = glm::normalize(carried(right, tangent, next));
        tangent = next;
        frames[i] = {curve[i], right, glm::cross(tangent, right), right};
    }
    float twist = 0.0f;
    if (closed) {
        const vec3 last = carried(right, tangent, tangentAt(0));
        twist = std::atan2(glm::dot(glm::cross(last, firstRight), tangentAt(0)), glm::dot(last, firstRight));
    }
    for (size_t i = 0; i < n; ++i) {
        const float angle = twist * float(i) / float(n), c = std::cos(angle), s = std::sin(angle);
        const vec3 r = frames[i].right, u = frames[i].up;
        frames[i].right = (c * r + s * u) * radius[i];
        frames[i].up = (c * u - s * r) * radius[i];
        frames[i].normalRight = frames[i].right;
    }
    return frames;
}

Polyline circleSection(uint32_t corners) {
    Polyline section;
    for (uint32_t i = 0; i < corners; ++i) {
        const float angle = 2.0f * PI * float(i) / float(corners);
        section.push_back({std::cos(angle), std::sin(angle)});
    }
    return section;
}

void addRectangleSweep(MeshWriter& writer, float halfX, float halfZ, const Polyline& profile, float creaseDegrees) {
    // Corners of side k and the side's outward direction; sides run counter-clockwise seen from above.
    const vec2 outward[4] = {{1, 0}, {0, -1}, {-1, 0}, {0, 1}};
    for (const ProfilePiece& piece : piecesOf(profile, false, creaseDegrees)) {
        for (int side = 0; side < 4; ++side) {
            const vec2 out = outward[side], along(out.y, -out.x);  // (x, z)
            const float half = std::abs(out.x) > 0.5f ? halfX : halfZ,
                        halfLength = std::abs(out.x) > 0.5f ? halfZ : halfX;
            auto at = [&](vec2 p, float end) {
                const vec2 xz = out * (half + p.x) + along * (end * (halfLength + p.x));
                return vec3(xz.x, p.y, xz.y);
            };
            auto normal = [&](vec2 n) { return vec3(out.x * n.x, n.y, out.y * n.x); };
            const float fromEnd = halfLength + piece.from.x, toEnd = halfLength + piece.to.x;
            const uint32_t a =
                writer.vertex(at(piece.from, -1.0f), normal(piece.normalFrom), {-fromEnd, piece.lengthFrom});
            const uint32_t b =
                writer.vertex(at(piece.from, 1.0f), normal(piece.normalFrom), {fromEnd, piece.lengthFrom});
            const uint32_t c = writer.vertex(at(piece.to, 1.0f), normal(piece.normalTo), {toEnd, piece.lengthTo});
            const uint32_t d = writer.vertex(at(piece.to, -1.0f), normal(piece.normalTo), {-toEnd, piece.lengthTo});
            writer.quad(a, b, c, d);
        }
    }
}

void addProfiledPrism(MeshWriter& writer, const Polyline& section, const Polyline& profile, float creaseDegrees) {
    float size = 0.0f;  // turns scale into metres, so that the profile has true slopes
    for (const vec2& p : section) size = std::max(size, glm::length(p));
    Polyline scaledProfile;
    for (const vec2& p : profile) scaledProfile.push_back({p.x * size, p.y});
    const std::vector<ProfilePiece> around = piecesOf(section, true, creaseDegrees);
    for (const ProfilePiece& rise : piecesOf(scaledProfile, false, creaseDegrees)) {
        for (const ProfilePiece& side : around) {
            auto corner = [&](vec2 p, vec2 n, float along, vec2 at, vec2 slope, float height) {
                const float scale = at.x / size, lean = slope.y * glm::dot(p, n) / size;
                return writer.vertex({p.x * scale, at.y, -p.y * scale}, {n.x * slope.x, lean, -n.y * slope.x},
                                     {along * scale, height});
            };
            const uint32_t a =
                corner(side.from, side.normalFrom, side.lengthFrom, rise.from, rise.normalFrom, rise.lengthFrom);
            const uint32_t b =
                corner(side.to, side.normalTo, side.lengthTo, rise.from, rise.normalFrom, rise.lengthFrom);
            const uint32_t c = corner(side.to, side.normalTo, side.lengthTo, rise.to, rise.normalTo, rise.lengthTo);
            const uint32_t d =
                corner(side.from, side.normalFrom, side.lengthFrom, rise.to, rise.normalTo, rise.lengthTo);
            writer.quad(a, b, c, d);
        }
    }
}

void addSurface(MeshWriter& writer, uint32_t columns, uint32_t rows, vec2 uvScale,
                const std::function<vec3(float, float)>& at) {
    const float eps = 1e-3f;
    std::vector<uint32_t> ids;
    for (uint32_t j = 0; j <= rows; ++j) {
        for (uint32_t i = 0; i <= columns; ++i) {
            const float u = float(i) / float(columns), v = float(j) / float(rows);
            const vec3 du = at(std::min(u + eps, 1.0f), v) - at(std::max(u - eps, 0.0f), v);
            const vec3 dv = at(u, std::min(v + eps, 1.0f)) - at(u, std::max(v - eps, 0.0f));
            ids.push_back(writer.vertex(at(u, v), glm::cross(du, dv), vec2(u, v) * uvScale));
        }
    }
    for (uint32_t j = 0; j < rows; ++j) {
        for (uint32_t i = 0; i < columns; ++i) {
            const uint32_t a = j * (columns + 1) + i, b = a + columns + 1;
            writer.quad(ids[a], ids[a + 1], ids[b + 1], ids[b]);
        }
    }
}

void addSphere(MeshWriter& writer, float radius, uint32_t segments, uint32_t rings) {
    Polyline profile;
    for (uint32_t i = 0; i <= rings; ++i) {
        const float angle = PI * float(i) / float(rings);
        const bool pole = i == 0 || i == rings;
        profile.push_back({pole ? 0.0f : radius * std::sin(angle), -radius * std::cos(angle)});
    }
    addLathe(writer, profile, {.segments = segments, .creaseDegrees = 60.0f});
}

}  // namespace heliograph::generate
