#include "server/request/camera.h"

#include "server/base/error.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace heliograph {

namespace {

using dvec3 = glm::dvec3;
constexpr double PI = 3.14159265358979323846;

std::string shown(vec3 v) {
    std::ostringstream text;
    text << "[" << v.x << ", " << v.y << ", " << v.z << "]";
    return text.str();
}

bool finite(vec3 v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

void checkFinite(const char* field, vec3 v) {
    if (!finite(v)) throw InputError(std::string("camera ") + field, shown(v), "three finite numbers");
}

/// Scaled by the largest component first: the square of 1e30 has no float and that of 1e200 no double.
dvec3 unit(vec3 v) {
    double largest = std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
    return glm::normalize(dvec3(v) / largest);
}

struct Axes {
    dvec3 forward, right, up;
};

/// False when `up` gives no direction beside `forward`.
bool axesOf(vec3 forward, vec3 up, Axes& axes) {
    axes.forward = unit(forward);
    axes.right = glm::cross(axes.forward, unit(up));
    double length = glm::length(axes.right);
    if (!(length > 1e-6)) return false;
    axes.right /= length;
    axes.up = glm::cross(axes.right, axes.forward);
    return true;
}

/// A direction across `forward`, nearest to +Y where that is one; else -Z (looking down, north is up).
vec3 uprightFor(vec3 forward) {
    Axes axes;
    vec3 up = axesOf(forward, vec3(0.0f, 1.0f, 0.0f), axes) ? vec3(0.0f, 1.0f, 0.0f) : vec3(0.0f, 0.0f, -1.0f);
    axesOf(forward, up, axes);
    return vec3(axes.up);
}

/// Uniform Catmull-Rom spline (E. Catmull, R. Rom, "A class of local interpolating splines", 1974).
dvec3 catmullRom(dvec3 p0, dvec3 p1, dvec3 p2, dvec3 p3, double t) {
    return 0.5 * (2.0 * p1 + t * ((p2 - p0) + t * ((2.0 * p0 - 5.0 * p1 + 4.0 * p2 - p3) + t * (3.0 * (p1 - p2) + p3 - p0))));
}

}  // namespace

Camera cameraFrom(const NamedCamera& named) { return {named.position, named.forward, named.up, named.fieldOfView}; }

Camera checkedCamera(const Camera& camera) {
    checkFinite("position", camera.position);
    checkFinite("forward", camera.forward);
    checkFinite("up", camera.up);
    if (camera.forward == vec3(0.0f)) throw InputError("camera forward", shown(camera.forward), "a direction other than zero");
    if (camera.up == vec3(0.0f)) throw InputError("camera up", shown(camera.up), "a direction other than zero");
    if (!(camera.fieldOfView >= 0.01f && camera.fieldOfView <= 179.0f)) {
        std::ostringstream found;
        found << camera.fieldOfView;
        throw InputError("camera fieldOfView", found.str(), "0.01 to 179 degrees");
    }
    Axes axes;
    if (!axesOf(camera.forward, camera.up, axes)) {
        throw InputError("camera up", shown(camera.up) + " is parallel to forward", "a direction across forward");
    }
    return {camera.position, vec3(axes.forward), vec3(axes.up), camera.fieldOfView};
}

Camera checkedCamera(const Camera& camera, const Scene& scene) {
    const Camera checked = checkedCamera(camera);
    const Bounds range = scene.cameraRange();
    if (glm::clamp(checked.position, range.low, range.high) != checked.position) {
        throw InputError("camera position", shown(checked.position), shown(range.low) + " to " + shown(range.high));
    }
    return checked;
}

ViewRay viewRay(const Camera& camera, double aspect, double x, double y) {
    const double half = std::tan(0.5 * static_cast<double>(camera.fieldOfView) * PI / 180.0);
    const dvec3 forward(camera.forward), up(camera.up), right = glm::cross(forward, up);
    return {dvec3(camera.position), forward + right * (half * aspect * (2.0 * x - 1.0)) + up * (half * (1.0 - 2.0 * y))};
}

KernelCamera kernelCamera(const Camera& camera, uvec2 resolution) {
    Axes axes;
    axesOf(camera.forward, camera.up, axes);
    double half = std::tan(0.5 * camera.fieldOfView * PI / 180.0);
    double aspect = static_cast<double>(resolution.x) / resolution.y;
    KernelCamera result{};
    result.origin = camera.position;
    result.forward = vec3(axes.forward);
    result.right = vec3(axes.right * (half * aspect));
    result.up = vec3(axes.up * half);
    result.pixelSpread = static_cast<float>(std::atan(2.0 * half / resolution.y));
    return result;
}

Camera cameraOnPath(const CameraPath& path, double share, float fieldOfView) {
    const auto count = static_cast<int64_t>(path.keys.size());
    if (count == 0) throw InputError("path " + path.name, "no keys", "at least 2");
    share = path.closed ? share - std::floor(share) : std::clamp(share, 0.0, 1.0);
    double at = share * static_cast<double>(path.closed ? count : count - 1);
    auto segment = static_cast<int64_t>(std::floor(at));
    if (!path.closed) segment = std::clamp<int64_t>(segment, 0, std::max<int64_t>(count - 2, 0));
    auto key = [&](int64_t i) -> const CameraPath::Key& {
        i = path.closed ? (i % count + count) % count : std::clamp<int64_t>(i, 0, count - 1);
        return path.keys[static_cast<size_t>(i)];
    };
    auto along = [&](vec3 CameraPath::Key::*point) {
        return catmullRom(dvec3(key(segment - 1).*point), dvec3(key(segment).*point), dvec3(key(segment + 1).*point),
                          dvec3(key(segment + 2).*point), at - static_cast<double>(segment));
    };
    dvec3 position = along(&CameraPath::Key::position);
    dvec3 view = along(&CameraPath::Key::target) - position;
    // Where the spline passes its own target any direction is as good; the key's own is kept in spirit by -Z.
    vec3 forward = glm::length(view) > 0.0 ? vec3(glm::normalize(view)) : vec3(0.0f, 0.0f, -1.0f);
    return checkedCamera({vec3(position), forward, uprightFor(forward), fieldOfView});
}

}  // namespace heliograph
