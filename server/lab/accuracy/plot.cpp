#include "server/lab/accuracy/accuracy_json.h"
#include "server/base/text.h"
#include "server/lab/accuracy/report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace heliograph {

namespace {

constexpr double WIDTH = 760.0, HEIGHT = 440.0, LEFT = 70.0, RIGHT = 20.0, TOP = 16.0, BOTTOM = 52.0;

/// A logarithmic axis from a to b, drawn from `from` to `to`.
struct Axis {
    double low, high, from, to;
    double at(double value) const {
        return from + (std::log(value) - std::log(low)) / (std::log(high) - std::log(low)) * (to - from);
    }
};

/// A little more than the values span, so that there is a tick at both ends or beside them.
Axis axisFor(const std::vector<double>& values, double from, double to) {
    const auto [low, high] = std::ranges::minmax(values);
    return {low / 1.3, std::max(high, low * 1.5) * 1.3, from, to};
}

/// 1, 2 and 5 times the powers of ten within the axis.
std::vector<double> ticks(const Axis& axis) {
    std::vector<double> all;
    for (double power = std::pow(10.0, std::floor(std::log10(axis.low))); power <= axis.high; power *= 10.0) {
        for (double factor : {1.0, 2.0, 5.0}) {
            if (power * factor >= axis.low && power * factor <= axis.high) all.push_back(power * factor);
        }
    }
    return all;
}

struct Dot {
    double ms, error;
    std::string title;
    bool front, given, combination, samples;
};

std::vector<Dot> dotsOf(const AccuracySweep& sweep) {
    const std::vector<size_t> front = sweep.front();
    std::vector<Dot> dots;
    for (size_t i = 0; i < sweep.rows().size(); i++) {
        const AccuracyRow& row = sweep.rows()[i];
        const AccuracyPoint& point = sweep.points()[row.point];
        const double ms = sweep.timeOf(point).ms, error = point.error.own.rmse;
        if (point.coding || point.byLight || !point.measured || !(ms > 0.0) || !(error > 0.0)) continue;
        const std::string title = row.knob == "combination" ? row.value : row.knob + "=" + row.value;
        dots.push_back({ms, error, title, std::ranges::find(front, i) != front.end(), row.given, row.knob == "combination",
                        row.knob == "samples"});
    }
    return dots;
}

std::string line(const char* style, const std::vector<Dot>& dots, const Axis& x, const Axis& y, bool Dot::*which) {
    std::vector<Dot> chosen;
    std::ranges::copy_if(dots, std::back_inserter(chosen), [&](const Dot& dot) { return dot.*which; });
    std::ranges::sort(chosen, {}, &Dot::ms);
    std::string points;
    for (const Dot& dot : chosen) points += formatted("%.1f,%.1f ", x.at(dot.ms), y.at(dot.error));
    return formatted("<polyline class='%s' points='", style) + points + "'/>\n";
}

std::string frame(const Axis& x, const Axis& y) {
    std::string svg;
    for (double tick : ticks(x)) {
        svg += formatted(
            "<line class='grid' x1='%.1f' x2='%.1f' y1='%.1f' y2='%.1f'/><text x='%.1f' y='%.1f' class='mid'>%g</text>\n",
            x.at(tick), x.at(tick), y.from, y.to, x.at(tick), y.from + 18.0, tick);
    }
    for (double tick : ticks(y)) {
        svg += formatted(
            "<line class='grid' x1='%.1f' x2='%.1f' y1='%.1f' y2='%.1f'/><text x='%.1f' y='%.1f' class='end'>%g %%</text>\n",
            x.from, x.to, y.at(tick), y.at(tick), x.from - 8.0, y.at(tick) + 4.0, 100.0 * tick);
    }
    svg +=
        formatted("<text class='mid' x='%.1f' y='%.1f'>milliseconds a picture</text>\n", 0.5 * (x.from + x.to), HEIGHT - 8.0);
    return svg;
}

/// Straight line of slope -1/2 through the middle of `samples`' points, and how steep those are.
std::string slopes(const AccuracySweep& sweep, const std::vector<Dot>& dots, const Axis& x, const Axis& y) {
    std::vector<double> ms, errors;
    for (const Dot& dot : dots) {
        if (!dot.samples) continue;
        ms.push_back(std::log(dot.ms));
        errors.push_back(std::log(dot.error));
    }
    if (ms.size() < 2) return {};
    const double middle = mean(ms), error = mean(errors);
    auto at = [&](double t) { return std::exp(error - 0.5 * (std::log(t) - middle)); };
    // Cut where it leaves the frame.
    const double first = std::max(x.low, std::exp(middle + 2.0 * (error - std::log(y.high))));
    const double last = std::min(x.high, std::exp(middle + 2.0 * (error - std::log(y.low))));
    std::string svg = formatted("<line class='half' x1='%.1f' y1='%.1f' x2='%.1f' y2='%.1f'/>\n", x.at(first), y.at(at(first)),
                                x.at(last), y.at(at(last)));
    const double slope = samplesSlope(sweep);
    const std::string steep = std::isfinite(slope) ? formatted("samples: slope %.2f", slope) : std::string("samples");
    struct Entry {
        const char* style;
        std::string text;
    };
    const Entry entries[] = {
        {"front", "front"}, {"samples", steep}, {"half", "slope -0.5"}, {"bound", "error of the reference"}};
    double top = TOP + 16.0;
    for (const Entry& entry : entries) {
        svg += formatted("<line class='%s' x1='%.1f' x2='%.1f' y1='%.1f' y2='%.1f'/><text x='%.1f' y='%.1f'>", entry.style,
                         x.to - 190.0, x.to - 162.0, top, top, x.to - 154.0, top + 4.0) +
               entry.text + "</text>\n";
        top += 20.0;
    }
    return svg;
}

}  // namespace

std::string plotSvg(const AccuracySweep& sweep) {
    const std::vector<Dot> dots = dotsOf(sweep);
    if (dots.empty()) return "<p>Nothing to draw.</p>";
    const double bound = sweep.referenceError(false);
    std::vector<double> times, errors;
    for (const Dot& dot : dots) {
        times.push_back(dot.ms);
        errors.push_back(dot.error);
    }
    if (bound > 0.0) errors.push_back(bound);
    const Axis x = axisFor(times, LEFT, WIDTH - RIGHT), y = axisFor(errors, HEIGHT - BOTTOM, TOP);
    std::string svg = formatted("<svg viewBox='0 0 %.0f %.0f' role='img' aria-label='Error against time'>\n", WIDTH, HEIGHT);
    svg += frame(x, y);
    if (bound > 0.0) {
        svg += formatted("<line class='bound' x1='%.1f' x2='%.1f' y1='%.1f' y2='%.1f'/>\n", x.from, x.to, y.at(bound),
                         y.at(bound));
    }
    svg += slopes(sweep, dots, x, y);
    svg += line("samples", dots, x, y, &Dot::samples);
    svg += line("front", dots, x, y, &Dot::front);
    for (const Dot& dot : dots) {
        const char* style = dot.given ? "given" : dot.front ? "best" : dot.combination ? "tried" : "one";
        svg += formatted("<circle class='%s' cx='%.1f' cy='%.1f' r='%s'><title>", style, x.at(dot.ms), y.at(dot.error),
                         dot.given   ? "6"
                         : dot.front ? "4.5"
                                     : "3") +
               escaped(dot.title) + formatted(": %.3g %%, %.4g ms</title></circle>\n", 100.0 * dot.error, dot.ms);
    }
    return svg + "</svg>\n";
}

}  // namespace heliograph
