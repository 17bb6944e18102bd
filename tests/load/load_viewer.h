#pragma once
// One viewer of a load test, without its socket: what it says, and whether what it hears is right. Every picture has to be
// whole, of the size asked for, newer than the one before and never of an older input.

#include "server/net/protocol.h"
#include "tests/load/load_plan.h"
#include "tests/load/picture_fault.h"

#include <nlohmann/json.hpp>

#include <deque>
#include <random>
#include <string>
#include <unordered_map>
#include <vector>

namespace heliograph::load {

/// One picture as it was shown. Milliseconds; `motionToPhoton` negative where it shows no new input.
struct Shown {
    double at = 0.0;  // seconds since the test began
    float motionToPhoton = -1.0f;
    float render = 0.0f, encode = 0.0f, input = 0.0f, queue = 0.0f;
    uint32_t bytes = 0;
};

class LoadViewer {
public:
    LoadViewer(const LoadPlan& plan, uint32_t index);

    /// The connection has opened (again).
    void opened(double now);
    /// It has ended without having been asked to.
    void closed(double now);
    void takeText(const std::string& text, double now);
    void takeBinary(std::span<const uint8_t> bytes, double now);
    /// Says what the script says at this time. `inputs`: false in the end, when only the answer to the last input is awaited.
    void tick(double now, bool inputs);
    /// A viewer that watches asks for this view, once it has been greeted; an empty id is not known yet.
    void watch(const std::string& view);
    /// The id of its own view; empty until it has been greeted.
    const std::string& ownView() const { return ownView_; }
    /// The next message for the server.
    std::optional<std::string> nextMessage();

    bool ready() const { return ready_; }
    /// Shows its last input (an idle viewer: any picture).
    bool rested() const { return ready_ && !shown_.empty() && shownInput_ == inputId_; }
    /// Milliseconds from the last input to the picture that showed it; none yet: nothing.
    std::optional<double> lastInputMs() const;

    Script script() const { return script_; }
    const std::vector<Shown>& shown() const { return shown_; }
    uint64_t dropped() const { return dropped_; }
    uint64_t refusals() const { return refusals_; }
    uint64_t reconnects() const { return reconnects_; }
    /// What was wrong, each kind of fault once.
    const std::vector<std::string>& faults() const { return faults_; }
    uint64_t faultCount() const { return faultCount_; }

private:
    void fault(const std::string& what);
    void say(const nlohmann::json& message) { outgoing_.push_back(message.dump()); }
    void sendCamera(double now);
    void sendSettings(double now);
    void attack();
    Camera cameraAt(double now) const;

    const LoadPlan& plan_;
    Vp9Decoder video_;
    uint32_t index_;
    Script script_;
    mutable std::minstd_rand random_;
    std::deque<std::string> outgoing_;
    bool ready_ = false;
    std::string ownView_;
    bool askedToWatch_ = false, watches_ = false;
    Camera start_;
    vec3 low_{0.0f}, high_{0.0f};
    nlohmann::json schema_;
    double begun_ = 0.0, nextInput_ = 0.0, lastInputAt_ = 0.0, lastInputShownAt_ = -1.0;
    uint32_t inputId_ = 0, shownInput_ = 0;
    std::optional<uint32_t> frameId_;
    std::unordered_map<uint32_t, double> inputAt_;
    std::vector<Shown> shown_;
    std::vector<std::string> faults_;
    uint64_t faultCount_ = 0, dropped_ = 0, refusals_ = 0, reconnects_ = 0;
};

}  // namespace heliograph::load
