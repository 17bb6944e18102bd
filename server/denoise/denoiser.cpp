#include "server/denoise/denoiser.h"

#include "server/denoise/denoise_kernel.h"
#include "server/kernel/instruction_set.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <mutex>

namespace heliograph {

namespace lanes_v2 {
extern const DenoiseProgram DENOISE_PROGRAM;
}
namespace lanes_v3 {
extern const DenoiseProgram DENOISE_PROGRAM;
}
namespace lanes_v4 {
extern const DenoiseProgram DENOISE_PROGRAM;
}

namespace {

constexpr uint32_t BAND = 16;  // rows of a task

template <typename Work>
void forBands(uint32_t rows, const Work& work) {
    tbb::parallel_for(0u, (rows + BAND - 1) / BAND, [&](uint32_t band) {
        for (uint32_t y = band * BAND; y < std::min(rows, (band + 1) * BAND); y++) work(y);
    });
}

}  // namespace

void DenoiseJob::take(const Film& film, const Film& guideFilm, float white) {
    size = film.resolution();
    deviceSeconds = 0.0;
    aboveWhite_.clear();
    std::mutex mutex;  // of what is above white: few pixels
    light.resize(static_cast<size_t>(size.x) * size.y);
    guides.resize(light.size());
    const double edges = film.completedSamples() < 2 ? 0.0 : film.edgeShare();
    forBands(size.y, [&](uint32_t y) {
        const size_t first = static_cast<size_t>(y) * size.x;
        film.developWithVariance(y, y + 1, edges, &light[first]);
        for (size_t i = first; i < first + size.x; i++) {
            const vec3 above = glm::max(vec3(light[i]) - white, vec3(0.0f));
            if (above == vec3(0.0f)) continue;
            light[i] -= vec4(above, 0.0f);
            light[i].w = std::min(light[i].w, white * white);
            std::lock_guard lock(mutex);
            aboveWhite_.emplace_back(i, above);
        }
        guideFilm.develop(y, y + 1, &guides[first]);
    });
}

void DenoiseJob::giveBack() {
    for (const auto& [pixel, above] : aboveWhite_) light[pixel] += vec4(above, 0.0f);
}

FrameRequest guideRequest(const FrameRequest& picture, uint32_t generation) {
    FrameRequest request = picture;
    request.effects.bits = (picture.effects.bits & GUIDE_EFFECTS) | EFFECT_GUIDES;
    request.generation = generation;
    request.previousCamera.reset();
    return request;
}

bool canDenoise(const FrameRequest& picture) { return !picture.effects.has(EFFECT_DEPTH_OF_FIELD | EFFECT_MOTION_BLUR); }

const DenoiseProgram& denoiseProgram() {
    static const DenoiseProgram& program =
        ofInstructionSet(lanes_v2::DENOISE_PROGRAM, lanes_v3::DENOISE_PROGRAM, lanes_v4::DENOISE_PROGRAM);
    return program;
}

void ProcessorDenoiser::run(DenoiseJob& job) {
    if (job.size.x == 0 || job.size.y == 0) return;
    const DenoiseView view = fit(job.size);
    load(view, job);
    const DenoiseProgram& program = *program_;
    const uint32_t rows = job.size.y;
    forBands(rows, [&](uint32_t y) { program.estimateRow(view, y); });
    for (uint32_t round = 0; round < scalar_kernel::DenoiseKernel::DENOISE_ROUNDS; round++)
        forBands(rows, [&](uint32_t y) { program.filterRow(view, y, round); });
    store(view, job);
}

/// The planes for pictures of this size, with what lies around the picture.
DenoiseView ProcessorDenoiser::fit(uvec2 size) {
    DenoiseView view;
    view.size = size;
    view.stride = size.x + 3 * DENOISE_MARGIN;
    const size_t floats = view.stride * (size.y + 2 * DENOISE_MARGIN);
    const bool fresh = size != size_;
    if (fresh) {
        size_ = uvec2(0);
        memory_.assign(floats * DENOISE_PLANES + DENOISE_MARGIN, 0.0f);
        size_ = size;
    }
    for (uint32_t i = 0; i < DENOISE_PLANES; i++) {
        float* plane = memory_.data() + floats * i;
        if (fresh && i == static_cast<uint32_t>(DenoisePlane::nearness)) std::fill_n(plane, floats, -1.0f);
        view.planes[i] = plane + view.stride * DENOISE_MARGIN + DENOISE_MARGIN;
    }
    return view;
}

void ProcessorDenoiser::load(const DenoiseView& view, const DenoiseJob& job) {
    const auto plane = [&](DenoisePlane which, uint32_t y) {
        return view.planes[static_cast<uint32_t>(which)] + y * view.stride;
    };
    using enum DenoisePlane;
    forBands(view.size.y, [&](uint32_t y) {
        const vec4* light = &job.light[static_cast<size_t>(y) * view.size.x];
        const vec4* guides = &job.guides[static_cast<size_t>(y) * view.size.x];
        float *red = plane(redA, y), *green = plane(greenA, y), *blue = plane(blueA, y), *variance = plane(varianceA, y);
        float *albedo = plane(albedoWord, y), *normal = plane(normalWord, y), *near = plane(nearness, y);
        for (uint32_t x = 0; x < view.size.x; x++) {
            red[x] = light[x].x, green[x] = light[x].y, blue[x] = light[x].z, variance[x] = light[x].w;
            albedo[x] = guides[x].x, normal[x] = guides[x].y, near[x] = guides[x].z;
        }
        program_->prepareRow(view, y);
    });
}

void ProcessorDenoiser::store(const DenoiseView& view, DenoiseJob& job) const {
    const auto plane = [&](DenoisePlane which, uint32_t y) {
        return view.planes[static_cast<uint32_t>(which)] + y * view.stride;
    };
    using enum DenoisePlane;
    forBands(view.size.y, [&](uint32_t y) {
        program_->finishRow(view, y);
        vec4* light = &job.light[static_cast<size_t>(y) * view.size.x];
        const float *red = plane(redA, y), *green = plane(greenA, y), *blue = plane(blueA, y);
        for (uint32_t x = 0; x < view.size.x; x++) light[x] = vec4(red[x], green[x], blue[x], 0.0f);
    });
}

}  // namespace heliograph
