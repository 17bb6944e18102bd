#pragma once
// Pictures of the catalogue: the devices that draw them.

#include "tests/hard/catalogue.h"
#include "tests/image/picture.h"

namespace heliograph::hard {

struct Painter {
    const char* column;
    Device* device;
};

/// The Embree device and, if one was asked for, the Vulkan device.
std::vector<Painter> painters(const Run& run);

/// Draws on that device; Embree traces `robust`. Whatever the settings say, no contribution is left out for being small.
test::Picture draw(const Painter& painter, const std::shared_ptr<const Scene>& scene, const Camera& camera,
                   Settings settings = {}, uint32_t samples = 1, uvec2 size = uvec2(97, 97));

/// Non-finite samples and pixels of a picture, which may be none.
void countBad(Run& run, const Painter& painter, const test::Picture& picture);

/// Share of pixels whose colours differ by more than `share` of the larger.
uint64_t differing(const test::Picture& a, const test::Picture& b, double share);

/// Mean of the red channel.
double meanOf(const test::Picture& picture);

}  // namespace heliograph::hard
