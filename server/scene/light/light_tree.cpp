#include "server/scene/light/light_tree.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <span>

namespace heliograph {

namespace {

constexpr size_t BINS = 16;
constexpr uint32_t MEDIAN_FROM = 6;   // levels; from there on parts are halved by number, so that no tree is deep
constexpr uint32_t MOST_LEVELS = 16;  // of a tree of lights
constexpr uint32_t LIGHT_WORDS = sizeof(Light) / 4;
constexpr double WEAKEST = 1e-30;  // of all intensity: no less, so that its root stays a float

using Lights = std::span<TreeLight>;

LightBounds boundsOf(Lights lights) {
    LightBounds all = lights.front().bounds;
    for (const TreeLight& light : lights.subspan(1)) all.add(light.bounds);
    return all;
}

/// Where a split costs least, along one axis: cost of both sides, and the place.
struct Split {
    double cost = std::numeric_limits<double>::infinity();
    int axis = 0;
    double place = 0.0;
};

/// The lights in bins of equal width along an axis; the cost of a side is its bounds' (LightBounds::cost).
void findSplit(Lights lights, int axis, double low, double high, Split& best) {
    std::array<LightBounds, BINS> bins;
    std::array<bool, BINS> filled{};
    const double width = (high - low) / double(BINS);
    for (const TreeLight& light : lights) {
        const size_t bin = std::min(static_cast<size_t>((light.bounds.middle()[axis] - low) / width), BINS - 1);
        if (filled[bin]) bins[bin].add(light.bounds);
        else bins[bin] = light.bounds;
        filled[bin] = true;
    }
    for (size_t cut = 1; cut < BINS; cut++) {
        double cost = 0.0;
        bool both = true;
        for (const auto& [from, to] : {std::pair(size_t(0), cut), std::pair(cut, BINS)}) {
            LightBounds side;
            bool any = false;
            for (size_t i = from; i < to; i++) {
                if (!filled[i]) continue;
                if (any) side.add(bins[i]);
                else side = bins[i];
                any = true;
            }
            both &= any;
            if (any) cost += side.cost();
        }
        if (both && cost < best.cost) best = {cost, axis, low + width * double(cut)};
    }
}

/// Parts `lights` in two, both with some; returns how many are in the first.
size_t splitInTwo(Lights lights, bool bySpace) {
    dvec3 low(std::numeric_limits<double>::infinity()), high = -low;
    for (const TreeLight& light : lights) {
        low = glm::min(low, light.bounds.middle());
        high = glm::max(high, light.bounds.middle());
    }
    const dvec3 size = high - low;
    const int longest = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    Split best;
    for (int axis = 0; axis < 3 && bySpace; axis++)
        if (size[axis] > 0.0) findSplit(lights, axis, low[axis], high[axis], best);
    if (std::isfinite(best.cost)) {
        const auto first = std::partition(lights.begin(), lights.end(), [&](const TreeLight& light) {
            return light.bounds.middle()[best.axis] < best.place;
        });
        const auto count = static_cast<size_t>(first - lights.begin());
        if (count > 0 && count < lights.size()) return count;
    }
    const auto middle = lights.begin() + static_cast<ptrdiff_t>(lights.size() / 2);
    std::nth_element(lights.begin(), middle, lights.end(), [&](const TreeLight& a, const TreeLight& b) {
        const double x = a.bounds.middle()[longest], y = b.bounds.middle()[longest];
        return x != y ? x < y : a.index < b.index;
    });
    return lights.size() / 2;
}

class TreeWriter {
public:
    TreeWriter(std::vector<uint32_t>& words, LightWords light, double intensity, uint32_t medianFrom, size_t lights)
        : words_(words), light_(light), intensity_(intensity), medianFrom_(medianFrom), trails_(lights) {}

    /// Appends a node of these lights and all below it; returns its first word. `trail`: the parts that led to it.
    uint32_t write(Lights lights, uint32_t level, uint32_t trail) {
        levels_ = std::max(levels_, level + 1);
        const std::vector<Lights> parts = partsOf(lights, level < medianFrom_);
        const auto node = static_cast<uint32_t>(words_.size());
        words_.resize(words_.size() + size_t(LIGHT_TREE_WIDTH) * LIGHT_TREE_WORDS, 0u);
        for (size_t i = 0; i < LIGHT_TREE_WIDTH; i++) {
            const size_t at = node + i * LIGHT_TREE_WORDS;
            if (i >= parts.size()) {
                words_[at + 11] = LIGHT_TREE_LEAF | light_.first;  // never chosen
                continue;
            }
            putBounds(at, boundsOf(parts[i]));
            const uint32_t shift = level * LAMP_TRAIL_BITS;
            const uint32_t way = shift < 32 ? trail | static_cast<uint32_t>(i) << shift : trail;
            const uint32_t next = parts[i].size() == 1 ? leaf(parts[i][0].index, way) : write(parts[i], level + 1, way);
            words_[at + 11] = next;
        }
        return node;
    }

    uint32_t levels() const { return levels_; }
    std::vector<uint32_t> takeTrails() { return std::move(trails_); }

private:
    uint32_t leaf(uint32_t index, uint32_t trail) {
        trails_[index] = trail;
        return LIGHT_TREE_LEAF | (light_.first + index * light_.count);
    }

