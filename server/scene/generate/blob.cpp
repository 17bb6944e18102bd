#include "server/scene/generate/blob.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace heliograph::generate {

float ellipsoid(vec3 p, vec3 center, vec3 radii, const mat3& axes) {
    const vec3 q = glm::transpose(axes) * (p - center);
    const float k0 = glm::length(q / radii), k1 = glm::length(q / (radii * radii));
    if (k1 < 1e-6f) return -std::min({radii.x, radii.y, radii.z});
    return k0 * (k0 - 1.0f) / k1;
}

float capsule(vec3 p, vec3 a, vec3 b, float radius) {
    const vec3 along = b - a;
    const float t = std::clamp(glm::dot(p - a, along) / glm::dot(along, along), 0.0f, 1.0f);
    return glm::length(p - a - along * t) - radius;
}

float softUnion(float a, float b, float radius) {
    const float h = std::max(radius - std::abs(a - b), 0.0f) / radius;
    return std::min(a, b) - h * h * radius * 0.25f;
}

namespace {

/// The field at the corners of a grid of cubes, and the vertices of the cubes that the surface crosses.
class Net {
public:
    Net(vec3 low, vec3 high, float cell, const DistanceField& field) : low_(low), cell_(cell), field_(field) {
        for (int axis = 0; axis < 3; ++axis) size_[axis] = int(std::ceil((high[axis] - low[axis]) / cell)) + 1;
        values_.resize(size_t(size_.x) * size_t(size_.y) * size_t(size_.z));
        for (int z = 0; z < size_.z; ++z)
            for (int y = 0; y < size_.y; ++y)
                for (int x = 0; x < size_.x; ++x) values_[index({x, y, z})] = field(corner({x, y, z}));
        vertices_.assign(values_.size(), NO_INDEX);
    }

    void write(MeshWriter& writer) {
        for (int z = 0; z + 1 < size_.z; ++z)
            for (int y = 0; y + 1 < size_.y; ++y)
                for (int x = 0; x + 1 < size_.x; ++x) addVertex(writer, {x, y, z});
        for (int z = 1; z + 1 < size_.z; ++z)
            for (int y = 1; y + 1 < size_.y; ++y)
                for (int x = 1; x + 1 < size_.x; ++x)
                    for (int axis = 0; axis < 3; ++axis) addQuad(writer, {x, y, z}, axis);
    }

private:
    size_t index(glm::ivec3 c) const {
        return (size_t(c.z) * size_t(size_.y) + size_t(c.y)) * size_t(size_.x) + size_t(c.x);
    }
    vec3 corner(glm::ivec3 c) const { return low_ + cell_ * vec3(c); }

    vec3 gradient(vec3 p) const {
        const float e = 0.1f * cell_;
        return vec3(field_(p + vec3(e, 0, 0)) - field_(p - vec3(e, 0, 0)),
                    field_(p + vec3(0, e, 0)) - field_(p - vec3(0, e, 0)),
                    field_(p + vec3(0, 0, e)) - field_(p - vec3(0, 0, e))) /
               (2.0f * e);
    }

    /// The mean of the cube's edge crossings, then twice a step down the gradient, never out of the cube.
    void addVertex(MeshWriter& writer, glm::ivec3 cube) {
        vec3 sum(0.0f);
        int crossings = 0;
        for (int edge = 0; edge < 12; ++edge) {
            const int axis = edge / 4, b = (axis + 1) % 3, c = (axis + 2) % 3;
            glm::ivec3 from = cube;
            from[b] += edge & 1, from[c] += (edge >> 1) & 1;
            glm::ivec3 to = from;
            to[axis] += 1;
            const float v0 = values_[index(from)], v1 = values_[index(to)];
            if ((v0 < 0.0f) == (v1 < 0.0f)) continue;
            sum += glm::mix(corner(from), corner(to), v0 / (v0 - v1));
            ++crossings;
        }
        if (crossings == 0) return;
        vec3 p = sum / float(crossings);
        for (int step = 0; step < 2; ++step) {
            const vec3 g = gradient(p);
            p -= g * (field_(p) / std::max(glm::dot(g, g), 1e-6f));
            p = glm::clamp(p, corner(cube), corner(cube + 1));
        }
        vertices_[index(cube)] = writer.vertex(p, gradient(p), {p.x, p.y});
    }

    /// The face across the grid edge that starts at `c`, between the four cubes around it.
    void addQuad(MeshWriter& writer, glm::ivec3 c, int axis) {
        glm::ivec3 end = c, b(0), d(0);
        end[axis] += 1;
        const bool inside = values_[index(c)] < 0.0f;
        if (inside == (values_[index(end)] < 0.0f)) return;
        b[(axis + 1) % 3] = 1, d[(axis + 2) % 3] = 1;
        const uint32_t v0 = vertices_[index(c - b - d)], v1 = vertices_[index(c - d)], v2 = vertices_[index(c)],
                       v3 = vertices_[index(c - b)];
        if (inside) writer.quad(v0, v1, v2, v3);
        else writer.quad(v0, v3, v2, v1);
    }

    vec3 low_;
    float cell_;
    const DistanceField& field_;
    glm::ivec3 size_{0};
    std::vector<float> values_;
    std::vector<uint32_t> vertices_;
};

}  // namespace

void addBlob(MeshWriter& writer, vec3 low, vec3 high, float cell, const DistanceField& field) {
    Net(low, high, cell, field).write(writer);
}

}  // namespace heliograph::generate
