#pragma once
// What accuracy costs in a view, and the words in which its viewer is told (docs/reference/protocol.md, `accuracy`).

#include "server/lab/accuracy/sweep.h"

namespace heliograph {

struct ViewAccuracy {
    struct Row {
        std::string knob, value;  // as AccuracyRow's
        nlohmann::json set;       // {setting: value} that the viewer's settings lack
        bool given = false;
        bool exact = false;
        bool byLight = false;
        bool coding = false;
        bool front = false;  // nothing else that was measured is both faster and nearer
        PointTime time;
        double rmse = 0.0, bias = 0.0;  // no number where `coding`
        double flip = 0.0, psnrDb = 0.0;
    };
    std::string scene;
    std::string device;
    uvec2 size{0, 0};      // pixels that were measured, at a renderScale of 1
    double scale = 1.0;    // pixels of the viewer's picture over those
    uint32_t samples = 0;  // of the settings as given
    double seconds = 0.0;  // that it took, waiting for others left out
    double referenceError = 0.0;
    double modelError = 0.0;
    std::vector<Row> rows;
    std::vector<uint8_t> exactPng, givenPng;
};

/// The figures and pictures of a finished sweep. `given`: the viewer's settings, which may differ from the sweep's in what a
/// measurement has otherwise. Scene, scale and seconds are left to the caller. Renders a picture.
ViewAccuracy viewAccuracy(AccuracySweep& sweep, const Settings& given);

std::string accuracyMeasuringMessage(double share, const std::string& what);
std::string accuracyReadyMessage(const ViewAccuracy& accuracy);
std::string accuracyGivenUpMessage();
std::string accuracyFailedMessage(const std::string& why);

/// RFC 4648, section 4.
std::string base64(std::span<const uint8_t> bytes);

}  // namespace heliograph
