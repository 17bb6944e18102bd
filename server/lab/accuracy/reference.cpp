#include "server/lab/accuracy/reference.h"

#include "server/film/film.h"

#include <cstring>
#include <mutex>

namespace heliograph {

namespace {

// Any but 1, which pictures have. Beginnings are multiples of large powers of two, where the sequence's points are spread as
// evenly as from 0, far behind any picture's samples.
constexpr std::array<uint32_t, 2> SEEDS = {0x9e3779b9u, 0x3c6ef373u};
constexpr std::array<uint32_t, 2> BEGINNINGS = {1u << 24, 1u << 25};

}  // namespace

Reference::Reference(const FrameRequest& request) : request_(request) {
    for (auto& sums : sums_) sums.assign(static_cast<size_t>(request.resolution.x) * request.resolution.y, glm::dvec3(0.0));
}

std::vector<glm::dvec3> renderSamples(Renderer& renderer, const FrameRequest& request, uint32_t first, uint32_t count) {
    const uvec2 resolution = request.resolution, cell = glm::min(tileSize(request.settings), resolution);
    std::vector<glm::dvec3> all(static_cast<size_t>(resolution.x) * resolution.y);
    Film grid;  // cuts the picture into tiles
    grid.reset(resolution, request.generation);
    std::mutex mutex;
    auto sink = [&](TileResult&& result) {
        std::lock_guard lock(mutex);
        const std::span<const vec4> sums = result.sums();
        const uvec2 origin = result.tile.origin, size = result.tile.size;
        for (uint32_t y = 0; y < size.y; y++) {
            for (uint32_t x = 0; x < size.x; x++) {
                const vec4 sum = sums[static_cast<size_t>(y) * size.x + x];
                all[static_cast<size_t>(origin.y + y) * resolution.x + origin.x + x] = glm::dvec3(sum.x, sum.y, sum.z);
            }
        }
    };
    ViewMemory view;
    view.costs.begin(resolution, cell);
    renderer.render(request, grid.tilesFor(first, count, cell), view, sink, {});
    return all;
}

void Reference::addRun(FrameMaker& frames) {
    const size_t which = runs_[1] < runs_[0] ? 1 : 0;
    request_.seed = SEEDS[which];
    request_.generation++;
    const double begin = frames.seconds();
    const std::vector<glm::dvec3> more = frames.samples(request_, BEGINNINGS[which] + RUN * runs_[which], RUN);
    seconds_ += frames.seconds() - begin;
    for (size_t i = 0; i < more.size(); i++) sums_[which][i] += more[i];
    runs_[which]++;
}

LinearPicture Reference::half(size_t which) const {
    LinearPicture picture{request_.resolution, std::vector<vec4>(sums_[which].size())};
    const double scale = runs_[which] > 0 ? 1.0 / (static_cast<double>(RUN) * runs_[which]) : 0.0;
    for (size_t i = 0; i < picture.pixels.size(); i++) picture.pixels[i] = vec4(vec3(sums_[which][i] * scale), 0.0f);
    return picture;
}

LinearPicture Reference::picture() const { return meanOf(half(0), half(1)); }

double Reference::ownError(float ceiling) const { return errorOfMean(limited(half(0), ceiling), limited(half(1), ceiling)); }

std::vector<uint8_t> Reference::bytes() const {
    std::vector<uint8_t> bytes(sizeof runs_ + sizeof seconds_ + 2 * sums_[0].size() * sizeof(glm::dvec3));
    uint8_t* to = bytes.data();
    auto put = [&](const void* from, size_t size) {
        std::memcpy(to, from, size);
        to += size;
    };
    put(runs_.data(), sizeof runs_);
    put(&seconds_, sizeof seconds_);
    for (const auto& sums : sums_) put(sums.data(), sums.size() * sizeof(glm::dvec3));
    return bytes;
}

bool Reference::restore(std::span<const uint8_t> bytes) {
    const size_t each = sums_[0].size() * sizeof(glm::dvec3);
    if (bytes.size() != sizeof runs_ + sizeof seconds_ + 2 * each) return false;
    const uint8_t* from = bytes.data();
    auto take = [&](void* to, size_t size) {
        std::memcpy(to, from, size);
        from += size;
    };
    take(runs_.data(), sizeof runs_);
    take(&seconds_, sizeof seconds_);
    for (auto& sums : sums_) take(sums.data(), each);
    return true;
}

}  // namespace heliograph
