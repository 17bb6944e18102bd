#include "server/lab/view/view_accuracy.h"

#include "server/encode/png_encoder.h"

#include <algorithm>
#include <limits>
#include <set>

namespace heliograph {

namespace {

using nlohmann::json;

constexpr size_t MOST_COMBINATIONS = 400;  // beside those of the front: a long sweep of a small view may try thousands

/// JSON has no infinity and no NaN: the library writes null.
std::string messageText(json message) {
    message["type"] = "accuracy";
    return message.dump(-1, ' ', false, json::error_handler_t::replace);
}

std::vector<uint8_t> pngOf(const DisplayImage& image) {
    std::vector<uint8_t> bytes;
    makePngEncoder()->encode(image, 100, bytes);
    return bytes;
}

/// What of the row's point the viewer's settings have otherwise: the knob's own value, or those of the combination.
json changesOf(const AccuracyRow& row, const AccuracyPoint& point, const json& given) {
    const json values = point.settings.toJson();
    json set = json::object();
    auto add = [&](const std::string& name) {
        if (values.contains(name) && values[name] != given[name]) set[name] = values[name];
    };
    add(row.knob);
    for (const std::string& text : point.set) add(text.substr(0, text.find('=')));
    return set;
}

ViewAccuracy::Row rowOf(const AccuracySweep& sweep, const AccuracyRow& row, bool front, const json& given) {
    constexpr double UNKNOWN = std::numeric_limits<double>::quiet_NaN();
    const AccuracyPoint& point = sweep.points()[row.point];
    ViewAccuracy::Row result;
    result.knob = row.knob;
    result.value = row.value;
    result.set = changesOf(row, point, given);
    result.given = row.given;
    result.exact = row.exact;
    result.byLight = point.byLight;
    result.coding = point.coding;
    result.front = front;
    result.time = sweep.timeOf(point);
    result.rmse = point.coding ? UNKNOWN : point.judged().rmse;
    result.bias = point.coding ? UNKNOWN : point.judged().bias;
    result.flip = point.error.display.flip;
    result.psnrDb = point.error.display.psnrDb;
    return result;
}

json rowJson(const ViewAccuracy::Row& row) {
    return {{"knob", row.knob},   {"value", row.value},     {"set", row.set},        {"given", row.given},
            {"exact", row.exact}, {"byLight", row.byLight}, {"coding", row.coding},  {"front", row.front},
            {"ms", row.time.ms},  {"low", row.time.low},    {"high", row.time.high}, {"rmse", row.rmse},
            {"bias", row.bias},   {"flip", row.flip},       {"psnrDb", row.psnrDb}};
}

}  // namespace

ViewAccuracy viewAccuracy(AccuracySweep& sweep, const Settings& given) {
    ViewAccuracy accuracy;
    accuracy.device = sweep.device();
    accuracy.size = sweep.options().resolution;
    accuracy.samples = sweep.options().settings.samples;
    accuracy.referenceError = sweep.referenceError(false);
    accuracy.modelError = sweep.modelError().rmse;
    std::set<size_t> front;  // points
    for (size_t row : sweep.front()) front.insert(sweep.rows()[row].point);
    const json values = given.toJson();
    size_t combinations = 0;
    for (const AccuracyRow& row : sweep.rows()) {
        const bool best = front.contains(row.point);
        if (row.knob == "combination" && !best && ++combinations > MOST_COMBINATIONS) continue;
        accuracy.rows.push_back(rowOf(sweep, row, best, values));
    }
    accuracy.exactPng = pngOf(sweep.shown(sweep.reference(0, false).picture()));
    const AccuracyPoint asGiven = sweep.points().front();
    accuracy.givenPng = pngOf(sweep.shown(sweep.picture(asGiven)));
    return accuracy;
}

std::string accuracyMeasuringMessage(double share, const std::string& what) {
    return messageText({{"state", "measuring"}, {"share", std::clamp(share, 0.0, 1.0)}, {"what", what}});
}

std::string accuracyReadyMessage(const ViewAccuracy& accuracy) {
    json rows = json::array();
    for (const ViewAccuracy::Row& row : accuracy.rows) rows.push_back(rowJson(row));
    return messageText({{"state", "ready"},
                        {"scene", accuracy.scene},
                        {"device", accuracy.device},
                        {"size", {accuracy.size.x, accuracy.size.y}},
                        {"scale", accuracy.scale},
                        {"samples", accuracy.samples},
                        {"seconds", accuracy.seconds},
                        {"referenceError", accuracy.referenceError},
                        {"modelError", accuracy.modelError},
                        {"rows", rows},
                        {"pictures", {{"exact", base64(accuracy.exactPng)}, {"given", base64(accuracy.givenPng)}}}});
}

std::string accuracyGivenUpMessage() { return messageText({{"state", "given-up"}}); }

std::string accuracyFailedMessage(const std::string& why) { return messageText({{"state", "failed"}, {"what", why}}); }

std::string base64(std::span<const uint8_t> bytes) {
    constexpr std::string_view DIGITS = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    text.reserve((bytes.size() + 2) / 3 * 4);
    for (size_t i = 0; i < bytes.size(); i += 3) {
        uint32_t three = 0;
        for (size_t j = 0; j < 3; j++) three = three << 8 | (i + j < bytes.size() ? bytes[i + j] : 0u);
        for (size_t j = 0; j < 4; j++) text += i + j <= bytes.size() ? DIGITS[three >> (18 - 6 * j) & 63u] : '=';
    }
    return text;
}

}  // namespace heliograph
