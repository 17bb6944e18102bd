#include "server/lab/accuracy/frame_maker.h"

#include "server/lab/accuracy/reference.h"
#include "server/lab/effect_bench.h"

namespace heliograph {

bool RendererFrames::timedByCore(const Settings& settings) const { return heliograph::timedByCore(renderer_, settings); }

std::vector<glm::dvec3> RendererFrames::samples(const FrameRequest& request, uint32_t first, uint32_t count) {
    return renderSamples(renderer_, request, first, count);
}

}  // namespace heliograph
