#include "server/lab/accuracy/pareto.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace heliograph {

std::vector<size_t> paretoFront(std::span<const Bargain> points) {
    std::vector<size_t> order;
    for (size_t i = 0; i < points.size(); i++) {
        if (std::isfinite(points[i].ms) && std::isfinite(points[i].error)) order.push_back(i);
    }
    std::ranges::stable_sort(order, [&](size_t a, size_t b) {
        return points[a].ms < points[b].ms || (points[a].ms == points[b].ms && points[a].error < points[b].error);
    });
    std::vector<size_t> front;
    for (size_t i : order) {
        if (front.empty() || points[i].error < points[front.back()].error) front.push_back(i);
    }
    return front;
}

double logSlope(std::span<const double> x, std::span<const double> y) {
    double count = 0.0, sumX = 0.0, sumY = 0.0, sumXX = 0.0, sumXY = 0.0;
    for (size_t i = 0; i < std::min(x.size(), y.size()); i++) {
        if (!(x[i] > 0.0 && y[i] > 0.0)) continue;
        const double u = std::log(x[i]), v = std::log(y[i]);
        count += 1.0;
        sumX += u;
        sumY += v;
        sumXX += u * u;
        sumXY += u * v;
    }
    const double spread = count * sumXX - sumX * sumX;
    if (count < 2.0 || !(spread > 1e-12 * count * sumXX)) return std::numeric_limits<double>::quiet_NaN();
    return (count * sumXY - sumX * sumY) / spread;
}

}  // namespace heliograph
