#include "server/lab/accuracy/accuracy_json.h"

#include "server/base/text.h"
#include "server/lab/accuracy/pareto.h"

#include <cmath>
#include <cstdio>
#include <sstream>

namespace heliograph {

namespace {

using nlohmann::ordered_json;

/// Errors below this multiple of the reference's own say nothing about the picture.
constexpr double CLAIMED_FROM = 2.0, SLOPE_FROM = 3.0;

ordered_json linearJson(const LinearError& error) {
    return {{"rmse", error.rmse}, {"relative_mse", error.relativeMse}, {"bias", error.bias}, {"rmse_all", error.rmseAll}};
}

bool atBound(const AccuracySweep& sweep, const AccuracyPoint& point) {
    return !point.coding && point.judged().rmse < CLAIMED_FROM * sweep.referenceError(point.byLight);
}

ordered_json rowJson(const AccuracySweep& sweep, const AccuracyRow& row) {
    const AccuracyPoint& point = sweep.points()[row.point];
    const PointTime time = sweep.timeOf(point);
    ordered_json json = {{"knob", row.knob},     {"value", row.value},
                         {"set", point.set},     {"exact", row.exact},
                         {"given", row.given},   {"against", point.coding ? "uncoded" : point.byLight ? "light" : "own"},
                         {"ms_median", time.ms}, {"ms_low", time.low},
                         {"ms_high", time.high}, {"repetitions", time.repetitions}};
    if (point.coding) {
        json["bytes"] = point.bytes;
    } else {
        json.update(linearJson(point.judged()));
        json["at_bound"] = atBound(sweep, point);
        json["from_exact"] = row.fromExact >= 0.0 ? ordered_json(row.fromExact) : ordered_json(nullptr);
        json["light"] = linearJson(point.error.light);
        json["rays"] = toJson(point.time.first.rays);
    }
    json["psnr_db"] = point.error.display.psnrDb;
    json["p99"] = point.error.display.p99;
    json["flip"] = point.error.display.flip;
    return json;
}

ordered_json referenceJson(const AccuracySweep& sweep, bool light) {
    uint32_t samples = 0;
    double ms = 0.0;
    for (size_t view = 0; view < sweep.options().views.size(); view++) {
        const Reference& reference = sweep.reference(view, light);
        samples = view == 0 ? reference.samples() : std::min(samples, reference.samples());
        ms += reference.milliseconds();
    }
    return {{"samples", samples}, {"ms", ms}, {"rmse", sweep.referenceError(light)}};
}

}  // namespace

double samplesSlope(const AccuracySweep& sweep) {
    std::vector<double> samples, errors;
    for (const AccuracyRow& row : sweep.rows()) {
        const AccuracyPoint& point = sweep.points()[row.point];
        if (row.knob != "samples" || point.error.own.rmse < SLOPE_FROM * sweep.referenceError(false)) continue;
        samples.push_back(point.settings.samples);
        errors.push_back(point.error.own.rmse);
    }
    return logSlope(samples, errors);
}

ordered_json toJson(const AccuracySweep& sweep) {
    ordered_json rows = ordered_json::array(), notTurned = ordered_json::array(), views = ordered_json::array();
    for (const AccuracyRow& row : sweep.rows()) rows.push_back(rowJson(sweep, row));
    for (const NotTurned& knob : sweep.notTurned()) notTurned.push_back({{"knob", knob.knob}, {"why", knob.why}});
    for (const AccuracyView& view : sweep.options().views) views.push_back(view.name);
    const double slope = samplesSlope(sweep);
    return {{"scene", sweep.scene().name},
            {"device", sweep.device()},
            {"width", sweep.options().resolution.x},
            {"height", sweep.options().resolution.y},
            {"views", views},
            {"time", sweep.timedByCore() ? "core" : "wall"},
            {"settings", sweep.options().settings.toJson()},
            {"reference", referenceJson(sweep, false)},
            {"light_reference", referenceJson(sweep, true)},
            {"model", linearJson(sweep.modelError())},
            {"rows", rows},
            {"pareto", sweep.front()},
            {"samples_slope", std::isfinite(slope) ? ordered_json(slope) : ordered_json(nullptr)},
            {"not_turned", notTurned}};
}

std::string toCsv(const AccuracySweep& sweep) {
    std::ostringstream text;
    text << "knob,value,against,ms_median,ms_low,ms_high,rmse,relative_mse,bias,psnr_db,p99,flip,light_rmse,rays\n";
    for (const AccuracyRow& row : sweep.rows()) {
        const AccuracyPoint& point = sweep.points()[row.point];
        const PointTime time = sweep.timeOf(point);
        text << row.knob << "," << row.value << ","
             << (point.coding    ? "uncoded"
                 : point.byLight ? "light"
                                 : "own")
             << "," << time.ms << "," << time.low << "," << time.high << ",";
        if (point.coding) text << ",,,";
        else text << point.judged().rmse << "," << point.judged().relativeMse << "," << point.judged().bias << ",";
        text << point.error.display.psnrDb << "," << point.error.display.p99 << "," << point.error.display.flip << ",";
        if (point.coding) text << ",\n";
        else text << point.error.light.rmse << "," << point.time.first.rays.total() << "\n";
    }
    return text.str();
}

std::string toTable(const AccuracySweep& sweep) {
    std::ostringstream out;
    const LinearError model = sweep.modelError();
    out << oneLine(sweep.scene().name) << " on " << sweep.device()
        << formatted(", %ux%u, %zu view(s), %u samples\n", sweep.options().resolution.x, sweep.options().resolution.y,
                     sweep.options().views.size(), sweep.options().settings.samples)
        << formatted("reference: %u samples, own error %.3f %%; of all light: %u samples, %.3f %%\n",
                     sweep.reference(0, false).samples(), 100.0 * sweep.referenceError(false),
                     sweep.reference(0, true).samples(), 100.0 * sweep.referenceError(true))
        << formatted("interactive model against all light: %.2f %%, bias %+.2f %%\n", 100.0 * model.rmse, 100.0 * model.bias)
        << formatted("%-22s %-12s %9s %8s %8s %8s %7s %6s  %s\n", "setting", "value", "ms", "error %", "bias %", "PSNR dB",
                     "FLIP", "p99", "");
    const std::vector<size_t> front = sweep.front();
    for (size_t i = 0; i < sweep.rows().size(); i++) {
        const AccuracyRow& row = sweep.rows()[i];
        const AccuracyPoint& point = sweep.points()[row.point];
        std::string notes;
        if (row.given) notes += "as given ";
        if (std::ranges::find(front, i) != front.end()) notes += "front ";
        if (point.byLight) notes += "against all light ";
        if (point.coding) notes += formatted("%llu bytes ", static_cast<unsigned long long>(point.bytes));
        else if (atBound(sweep, point)) notes += "not above the reference's error ";
        out << formatted("%-22s %-12s %9.2f", row.knob.c_str(), row.value.c_str(), sweep.timeOf(point).ms);
        if (point.coding) out << formatted(" %8s %8s", "", "");
        else out << formatted(" %8.3f %+8.3f", 100.0 * point.judged().rmse, 100.0 * point.judged().bias);
        out << formatted(" %8.2f %7.4f %6.1f  %s\n", point.error.display.psnrDb, point.error.display.flip,
                         point.error.display.p99, notes.c_str());
    }
    for (const NotTurned& knob : sweep.notTurned()) out << knob.knob << ": " << oneLine(knob.why) << "\n";
    return out.str();
}

}  // namespace heliograph
