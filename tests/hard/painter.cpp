#include "tests/hard/painter.h"

#include "server/device/vulkan/trace/vulkan_device.h"

namespace heliograph::hard {

std::vector<Painter> painters(const Run& run) {
    std::vector<Painter> all = {{column::EMBREE, &test::cpu()}};
    const std::string& name = run.plan().device;
    if (name.empty()) return all;
    static const std::unique_ptr<Device> vulkan = makeVulkanDevice(name.substr(name.find(':') + 1));
    all.push_back({column::VULKAN, vulkan.get()});
    return all;
}

test::Picture draw(const Painter& painter, const std::shared_ptr<const Scene>& scene, const Camera& camera, Settings settings,
                   uint32_t samples, uvec2 size) {
    settings.robust = true;
    settings.contributionThreshold = 0.0f;
    painter.device->load(scene, settings, {});
    Film film;
    test::Picture picture;
    picture.size = size;
    picture.stats = renderFrame(*painter.device, frameRequest(*scene, camera, settings, size, 1), samples, film);
    film.develop(picture.pixels);
    return picture;
}

void countBad(Run& run, const Painter& painter, const test::Picture& picture) {
    uint64_t bad = 0;
    for (vec4 p : picture.pixels) bad += !(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
    run.rate(painter.column, "not finite", picture.stats.nonfiniteSamples + bad, picture.pixels.size(), 0.0);
}

uint64_t differing(const test::Picture& a, const test::Picture& b, double share) {
    uint64_t count = 0;
    for (size_t i = 0; i < a.pixels.size(); i++) {
        bool off = false;
        for (int c = 0; c < 3; c++) {
            const double x = a.pixels[i][c], y = b.pixels[i][c];
            off = off || !(std::fabs(x - y) <= share * std::max(std::fabs(x), std::fabs(y)));
        }
        count += off;
    }
    return count;
}

double meanOf(const test::Picture& picture) {
    double sum = 0.0;
    for (vec4 p : picture.pixels) sum += p.x;
    return sum / static_cast<double>(picture.pixels.size());
}

}  // namespace heliograph::hard
