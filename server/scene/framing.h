#pragma once
// The view that a scene without a camera starts with: from one direction, as near as its vertices and the picture's shape allow.

#include "server/scene/scene.h"

namespace heliograph {

/// Share of the tighter side of the picture that the scene takes.
inline constexpr double FRAMED = 0.9;
/// Shape of a picture where nothing is known of it: width over height.
inline constexpr double USUAL_ASPECT = 16.0 / 9.0;

/// How far vertices reach, for views of that direction: notes every vertex, then answers for any opening angle.
class FramingWriter {
public:
    /// `center`: a point about which places are told, in the scene. The basis is that of `view`.
    FramingWriter(glm::dvec3 center, const NamedCamera& view);
    void add(glm::dvec3 vertex);
    /// What another writer of the same view has noted.
    void add(const FramingWriter& other);
    Framing framing() const;

private:
    glm::dvec3 center_, right_, up_, forward_;
    std::array<std::array<double, Framing::STEPS>, 4> reach_;
};

/// The camera from which `framing` takes FRAMED of the tighter side of a picture of that shape, in the middle, none of it cut.
/// `camera`: its direction and its field of view.
NamedCamera framed(const Framing& framing, NamedCamera camera, double aspect);

/// Where a viewer with such a picture starts: the scene's first camera, framed anew where no file names it. `aspect` > 0.
NamedCamera startCamera(const Scene& scene, double aspect);

}  // namespace heliograph
