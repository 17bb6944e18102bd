#include "server/scene/kernel_tables.h"
#include "tests/hard/tracer.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cstdio>
#include <sstream>
#include <stdexcept>

namespace heliograph::hard {

World::World(MeshData mesh) : mesh_(std::move(mesh)) {
    SceneBuilder builder("hard");
    builder.addInstance(builder.addMesh(mesh_), mat4(1.0f));
    take(builder);
}

World::World(ShapeForm form, const mat4& toWorld) {
    SceneBuilder builder("hard");
    builder.addInstance(builder.addShape(form, 0), toWorld);
    take(builder);
}

void World::take(SceneBuilder& builder) {
    scene_ = builder.finish();
    if (scene_->instances.size() > 1 || (!taken() && scene_->warnings.empty())) throw std::logic_error("a world is one mesh");
    kernel_ = test::bareKernel();
    kernel_.scene = sceneView(*scene_);
    kernel_.frame.effects = EFFECT_INSTANCING;  // a mesh without textures, colours or tangents
    kernel_.frame.layers = EFFECT_SHAPES >> 32;
}

test::EveryKernel::Surface World::surface(const Ray& ray, const Met& met) const {
    Hit hit;
    hit.instance = 0;
    hit.primitive = met.triangle;
    return kernel_.surfaceAt(ray.origin, ray.direction, 0.0f, 0.0f, hit);
}

Ray leaveByKernel(const World& world, const Ray& ray, const Met& met, vec3 direction) {
    const auto s = world.surface(ray, met);
    const vec3 side = glm::dot(direction, s.geometricNormal) >= 0.0f ? s.geometricNormal : -s.geometricNormal;
    return makeRay(world.kernel().offsetRayOrigin(s.position, side, s.clearance), direction);
}

std::string replayOf(const std::string& name, const Ray& ray) {
    char text[256];
    std::snprintf(text, sizeof text, "hard_cases --case %s --ray '%a %a %a %a %a %a'", name.c_str(), double(ray.origin.x),
                  double(ray.origin.y), double(ray.origin.z), double(ray.direction.x), double(ray.direction.y),
                  double(ray.direction.z));
    return text;
}

namespace {

Ray rayFrom(const std::string& text) {
    std::istringstream words(text);
    float values[6];
    for (float& value : values) {
        std::string word;
        words >> word;
        char* end = nullptr;
        value = std::strtof(word.c_str(), &end);
        if (word.empty() || *end) throw std::invalid_argument("--ray takes six numbers, origin and direction");
    }
    return makeRay({values[0], values[1], values[2]}, {values[3], values[4], values[5]});
}

void printAnswers(const std::vector<std::unique_ptr<Tracer>>& tracers, const Ray& ray) {
    for (const auto& tracer : tracers) {
        std::vector<Met> met;
        tracer->trace(std::span(&ray, 1), met);
        if (met[0].hit()) std::printf("    %-14s triangle %u at %.9g\n", tracer->column(), met[0].triangle, double(met[0].t));
        else std::printf("    %-14s nothing\n", tracer->column());
    }
}

}  // namespace

std::vector<std::unique_ptr<Tracer>> tracersOf(const World& world, const Run& run) {
    std::vector<std::unique_ptr<Tracer>> all;
    all.push_back(naiveTracer(world));
    all.push_back(bareEmbree(world, false));
    all.push_back(bareEmbree(world, true));
    if (!world.taken()) return all;
    for (auto& tracer : ownTracersOf(world, run)) all.push_back(std::move(tracer));
    if (!run.plan().ray.empty()) printAnswers(all, rayFrom(run.plan().ray));
    return all;
}

std::vector<std::unique_ptr<Tracer>> ownTracersOf(const World& world, const Run& run) {
    std::vector<std::unique_ptr<Tracer>> all;
    all.push_back(ownTracer(world, 2));
    all.push_back(ownTracer(world, 4));
    all.push_back(embreePackets(world));
    if (auto vulkan = vulkanRays(world, run.plan().device)) all.push_back(std::move(vulkan));
    return all;
}

void inBlocks(size_t count, const std::function<void(size_t, size_t)>& work) {
    tbb::parallel_for(tbb::blocked_range<size_t>(0, count, 1024), [&](const auto& part) { work(part.begin(), part.end()); });
}

}  // namespace heliograph::hard
