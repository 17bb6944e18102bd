#include "server/lab/convergence/independence.h"

#include "server/lab/accuracy/picture.h"
#include "server/lab/accuracy/reference.h"
#include "server/lab/convergence/means.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace heliograph {

namespace {

using DoubleSums = std::vector<glm::dvec3>;

// Any but those of pictures and of references (reference.cpp), for the four pictures that judge those.
constexpr uint32_t JUDGES_SEEDS[] = {0xdaa66d2bu, 0x78dde6e4u, 0x1715609du, 0xb54cda56u};
constexpr uint32_t JUDGES_BEGINNINGS[] = {3u << 24, 1u << 26, 5u << 24, 7u << 24};

/// A picture of `samples`, of `finer` times as many pixels a side and accordingly fewer samples in each: means of these.
LinearPicture judge(Renderer& renderer, FrameRequest request, int which, uint32_t finer, uint32_t samples) {
    const uvec2 size = request.resolution, fine = finer * size;
    request.resolution = fine;
    request.seed = JUDGES_SEEDS[which];
    request.generation++;
    const DoubleSums sums = renderSamples(renderer, request, JUDGES_BEGINNINGS[which], samples / (finer * finer));
    DoubleSums of(static_cast<size_t>(size.x) * size.y);
    for (uint32_t y = 0; y < fine.y; y++)
        for (uint32_t x = 0; x < fine.x; x++) of[size_t(y / finer) * size.x + x / finer] += sums[size_t(y) * fine.x + x];
    return meanPicture(of, size, samples);
}

double squareOfDifference(const LinearPicture& a, const LinearPicture& b) {
    double sum = 0.0;
    for (size_t i = 0; i < a.pixels.size(); i++) {
        const glm::dvec3 d = glm::dvec3(vec3(a.pixels[i])) - glm::dvec3(vec3(b.pixels[i]));
        sum += glm::dot(d, d);
    }
    return sum / (3.0 * static_cast<double>(a.pixels.size()));
}

/// Error of `picture` by a truth of two halves, whose mean is half as far from the truth as they are from each other.
double errorBy(const LinearPicture& picture, const LinearPicture& first, const LinearPicture& second, double level) {
    const double own = squareOfDifference(first, second) / 4.0;
    return std::sqrt(std::max(squareOfDifference(picture, meanOf(first, second)) - own, 0.0)) / level;
}

}  // namespace

double agreementOfErrors(const LinearPicture& a, const LinearPicture& b, const LinearPicture& truth,
                         const LinearPicture& otherTruth) {
    double sum = 0.0;
    size_t count = 0;
    for (size_t i = 0; i < a.pixels.size(); i++) {
        const glm::dvec3 x = glm::dvec3(vec3(a.pixels[i])) - glm::dvec3(vec3(truth.pixels[i]));
        const glm::dvec3 y = glm::dvec3(vec3(b.pixels[i])) - glm::dvec3(vec3(otherTruth.pixels[i]));
        const double size = glm::dot(x, x) + glm::dot(y, y);
        if (size == 0.0) continue;
        sum += 2.0 * glm::dot(x, y) / size;
        count++;
    }
    return count > 0 ? sum / static_cast<double>(count) : 0.0;
}

Independence measureIndependence(Renderer& renderer, const FrameRequest& request, const IndependenceBounds& bounds,
                                 const Progress& progress) {
    const uint32_t samples = bounds.samples, most = bounds.referenceSamples;
    const double all = 6.0 * most;
    const uvec2 size = request.resolution;
    auto pictureOf = [&](const DoubleSums& sums, uint32_t count) {
        return limited(meanPicture(sums, size, count), bounds.ceiling);
    };
    DoubleSums sums = renderSamples(renderer, request, 0, samples);
    const LinearPicture picture = pictureOf(sums, samples);
    const DoubleSums rest = renderSamples(renderer, request, samples, most - samples);
    for (size_t i = 0; i < sums.size(); i++) sums[i] += rest[i];
    const LinearPicture longer = pictureOf(sums, most);
    report(progress, "the picture and its longer run", most / all);
    RendererFrames frames(renderer);
    Reference reference(request);
    while (reference.samples() < most) {
        reference.addRun(frames);
        report(progress, "reference", (most + reference.samples()) / all);
    }
    LinearPicture judges[4];  // of as many pixels, then larger ones
    for (int i = 0; i < 4; i++) {
        judges[i] = limited(judge(renderer, request, i, i < 2 ? 1 : 2, most), bounds.ceiling);
        report(progress, "pictures that judge the reference", (3.0 + i) * most / all);
    }
    const LinearPicture halves[] = {limited(reference.half(0), bounds.ceiling), limited(reference.half(1), bounds.ceiling)};
    const LinearPicture whole = meanOf(halves[0], halves[1]);
    const double level = levelOf(whole);
    Independence result;
    result.samples = samples;
    result.referenceSamples = most;
    result.referenceError = std::sqrt(squareOfDifference(halves[0], halves[1])) / 2.0 / level;
    result.halves = agreementOfErrors(halves[0], halves[1], judges[0], judges[1]);
    result.withReference = agreementOfErrors(picture, whole, judges[0], judges[1]);
    result.withItself = agreementOfErrors(picture, longer, judges[0], judges[1]);
    result.byReference = errorBy(picture, halves[0], halves[1], level);
    result.byLargerPicture = errorBy(picture, judges[2], judges[3], level);
    result.byItself = std::sqrt(squareOfDifference(picture, longer)) / level;
    return result;
}

nlohmann::ordered_json toJson(const std::vector<Independence>& views) {
    nlohmann::ordered_json json;
    json["views"] = nlohmann::ordered_json::array();
    for (const Independence& v : views)
        json["views"].push_back({{"scene", v.scene},
                                 {"view", v.view},
                                 {"samples", v.samples},
                                 {"reference_samples", v.referenceSamples},
                                 {"reference_error", v.referenceError},
                                 {"agreement_of_halves", v.halves},
                                 {"agreement_with_reference", v.withReference},
                                 {"agreement_with_itself", v.withItself},
                                 {"error_by_reference", v.byReference},
                                 {"error_by_larger_picture", v.byLargerPicture},
                                 {"error_by_itself", v.byItself}});
    return json;
}

std::string toTable(const std::vector<Independence>& views) {
    std::string table;
    char text[512];
    for (const Independence& v : views) {
        std::snprintf(text, sizeof text,
                      ", %u samples; all others have %u, the reference an own error of %.4f %%\n"
                      "                                  agreement     error\n"
                      "reference's halves              %11.3f\n"
                      "picture and reference           %11.3f %8.4f%%\n"
                      "picture and larger ones                     %8.4f%%\n"
                      "picture and its longer run      %11.3f %8.4f%%\n",
                      v.samples, v.referenceSamples, 100.0 * v.referenceError, v.halves, v.withReference, 100.0 * v.byReference,
                      100.0 * v.byLargerPicture, v.withItself, 100.0 * v.byItself);
        table += v.scene + ", " + v.view + text;
    }
    return table;
}

}  // namespace heliograph
