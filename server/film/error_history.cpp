#include "server/film/error_history.h"

namespace heliograph {

void ErrorHistory::reached(size_t block, uint32_t samples, const Means& means) {
    Block& b = blocks_[block];
    if (samples != 2 * b.samples()) return begin(block, samples, means);
    float moved = 0.0f;
    for (size_t i = 0; i < means.size(); i++) moved += (means[i] - b.means[i]) * (means[i] - b.means[i]);
    b.moved[++b.doublings % KEPT] = moved;
    b.means = means;
}

}  // namespace heliograph
