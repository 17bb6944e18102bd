#pragma once
// What the render loop of a view works on, and what it hands over.

#include "server/film/stats.h"
#include "server/pace/error_forecast.h"
#include "server/render/pass_renderer.h"
#include "server/request/effect_rules.h"
#include "server/request/loop_rules.h"

namespace heliograph {

/// A scene that a device holds, ready to be rendered.
struct ResidentScene {
    std::shared_ptr<const Scene> scene;
    std::shared_ptr<Renderer> renderer;
    std::vector<EffectReason> reasons;  // explainEffects of the scene
    EffectSet effects;                  // that it calls for
};

/// A picture that a viewer asked for.
struct PictureOrder {
    uint32_t number = 0;  // counts the viewer's orders
    PictureFormat format = PictureFormat::png;
    uint32_t viewer = 0;  // who asked for it
    bool operator==(const PictureOrder&) const = default;
};

/// A film worth looking at. The film may grow while it is developed, never change its request.
struct FinishedFrame {
    std::optional<PictureOrder> picture;  // nothing: a frame of the view
    std::shared_ptr<const Film> film;     // its locked functions alone: once let go of, the loop uses it again
    /// What is shown in the film's stead, linear RGB, row-major; null: the film as it is.
    std::shared_ptr<const std::vector<vec4>> denoised;
    uvec2 size{0, 0};  // of the film
    ViewRequest view;
    uint32_t generation = 0;
    uint32_t samples = 0;               // per pixel, in the mean
    double refined = 1.0;               // part of its cells that get more on the way to the error target
    bool final = false;                 // the sample target or the error target is reached
    bool errorReached = false;          // the error target, with fewer samples
    bool path = false;                  // part of a run along the camera path
    float sceneExposure = 0.0f;         // EV
    std::optional<float> autoExposure;  // EV that the picture asks for itself, where it is shown so
    bool fromFile = false;              // its scene: Scene::fromFile
    double inputSeconds = 0.0;          // from the input to the start of its first pass
    PassFigures figures;
    ErrorForecast forecast;
};

/// Where a viewer wants to know the depth.
struct FocusRequest {
    ViewRay ray;
    uint32_t inputId = 0;
    uint32_t viewer = 0;
};

/// Where a viewer wants to know what is there.
struct PickRequest {
    ViewRay ray;
    uint32_t id = 0;  // the viewer's own, comes back
    uint32_t viewer = 0;
};

/// Where frames go. Called from the loop's thread without any lock held; must not call the loop's destructor.
class FrameReceiver {
public:
    virtual ~FrameReceiver() = default;
    virtual Readiness readiness() = 0;
    /// Steps (pace/moving_scale.h) by which pictures of a moving view should be smaller, for the line.
    virtual uint32_t coarser() { return 0; }
    /// Pictures are not subject to credit, only to `busy`.
    virtual void take(FinishedFrame&& frame) = 0;
    /// A run along the path is over, or was asked to end before it began (no frames then).
    virtual void pathEnded(const FrameSummary& result) = 0;
    /// The depth that was asked for.
    virtual void focused(const FocusRequest& request, const DepthAnswer& answer) = 0;
    /// What is there, in the scene that was asked.
    virtual void picked(const PickRequest& request, const DepthAnswer& answer, const Scene& scene) = 0;
    /// The device failed; the loop rests until the next request or scene.
    virtual void failed(const std::string& what) = 0;
};

}  // namespace heliograph