    /// Up to LIGHT_TREE_WIDTH parts in the order of space: the one that costs most, or by number the one of most lights, is split
    /// until there are so many.
    static std::vector<Lights> partsOf(Lights lights, bool bySpace) {
        std::vector<Lights> parts{lights};
        std::vector<double> costs{0.0};
        while (parts.size() < LIGHT_TREE_WIDTH) {
            ptrdiff_t dearest = -1;
            for (size_t i = 0; i < parts.size(); i++) {
                if (parts[i].size() < 2) continue;
                if (!bySpace) costs[i] = double(parts[i].size());
                const bool dearer = dearest < 0 || costs[i] > costs[size_t(dearest)] ||
                                    (costs[i] == costs[size_t(dearest)] && parts[i].size() > parts[size_t(dearest)].size());
                if (dearer) dearest = static_cast<ptrdiff_t>(i);
            }
            if (dearest < 0) break;
            const Lights whole = parts[size_t(dearest)];
            const size_t first = splitInTwo(whole, bySpace);
            parts[size_t(dearest)] = whole.first(first);
            costs[size_t(dearest)] = boundsOf(whole.first(first)).cost();
            parts.insert(parts.begin() + dearest + 1, whole.subspan(first));
            costs.insert(costs.begin() + dearest + 1, boundsOf(whole.subspan(first)).cost());
        }
        return parts;
    }

    void putBounds(size_t at, const LightBounds& bounds) {
        const auto put = [&](size_t word, double value) { words_[at + word] = std::bit_cast<uint32_t>(float(value)); };
        const dvec3 middle = bounds.middle();
        for (int axis = 0; axis < 3; axis++) {
            put(size_t(axis), middle[axis]);
            put(4 + size_t(axis), bounds.cone.axis[axis]);
        }
        put(3, bounds.radius() * (1.0 + 1e-6));  // so that rounding leaves no light outside
        put(7, std::cos(bounds.cone.halfAngle));
        put(8, std::sqrt(std::max(bounds.intensity / intensity_, WEAKEST)));
        const bool everywhere = bounds.cone.halfAngle >= std::numbers::pi;
        put(9, everywhere ? -2.0 : std::max(std::cos(bounds.beyond) - 1e-6, -1.0));
        put(10, bounds.reach < 1e30 ? bounds.reach * (1.0 + 1e-6) : 3e38);
    }

    std::vector<uint32_t>& words_;
    LightWords light_;
    double intensity_;
    uint32_t medianFrom_;
    std::vector<uint32_t> trails_;
    uint32_t levels_ = 0;
};

/// Levels of a tree of that many lights whose parts are halved by number.
uint32_t levelsByNumber(size_t lights) {
    uint32_t levels = 1;
    for (size_t held = LIGHT_TREE_WIDTH; held < lights; held *= LIGHT_TREE_WIDTH) levels++;
    return levels;
}

}  // namespace

LightTree writeLightTree(std::vector<uint32_t>& texels, std::vector<TreeLight>& lights, LightWords words, uint32_t mostLevels) {
    double intensity = 0.0;
    for (const TreeLight& light : lights) intensity += light.bounds.intensity;
    const uint32_t needed = levelsByNumber(lights.size());
    const uint32_t medianFrom = std::min(MEDIAN_FROM, mostLevels > needed ? mostLevels - needed : 0u);
    TreeWriter writer(texels, words, intensity, medianFrom, lights.size());
    LightTree tree;
    tree.root = writer.write(lights, 0, 0);
    tree.levels = writer.levels();
    tree.trails = writer.takeTrails();
    return tree;
}

void appendLightTree(Scene& scene) {
    const double radius = scene.bounds.radius();
    const auto shines = [&](const Light& light) { return boundsOf(light, radius).intensity > 0.0; };
    const auto placed = [&](const Light& light) { return light.type != LIGHT_DIRECTIONAL && light.type != LIGHT_HEADLIGHT; };
    const auto inTree = [&](const Light& light) { return placed(light) && shines(light); };
    const auto count = static_cast<size_t>(std::ranges::count_if(scene.lights, inTree));
    if (count <= MOST_LISTED_LIGHTS) return;
    const auto first = std::stable_partition(scene.lights.begin(), scene.lights.end(), std::not_fn(placed));
    std::stable_partition(first, scene.lights.end(), shines);
    Environment& environment = scene.environment;
    environment.listedLights = static_cast<uint32_t>(first - scene.lights.begin());
    std::vector<TreeLight> lights;
    const auto firstLight = static_cast<uint32_t>(scene.texels.size());
    for (uint32_t i = 0; i < count; i++) {
        const Light& light = scene.lights[environment.listedLights + i];
        lights.push_back({boundsOf(light, radius), i});
        const auto words = std::bit_cast<std::array<uint32_t, LIGHT_WORDS>>(light);
        scene.texels.insert(scene.texels.end(), words.begin(), words.end());
    }
    const LightTree tree = writeLightTree(scene.texels, lights, {firstLight, LIGHT_WORDS}, MOST_LEVELS);
    environment.lightTree = tree.root;
    environment.lightTreeLevels = tree.levels;
}

}  // namespace heliograph
