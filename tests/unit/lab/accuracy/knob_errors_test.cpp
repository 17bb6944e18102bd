// Turning a knob towards exactness never makes a picture worse: the first promise, for every knob that is turned.

#include "server/device/embree/embree_device.h"
#include "server/lab/accuracy/sweep.h"
#include "server/request/camera.h"
#include "server/scene/framing.h"
#include "server/scene/load/scene_source.h"
#include "tests/support/direct_renderer.h"
#include "tests/support/sanitized.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

namespace heliograph::TEST_FILE {
namespace {

struct View {
    const char* scene;
    std::vector<const char*> set;  // NAME=VALUE
};

/// The project's own scenes as they are, then what lets the rest of the knobs do something.
const std::vector<View>& views() {
    static const std::vector<View> VIEWS = {
        {"cornell", {}},
        {"courtyard", {"ambientOcclusion=on"}},
        {"cathedral", {}},
        {"glass", {}},
        {"effects/soft-shadows", {}},
        {"effects/fog", {"fog=on"}},
        {"effects/many-lights", {}},
        {"effects/indirect-light", {"indirectLight=on"}},
        {"effects/image-light", {"integrator=path"}},
    };
    return VIEWS;
}

/// So far noise moves the error of a picture of 24 x 14 pixels. What is shown is compared, where one glint of a lamp counts no more than
/// white.
constexpr double NOISE = 0.15;
constexpr double CODES = 1.5;   // of 255, root mean square: of the reference, and of edges of a few pixels
constexpr double LEAST = 0.01;  // relative RMSE

/// The last of a knob's rows is the most exact one.
using Rows = std::vector<const AccuracyRow*>;

double codesOff(const AccuracyPoint& point) { return 255.0 * std::pow(10.0, -0.05 * point.error.display.psnrDb); }

/// A knob's rows, in their order: as they are shown beside the view's reference, as far as two are judged by the same one; and, where both
/// have the same noise, beside the knob's own most exact value.
void expectFalling(const AccuracySweep& sweep, const Rows& rows, KnobKind kind) {
    for (size_t i = 1; i < rows.size(); i++) {
        const AccuracyPoint& cheap = sweep.points()[rows[i - 1]->point];
        const AccuracyPoint& exact = sweep.points()[rows[i]->point];
        ASSERT_TRUE(cheap.measured && exact.measured);
        SCOPED_TRACE(rows[i]->knob + " from " + rows[i - 1]->value + " to " + rows[i]->value);
        if (cheap.byLight == exact.byLight) {
            EXPECT_LE(codesOff(exact), codesOff(cheap) * (1.0 + NOISE) + CODES);
        }
        if (kind != KnobKind::grain) {
            EXPECT_LE(rows[i]->fromExact, rows[i - 1]->fromExact * (1.0 + NOISE) + LEAST);
        }
    }
}

std::map<std::string, Rows> rowsByKnob(const AccuracySweep& sweep) {
    std::map<std::string, Rows> all;
    for (const AccuracyRow& row : sweep.rows())
        if (row.knob != "combination" && !sweep.points()[row.point].coding) all[row.knob].push_back(&row);
    return all;
}

}  // namespace

TEST(KnobErrors, NeverRiseTowardsExactness) {
    std::set<std::string> turned;
    const auto device = makeEmbreeDevice();
    for (const View& view : views()) {
        if (test::SANITIZED && &view != views().data()) break;
        SCOPED_TRACE(view.scene);
        const auto scene = openScene(view.scene);
        AccuracyOptions options;
        options.settings.samples = 16;
        for (const char* text : view.set) options.settings.setFromText(text);
        options.resolution = uvec2(24, 14);
        options.referenceSamples = 128;
        options.repetitions = 1;
        options.budgetSeconds = 1e-3;  // every point once
        options.views = {{"first", checkedCamera(cameraFrom(startCamera(*scene, 16.0 / 9.0)))}};
        test::DirectRenderer renderer(*device);
        renderer.load(scene, options.settings, {});
        RendererFrames frames(renderer);
        AccuracySweep sweep(frames, *scene, options);
        sweep.run({});
        const auto all = rowsByKnob(sweep);
        for (const Knob& knob : knobs()) {
            const auto found = all.find(std::string(knob.setting));
            if (found == all.end()) continue;
            if (found->second.size() > 1) turned.insert(found->first);
            expectFalling(sweep, found->second, knob.kind);
        }
    }
    if (test::SANITIZED) return;
    for (const Knob& knob : knobs())
        EXPECT_EQ(knob.turned() && knob.kind != KnobKind::display, turned.contains(std::string(knob.setting))) << knob.setting;
}

}  // namespace heliograph::TEST_FILE
