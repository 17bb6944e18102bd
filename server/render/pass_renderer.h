#pragma once
// Passes: one sample for every pixel of a film. Frames of viewers, pictures, measurements and commands are all rendered here.

#include "server/film/film.h"
#include "server/film/partition.h"
#include "server/render/renderer.h"
#include "server/render/turns.h"

#include <map>

namespace heliograph {

/// What passes cost; those before are added up.
struct PassFigures {
    uint32_t passes = 0;         // finished
    double renderSeconds = 0.0;  // wall time of all of them, waiting for turns left out
    double lastPassSeconds = 0.0;
    double coreSeconds = 0.0;               // processor time that the device says it took
    RayCounts rays;                         // all passes
    RayCounts lastRays;                     // the last pass
    std::map<std::string, uint64_t> tiles;  // by device
    uint64_t nonfiniteSamples = 0;
    uint32_t devices = 0;     // bit set of docs/reference/protocol.md: 1 embree, 2 vulkan, 4 raster, 8 any other
    ScheduleReport schedule;  // of the last pass
    std::shared_ptr<const Partition> partition;  // of the last pass, if the settings ask for it
};

/// What is to be rendered where.
struct Pass {
    Renderer& renderer;  // holds the scene
    const FrameRequest& request;
    Film& film;                // of the request's size and generation
    ViewMemory& view;          // of the request's view
    uint32_t firstSample = 0;  // samples that every pixel has
    std::stop_token stop = {};
    std::function<void(double share)> progress = {};  // of this pass; called from the device's threads, one at a time
    Urgency urgency = Urgency::finer;
    /// Gives a sample to these cells of the film alone (Film::tilesFor), whatever they have; null: all, which have `firstSample`.
    const std::vector<bool>* cells = nullptr;
};

class PassRenderer {
public:
    /// Passes take turns with those of others, a slice of tiles a turn.
    explicit PassRenderer(Turns& turns) : turns_(&turns) {}
    /// Passes have the device for themselves.
    PassRenderer() = default;

    /// Waits for a turn. Nothing when `stop` is asked for first.
    std::optional<Turns::Turn> take(std::stop_token stop, Urgency urgency) {
        return turns_->take(account_, std::move(stop), urgency);
    }
    /// Renders the pass; `turn` is its first one, if it was taken already. False when `stop` was asked for first: the film then
    /// holds some of the pass, which a later one continues. Adds to the figures what the film took, in either case. Throws what
    /// the device throws, and std::runtime_error when it leaves tiles out or memory runs out.
    bool render(const Pass& pass, PassFigures& figures, std::optional<Turns::Turn> turn = std::nullopt);
    /// The same for a pass that tells nothing of what the picture's passes cost, as of its guides.
    bool renderBeside(const Pass& pass, PassFigures& figures);
    /// Another scene: its tiles take another time.
    void forget() { secondsPerPixel_ = workerSecondsPerPixel_ = 0.0; }
    Turns::Used used() const { return turns_->used(account_); }
    /// Seconds for which it has had the device in the turn in progress.
    std::optional<double> held() const { return turns_->held(account_); }

private:
    void forgetWhatNoLongerHolds(const FrameRequest& request);
    uvec2 cellFor(uvec2 wanted) const;
    size_t tilesOfTurn(size_t left, uint32_t workers, uvec2 cell) const;
    std::vector<Tile> renderSlice(const Pass& pass, std::span<const Tile> tiles, PassFigures& figures, Partition* partition);

    Turns* turns_ = nullptr;
    Settings measuredWith_;  // what acts on the film in the pass before
    EffectSet measuredEffects_;
    Turns::Account account_;
    bool slices_ = false;                 // the pass in work is cut into slices
    uint64_t donePixels_ = 0;             // of the pass in work
    double secondsPerPixel_ = 0.0;        // wall time; 0: not known yet
    double workerSecondsPerPixel_ = 0.0;  // thread time, whatever else the processors do
};

}  // namespace heliograph
