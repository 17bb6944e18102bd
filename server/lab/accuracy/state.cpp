// The part of the sweep that goes on in another run.

#include "server/lab/accuracy/sweep.h"

#include <algorithm>

namespace heliograph {

namespace {

using nlohmann::json;
using nlohmann::ordered_json;

ordered_json timingJson(const Timing& timing) {
    return {{"wall_ms", timing.wallMs}, {"core_ms", timing.coreMs}, {"rays", timing.rays.by}};
}

void readTiming(const json& from, Timing& timing) {
    from.at("wall_ms").get_to(timing.wallMs);
    from.at("core_ms").get_to(timing.coreMs);
    from.at("rays").get_to(timing.rays.by);
}

ordered_json linearRow(const LinearError& error) { return {error.rmse, error.relativeMse, error.bias, error.rmseAll}; }

LinearError linearOf(const json& from) {
    return {from.at(0).get<double>(), from.at(1).get<double>(), from.at(2).get<double>(), from.at(3).get<double>()};
}

ordered_json pointJson(const AccuracyPoint& point) {
    return {{"set", point.set},
            {"coding", point.coding},
            {"by_light", point.byLight},
            {"first", timingJson(point.time.first)},
            {"second", timingJson(point.time.second)},
            {"ms", point.ms},
            {"bytes", point.bytes},
            {"own", linearRow(point.error.own)},
            {"light", linearRow(point.error.light)},
            {"display", {point.error.display.psnrDb, point.error.display.p99, point.error.display.flip}},
            {"measured", point.measured}};
}

AccuracyPoint pointOfJson(const json& from, const Settings& given) {
    AccuracyPoint point;
    from.at("set").get_to(point.set);
    point.settings = given;
    for (const std::string& text : point.set) point.settings.setFromText(text);
    from.at("coding").get_to(point.coding);
    from.at("by_light").get_to(point.byLight);
    readTiming(from.at("first"), point.time.first);
    readTiming(from.at("second"), point.time.second);
    from.at("ms").get_to(point.ms);
    from.at("bytes").get_to(point.bytes);
    point.error.own = linearOf(from.at("own"));
    point.error.light = linearOf(from.at("light"));
    const json& display = from.at("display");
    point.error.display = {display.at(0).get<double>(), display.at(1).get<double>(), display.at(2).get<double>()};
    from.at("measured").get_to(point.measured);
    return point;
}

/// What has to be the same for a state to be of use.
ordered_json keyOf(const AccuracySweep& sweep) {
    ordered_json views = ordered_json::array();
    for (const AccuracyView& view : sweep.options().views) {
        const Camera& c = view.camera;
        views.push_back({c.position.x, c.position.y, c.position.z, c.forward.x, c.forward.y, c.forward.z, c.up.x, c.up.y,
                         c.up.z, c.fieldOfView});
    }
    return {{"scene", sweep.scene().name},
            {"content", sweep.scene().contentHash},
            {"device", sweep.device()},
            {"size", {sweep.options().resolution.x, sweep.options().resolution.y}},
            {"settings", sweep.options().settings.toJson()},
            {"views", views}};
}

}  // namespace

ordered_json AccuracySweep::state() const {
    ordered_json points = ordered_json::array(), rows = ordered_json::array();
    for (const AccuracyPoint& point : points_) points.push_back(pointJson(point));
    for (const AccuracyRow& row : rows_) {
        rows.push_back({{"knob", row.knob},
                        {"value", row.value},
                        {"exact", row.exact},
                        {"given", row.given},
                        {"point", row.point},
                        {"from_exact", row.fromExact}});
    }
    return {{"format", "heliograph bench accuracy 1"},
            {"key", keyOf(*this)},
            {"seconds", spent()},
            {"points", points},
            {"rows", rows}};
}

std::vector<uint8_t> AccuracySweep::referenceBytes() const {
    std::vector<uint8_t> all;
    for (const View& view : views_) {
        for (const Reference* reference : {&view.own, &view.light}) {
            const std::vector<uint8_t> bytes = reference->bytes();
            all.insert(all.end(), bytes.begin(), bytes.end());
        }
    }
    return all;
}

bool AccuracySweep::restore(const json& state, std::span<const uint8_t> references) try {
    if (state.at("format") != "heliograph bench accuracy 1" || state.at("key") != json(keyOf(*this))) return false;
    std::vector<AccuracyPoint> points;
    std::vector<AccuracyRow> rows;
    for (const json& point : state.at("points")) points.push_back(pointOfJson(point, options_.settings));
    for (const json& row : state.at("rows")) {
        rows.push_back({row.at("knob").get<std::string>(), row.at("value").get<std::string>(), row.at("exact").get<bool>(),
                        row.at("given").get<bool>(), row.at("point").get<size_t>(), row.at("from_exact").get<double>()});
        if (rows.back().point >= points.size()) return false;
    }
    // Another build may have other knobs.
    for (size_t i = 0; i < rows_.size(); i++) {
        if (i >= rows.size() || rows[i].knob != rows_[i].knob || rows[i].value != rows_[i].value) return false;
    }
    const size_t each = views_.front().own.bytes().size();
    if (references.size() != 2 * views_.size() * each) return false;
    for (size_t i = 0; i < views_.size(); i++) {
        if (!views_[i].own.restore(references.subspan(2 * i * each, each))) return false;
        if (!views_[i].light.restore(references.subspan((2 * i + 1) * each, each))) return false;
    }
    points_ = std::move(points);
    rows_ = std::move(rows);
    spentBefore_ = state.at("seconds").get<double>();
    return true;
} catch (const json::exception&) {
    return false;
}

}  // namespace heliograph
