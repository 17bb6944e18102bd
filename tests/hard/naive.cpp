// The baseline: what a first ray tracer does, all in float. Rays against triangles after Moeller & Trumbore, "Fast, Minimum
// Storage Ray/Triangle Intersection" (1997), with the paper's epsilon for the determinant and a fixed one of 0.01 for t; a slab
// test with divisions and without padding.

#include "server/device/vulkan/tree/bvh_builder.h"
#include "tests/hard/tracer.h"

#include <bit>

namespace heliograph::hard {

namespace {

constexpr float DETERMINANT_EPSILON = 1e-6f;
constexpr float DISTANCE_EPSILON = 0.01f;

float distanceTo(const Ray& ray, vec3 a, vec3 b, vec3 c) {
    const vec3 e1 = b - a, e2 = c - a, p = glm::cross(ray.direction, e2);
    const float determinant = glm::dot(e1, p);
    if (std::fabs(determinant) < DETERMINANT_EPSILON) return -1.0f;
    const float inverse = 1.0f / determinant;
    const vec3 s = ray.origin - a;
    const float u = glm::dot(s, p) * inverse;
    if (u < 0.0f || u > 1.0f) return -1.0f;
    const vec3 q = glm::cross(s, e1);
    const float v = glm::dot(ray.direction, q) * inverse;
    if (v < 0.0f || u + v > 1.0f) return -1.0f;
    return glm::dot(e2, q) * inverse;
}

class NaiveTracer : public Tracer {
public:
    explicit NaiveTracer(const World& world) : scene_(plainScene(world.mesh())), bvh_(buildBvh(*scene_, {2, 3, 1})) { fit(0u); }
    const char* column() const override { return column::NAIVE; }

    void trace(std::span<const Ray> rays, std::vector<Met>& met) override {
        met.assign(rays.size(), {});
        inBlocks(rays.size(), [&](size_t begin, size_t end) {
            for (size_t i = begin; i < end; i++) {
                float nearest = rays[i].tMax;
                walk(rays[i], nearest, [&](uint32_t triangle, float t) {
                    nearest = t;
                    met[i] = {triangle, t};
                });
            }
        });
    }

    bool traceAll(std::span<const Ray> rays, std::vector<std::vector<Met>>& met) override {
        met.assign(rays.size(), {});
        inBlocks(rays.size(), [&](size_t begin, size_t end) {
            for (size_t i = begin; i < end; i++) {
                float limit = rays[i].tMax;
                walk(rays[i], limit, [&](uint32_t triangle, float t) { met[i].push_back({triangle, t}); });
            }
        });
        return true;
    }

    Ray leave(const Ray& ray, const Met& met, vec3 direction) const override { return makeRay(point(ray, met), direction); }
    vec3 point(const Ray& ray, const Met& met) const override { return ray.origin + ray.direction * met.t; }

private:
    /// The tree alone is taken from here; every triangle stays what it is.
    static std::shared_ptr<const Scene> plainScene(const MeshData& mesh) {
        auto scene = std::make_shared<Scene>();
        for (vec3 p : mesh.positions) scene->positions.emplace_back(p, 0.0f);
        scene->positions.emplace_back(0.0f);
        for (uvec3 t : mesh.indices) scene->triangles.emplace_back(t, 0u);
        Mesh all{};
        all.triangleCount = static_cast<uint32_t>(mesh.indices.size());
        all.vertexCount = static_cast<uint32_t>(mesh.positions.size());
        scene->meshes.push_back(all);
        Instance here{};
        here.toWorld0 = here.toObject0 = vec4(1, 0, 0, 0);
        here.toWorld1 = here.toObject1 = vec4(0, 1, 0, 0);
        here.toWorld2 = here.toObject2 = vec4(0, 0, 1, 0);
        here.flags = INSTANCE_IDENTITY;
        scene->instances.push_back(here);
        for (vec3 p : mesh.positions) scene->bounds.grow(p);
        return scene;
    }

    /// Makes boxes what they hold and no more: the product's have room for its own rounding.
    Bounds fit(uint32_t ref) {
        Bounds all;
        if (ref >= REF_TRIANGLES) {
            const uvec4* words = bvh_.triangles.data.get() + size_t(ref & 0x07ffffffu) * WORDS16_PER_TRIANGLE;
            for (uint32_t i = 0; i < ((ref >> 27) & 7u) * 3u; i++)
                all.grow({real(words[i].x), real(words[i].y), real(words[i].z)});
            return all;
        }
        uvec4* node = bvh_.nodes.data.get() + size_t(ref) * WORDS16_PER_NODE;
        for (int child = 0; child < 2; child++) {
            const Bounds box = fit(child == 0 ? node[3].x : node[3].y);
            const auto bits = [](float x) { return std::bit_cast<uint32_t>(x); };
            node[child] = {bits(box.low.x), bits(box.high.x), bits(box.low.y), bits(box.high.y)};
            (child == 0 ? node[2].x : node[2].z) = bits(box.low.z);
            (child == 0 ? node[2].y : node[2].w) = bits(box.high.z);
            if (!box.empty()) all.grow(box.low), all.grow(box.high);
        }
        return all;
    }

    static float real(uint32_t bits) { return std::bit_cast<float>(bits); }

    static bool entersBox(const Ray& ray, vec3 low, vec3 high, float nearest) {
        float enter = 0.0f, leave = nearest;
        for (int axis = 0; axis < 3; axis++) {
            const float a = (low[axis] - ray.origin[axis]) / ray.direction[axis];
            const float b = (high[axis] - ray.origin[axis]) / ray.direction[axis];
            enter = std::max(enter, std::min(a, b));
            leave = std::min(leave, std::max(a, b));
        }
        return enter <= leave;
    }

    template <typename Found>
    void walk(const Ray& ray, float& nearest, Found found) const {
        std::vector<uint32_t> stack{0u};
        while (!stack.empty()) {
            const uint32_t ref = stack.back();
            stack.pop_back();
            if (ref >= REF_TRIANGLES) {
                leaf(ref, ray, nearest, found);
                continue;
            }
            const uvec4* node = bvh_.nodes.data.get() + size_t(ref) * WORDS16_PER_NODE;
            for (int child = 0; child < 2; child++) {
                const uvec4 xy = node[child];
                const vec3 low(real(xy.x), real(xy.z), real(child == 0 ? node[2].x : node[2].z));
                const vec3 high(real(xy.y), real(xy.w), real(child == 0 ? node[2].y : node[2].w));
                if (entersBox(ray, low, high, nearest)) stack.push_back(child == 0 ? node[3].x : node[3].y);
            }
        }
    }

    template <typename Found>
    void leaf(uint32_t ref, const Ray& ray, const float& nearest, Found& found) const {
        const uint32_t first = ref & 0x07ffffffu, count = (ref >> 27) & 7u;
        for (uint32_t i = first; i < first + count; i++) {
            const uvec4* words = bvh_.triangles.data.get() + size_t(i) * WORDS16_PER_TRIANGLE;
            const auto corner = [&](int k) { return vec3(real(words[k].x), real(words[k].y), real(words[k].z)); };
            const float t = distanceTo(ray, corner(0), corner(1), corner(2));
            if (t > DISTANCE_EPSILON && t < nearest) found(words[0].w, t);
        }
    }

    std::shared_ptr<const Scene> scene_;
    Bvh bvh_;
};

}  // namespace

std::unique_ptr<Tracer> naiveTracer(const World& world) { return std::make_unique<NaiveTracer>(world); }

}  // namespace heliograph::hard
