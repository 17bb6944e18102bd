#pragma once
// A picture with less grain, for some sharpness: what few samples cannot tell is taken from neighbours that look at the same surface.
// One more approximation, with a price and an error (docs/reference/accuracy.md); what it does is stated in
// shaders/denoise/filter.glsl.

#include "server/denoise/filter_program.h"
#include "server/film/film.h"
#include "server/request/frame_request.h"

#include <vector>

namespace heliograph {

/// What is filtered, row-major.
struct DenoiseJob {
    uvec2 size{0, 0};
    std::vector<vec4>
        light;  // linear radiance RGB, variance of its luminance in w or -1; filtered in place, w then means nothing
    std::vector<vec4> guides;    // as a film has them, that was rendered with `guideRequest`
    double deviceSeconds = 0.0;  // that a device's own clock told of the filter alone; 0: none did

    /// `guides` has the film's size. What is brighter than `white` in a channel is filtered as that, and keeps the rest for itself
    /// (`giveBack`): the few pixels that mirror a lamp without extent, 10,000 times as bright, would be spots of 30 pixels. Throws
    /// std::bad_alloc.
    void take(const Film& film, const Film& guides, float white);
    /// Adds to the filtered light what was above white.
    void giveBack();

private:
    std::vector<std::pair<size_t, vec3>> aboveWhite_;  // pixels
};

/// The request for the guides of a picture: one sample of it is enough. `generation`: of the film that it is for.
FrameRequest guideRequest(const FrameRequest& picture, uint32_t generation);

/// Whether the filter is of use for such pictures: not where the lens or motion blurs them, whose surfaces no guide tells apart.
bool canDenoise(const FrameRequest& picture);

/// The compilation that this process runs.
const DenoiseProgram& denoiseProgram();

/// The filter on this machine's processors. Keeps its memory, 64 bytes a pixel, from one picture to the next.
class ProcessorDenoiser {
public:
    /// `program`: another compilation, for tests.
    explicit ProcessorDenoiser(const DenoiseProgram& program = denoiseProgram()) : program_(&program) {}
    /// Rows side by side on the processor's cores. Throws std::bad_alloc.
    void run(DenoiseJob& job);
    /// Memory that it holds.
    size_t bytes() const { return memory_.capacity() * sizeof(float); }

private:
    DenoiseView fit(uvec2 size);
    void load(const DenoiseView& view, const DenoiseJob& job);
    void store(const DenoiseView& view, DenoiseJob& job) const;

    const DenoiseProgram* program_;
    std::vector<float> memory_;
    uvec2 size_{0, 0};
};

}  // namespace heliograph
