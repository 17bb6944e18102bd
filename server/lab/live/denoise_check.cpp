#include "server/lab/live/denoise_check.h"

#include "server/base/clock.h"
#include "server/encode/tone_map.h"
#include "server/lab/accuracy/reference.h"
#include "server/lab/effect_bench.h"
#include "server/render/denoise_pass.h"
#include "server/render/frame_renderer.h"

#include <cmath>

namespace heliograph {

namespace {

/// A view, its reference, and pictures of it.
class DenoiseTrial {
public:
    DenoiseTrial(Renderer& renderer, const Scene& scene, const FrameRequest& request, const DenoiseBounds& bounds)
        : renderer_(renderer),
          request_(request),
          bounds_(bounds),
          toneMap_(scene.exposure + request.settings.exposure,
                   shownCurve(static_cast<ToneCurve>(request.settings.toneCurve), scene.fromFile)),
          ceiling_(static_cast<float>(Film::WHITE) * std::exp2(-(scene.exposure + request.settings.exposure))) {}

    double makeReference(const Progress& progress) {
        Reference reference(request_);
        RendererFrames frames(renderer_);
        while (!reference.hasBothHalves() || reference.samples() < bounds_.referenceSamples) {
            reference.addRun(frames);
            report(progress, "reference", double(reference.samples()) / bounds_.referenceSamples);
        }
        truth_ = limited(reference.picture(), ceiling_);
        shownTruth_ = shown(truth_);
        return reference.ownError(ceiling_);
    }

    DenoiseRow row(uint32_t samples) {
        DenoiseRow row;
        row.samples = samples;
        std::vector<double> frame, guides, filter, device;
        std::shared_ptr<const std::vector<vec4>> filtered;
        for (uint32_t i = 0; i <= bounds_.repetitions; i++) {  // the first one warms up
            FrameRequest request = request_;
            request.settings.denoiser = static_cast<uint32_t>(DenoiserSetting::filter);
            request.generation = ++generation_;
            const double frameMs = renderFrame(renderer_, request, samples, film_).milliseconds;
            ViewMemory view;
            PassFigures figures;
            filtered = denoiser_.run(passes_, {renderer_, request, film_, view}, static_cast<double>(ceiling_), figures);
            if (!filtered) throw std::runtime_error("pictures of this device are not filtered");
            if (i == 0) continue;
            frame.push_back(frameMs), guides.push_back(denoiser_.took().guidesMs), filter.push_back(denoiser_.took().filterMs);
            device.push_back(denoiser_.took().deviceMs);
        }
        row.frameMs = median(frame), row.guidesMs = median(guides), row.filterMs = median(filter),
        row.deviceMs = median(device);
        LinearPicture picture{request_.resolution, {}};
        film_.develop(picture.pixels);
        judge(picture, row.before, row.shownBefore);
        picture.pixels = *filtered;
        judge(picture, row.after, row.shownAfter);
        return row;
    }

private:
    DisplayImage shown(const LinearPicture& picture) const {
        DisplayImage image;
        toneMap_.apply(picture.pixels, picture.resolution, image);
        return image;
    }
    void judge(const LinearPicture& picture, LinearError& linear, DisplayError& display) const {
        linear = linearError(limited(picture, ceiling_), truth_);
        display = displayError(shown(picture), shownTruth_);
    }

    Renderer& renderer_;
    const FrameRequest request_;
    const DenoiseBounds& bounds_;
    const ToneMap toneMap_;
    const float ceiling_;
    LinearPicture truth_;
    DisplayImage shownTruth_;
    Film film_;
    PassRenderer passes_;
    DenoisePass denoiser_;
    uint32_t generation_ = 0;
};

nlohmann::ordered_json toJson(const LinearError& linear, const DisplayError& display) {
    return {{"rmse", linear.rmse},
            {"bias", linear.bias},
            {"psnr_db", display.psnrDb},
            {"p99", display.p99},
            {"flip", display.flip}};
}

}  // namespace

DenoisedView checkDenoise(Renderer& renderer, const Scene& scene, const FrameRequest& request, const DenoiseBounds& bounds,
                          const Progress& progress) {
    DenoiseTrial trial(renderer, scene, request, bounds);
    DenoisedView view;
    view.device = renderer.infoFor(request.settings).name;
    view.referenceError = trial.makeReference(progress);
    for (uint32_t samples : bounds.samples) view.rows.push_back(trial.row(samples));
    return view;
}

nlohmann::ordered_json toJson(const std::vector<DenoisedView>& views) {
    nlohmann::ordered_json all = nlohmann::ordered_json::array();
    for (const DenoisedView& view : views) {
        nlohmann::ordered_json rows = nlohmann::ordered_json::array();
        for (const DenoiseRow& row : view.rows) {
            rows.push_back(
                {{"samples", row.samples},
                 {"ms", {{"frame", row.frameMs}, {"guides", row.guidesMs}, {"filter", row.filterMs}, {"device", row.deviceMs}}},
                 {"before", toJson(row.before, row.shownBefore)},
                 {"after", toJson(row.after, row.shownAfter)}});
        }
        all.push_back({{"scene", view.scene},
                       {"view", view.view},
                       {"device", view.device},
                       {"reference_error", view.referenceError},
                       {"rows", rows}});
    }
    return {{"views", all}};
}

std::string toTable(const std::vector<DenoisedView>& views) {
    std::string text;
    char line[256];
    for (const DenoisedView& view : views) {
        std::snprintf(line, sizeof line, "%s, %s on %s, reference's own error %.2f %%\n", view.scene.c_str(), view.view.c_str(),
                      view.device.c_str(), 1e2 * view.referenceError);
        text += line;
        text +=
            "samples   frame ms  guides ms  filter ms  device ms     error      after   PSNR dB  after    FLIP   after  "
            "ratio\n";
        for (const DenoiseRow& row : view.rows) {
            std::snprintf(line, sizeof line,
                          "%7u %10.1f %10.1f %10.1f %10.2f  %7.2f %%  %7.2f %%   %6.1f %6.1f   %.4f  %.4f  %.3f\n", row.samples,
                          row.frameMs, row.guidesMs, row.filterMs, row.deviceMs, 1e2 * row.before.rmse, 1e2 * row.after.rmse,
                          row.shownBefore.psnrDb, row.shownAfter.psnrDb, row.shownBefore.flip, row.shownAfter.flip,
                          row.shownAfter.flip / row.shownBefore.flip);
            text += line;
        }
    }
    return text;
}

}  // namespace heliograph
