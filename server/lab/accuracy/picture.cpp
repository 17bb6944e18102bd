#include "server/lab/accuracy/picture.h"

#include <algorithm>
#include <cmath>

namespace heliograph {

namespace {

/// The two neighbours of a place, and the second one's weight.
struct Between {
    uint32_t first = 0, second = 0;
    float weight = 0.0f;
};

Between between(uint32_t at, uint32_t to, uint32_t from) {
    const double place = (at + 0.5) * from / to - 0.5;
    const double below = std::floor(place);
    auto inside = [&](double i) { return static_cast<uint32_t>(std::clamp(i, 0.0, from - 1.0)); };
    return {inside(below), inside(below + 1.0), static_cast<float>(place - below)};
}

/// `at(x, y)` gives the source's pixel, `put(x, y, value)` takes the result's.
template <typename At, typename Put>
void stretch(uvec2 from, uvec2 to, At at, Put put) {
    for (uint32_t y = 0; y < to.y; y++) {
        const Between row = between(y, to.y, from.y);
        for (uint32_t x = 0; x < to.x; x++) {
            const Between column = between(x, to.x, from.x);
            const vec4 top = glm::mix(at(column.first, row.first), at(column.second, row.first), column.weight);
            const vec4 bottom = glm::mix(at(column.first, row.second), at(column.second, row.second), column.weight);
            put(x, y, glm::mix(top, bottom, row.weight));
        }
    }
}

}  // namespace

LinearPicture resized(const LinearPicture& picture, uvec2 size) {
    if (picture.resolution == size) return picture;
    LinearPicture result{size, std::vector<vec4>(static_cast<size_t>(size.x) * size.y)};
    stretch(
        picture.resolution, size,
        [&](uint32_t x, uint32_t y) { return picture.pixels[static_cast<size_t>(y) * picture.resolution.x + x]; },
        [&](uint32_t x, uint32_t y, vec4 value) { result.pixels[static_cast<size_t>(y) * size.x + x] = value; });
    return result;
}

LinearPicture limited(LinearPicture picture, float ceiling) {
    for (vec4& pixel : picture.pixels) pixel = glm::min(pixel, vec4(ceiling));
    return picture;
}

DisplayImage resized(const DisplayImage& image, uvec2 size) {
    if (uvec2(image.width, image.height) == size) return image;
    DisplayImage result{size.x, size.y, std::vector<uint8_t>(4ull * size.x * size.y)};
    stretch(
        uvec2(image.width, image.height), size,
        [&](uint32_t x, uint32_t y) {
            const uint8_t* code = &image.rgba[4 * (static_cast<size_t>(y) * image.width + x)];
            return vec4(code[0], code[1], code[2], code[3]);
        },
        [&](uint32_t x, uint32_t y, vec4 value) {
            uint8_t* code = &result.rgba[4 * (static_cast<size_t>(y) * size.x + x)];
            for (int i = 0; i < 4; i++) code[i] = static_cast<uint8_t>(std::lround(value[i]));
        });
    return result;
}

}  // namespace heliograph
