#include "tests/load/load_viewer.h"

#include <algorithm>
#include <cmath>

namespace heliograph::load {

namespace {

using nlohmann::json;

json numbers(vec3 v) { return json::array({v.x, v.y, v.z}); }

vec3 vectorOf(const json& value) { return {value.at(0).get<float>(), value.at(1).get<float>(), value.at(2).get<float>()}; }

vec3 turned(vec3 v, float angle) {
    const float c = std::cos(angle), s = std::sin(angle);
    return {c * v.x + s * v.z, v.y, c * v.z - s * v.x};
}

// Messages that a server has to refuse, or to bear, without a word to anybody else.
const char* const ATTACKS[] = {
    R"({"type":"camera","inputId":1,"position":[1e19,0,0],"forward":[0,0,-1],"up":[0,1,0],"fieldOfView":60,"moving":true})",
    R"({"type":"camera","inputId":2,"position":[1e308,1e308,1e308],"forward":[0,0,-1],"up":[0,1,0],"fieldOfView":60,"moving":true})",
    R"({"type":"camera","inputId":3,"position":[0,0,0],"forward":[0,0,0],"up":[0,0,0],"fieldOfView":1e-30,"moving":false})",
    R"({"type":"resolution","inputId":4,"width":8192,"height":8192})",
    R"({"type":"settings","inputId":5,"values":{"samples":1e99,"nothing":true}})",
    R"({"type":"ack","frameId":4294967295,"presentedMs":1.7e308})",
    R"({"type":"focus","inputId":6,"x":2,"y":-1})",
    R"({"type":"nothing"})",
    R"([[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[]]]]]]]]]]]]]]]]]]]]]]]]]]]]]]]]]]]]]]]])",
    R"({"type":)",
};

}  // namespace

LoadViewer::LoadViewer(const LoadPlan& plan, uint32_t index)
    : plan_(plan), index_(index), script_(scriptFor(plan, index)), random_(plan.seed * 7919 + index + 1) {}

void LoadViewer::fault(const std::string& what) {
    faultCount_++;
    if (faults_.size() < 8 && std::find(faults_.begin(), faults_.end(), what) == faults_.end()) faults_.push_back(what);
}

void LoadViewer::opened(double) {
    outgoing_.clear();
    ready_ = askedToWatch_ = watches_ = false;
    ownView_.clear();
    frameId_.reset();
    inputAt_.clear();
    inputId_ = shownInput_ = 0;
    lastInputShownAt_ = -1.0;
    if (!plan_.token.empty()) say({{"type", "token"}, {"token", plan_.token}});
    video_.reset();
    if (plan_.vp9) say({{"type", "client"}, {"vp9", true}});
    if (script_ == Script::watch) return;  // the size is that of who drives
    say({{"type", "resolution"}, {"width", plan_.width}, {"height", plan_.height}, {"inputId", ++inputId_}});
    if (plan_.vp9) say({{"type", "settings"}, {"inputId", ++inputId_}, {"values", {{"codec", "vp9"}}}});
    if (!plan_.scene.empty()) say({{"type", "scene"}, {"name", plan_.scene}});
}

void LoadViewer::watch(const std::string& view) {
    if (script_ != Script::watch || askedToWatch_ || ownView_.empty() || view.empty()) return;
    askedToWatch_ = true;
    say({{"type", "watch"}, {"view", view}, {"inputId", ++inputId_}});
}

void LoadViewer::closed(double) {
    reconnects_++;
    ready_ = false;
}

void LoadViewer::takeText(const std::string& text, double now) {
    try {
        const json message = json::parse(text);
        const std::string type = message.at("type");
        if (type == "hello") schema_ = message.at("schema"), ownView_ = message.value("view", "");
        if (type == "watching") watches_ = !message.at("drives").get<bool>();
        if (type == "error") {
            refusals_++;
            if (script_ != Script::attacker && script_ != Script::settings)
                fault("the server says: " + message.value("message", ""));
        }
        if (type != "scene" || watches_ != (script_ == Script::watch)) return;
        if (message.at("state") == "failed") fault("scene: " + message.value("what", ""));
        if (message.at("state") != "ready" || (!plan_.scene.empty() && message.at("name") != plan_.scene)) return;
        const json& camera = message.at("camera");
        start_.position = vectorOf(camera.at("position"));
        start_.forward = vectorOf(camera.at("forward"));
        start_.up = vectorOf(camera.at("up"));
        start_.fieldOfView = camera.at("fieldOfView");
        low_ = vectorOf(message.at("bounds").at("low"));
        high_ = vectorOf(message.at("bounds").at("high"));
        ready_ = true;
        begun_ = nextInput_ = now;
        if (script_ == Script::path) say({{"type", "path"}, {"playing", true}});
    } catch (const json::exception& error) {
        fault(std::string("a message that cannot be read: ") + error.what());
    }
}

void LoadViewer::takeBinary(std::span<const uint8_t> bytes, double now) {
    FrameHeader header;
    try {
        header = readFrameHeader(bytes);
    } catch (const InputError& error) {
        return fault(error.what());
    }
    if (header.kind != FrameKind::frame) return;
    const size_t length = bytes[4] | bytes[5] << 8;
    if (length + header.payloadBytes != bytes.size()) return fault("a frame whose header and length differ");
    const std::span<const uint8_t> picture = bytes.subspan(length);
    const std::string wrong = header.codec == FrameCodec::vp9
                                  ? video_.fault(picture, header.size.x, header.size.y, (header.flags & FRAME_KEY) != 0)
                                  : jpegFault(picture, header.size.x, header.size.y);
    if (!wrong.empty()) fault(wrong);
    if (header.inputId < shownInput_) fault("an older input after a newer one");
    if (header.inputId > inputId_ && script_ != Script::attacker) fault("an input that was never sent");
    if (frameId_ && header.frameId <= *frameId_) fault("a frame that is not newer than the one before");
    if (frameId_ && header.frameId > *frameId_ + 1) dropped_ += header.frameId - *frameId_ - 1;
    frameId_ = header.frameId;

    Shown shown{.at = now,
                .render = header.renderMicros * 1e-3f,
                .encode = (header.developMicros + header.encodeMicros) * 1e-3f,
                .input = header.inputMicros * 1e-3f,
                .queue = header.sendMicros * 1e-3f,
                .bytes = header.payloadBytes};
    json presented = nullptr;
    const auto sent = inputAt_.find(header.inputId);
    if (header.inputId > shownInput_ && sent != inputAt_.end()) {
        shown.motionToPhoton = static_cast<float>((now - sent->second) * 1e3);
        presented = shown.motionToPhoton;
        std::erase_if(inputAt_, [&](const auto& entry) { return entry.first <= header.inputId; });
    }
    if (header.inputId == inputId_ && lastInputShownAt_ < lastInputAt_) lastInputShownAt_ = now;
    shownInput_ = std::max(shownInput_, header.inputId);
    shown_.push_back(shown);
    say({{"type", "ack"}, {"frameId", header.frameId}, {"presentedMs", presented}});
}

Camera LoadViewer::cameraAt(double now) const {
    Camera camera = start_;
    const vec3 centre = 0.5f * (low_ + high_);
    const float t = static_cast<float>(now - begun_);
    if (script_ == Script::walk) {
        const float extent = std::max(1e-3f, std::max({high_.x - low_.x, high_.y - low_.y, high_.z - low_.z}));
        std::uniform_real_distribution<float> step(-1.0f, 1.0f);
        camera.position += vec3(step(random_), 0.2f * step(random_), step(random_)) * (0.02f * extent);
        const float look = 0.3f * step(random_);
        camera.forward = turned(camera.forward, look);
        camera.up = turned(camera.up, look);
        return camera;
    }
    const float angle = 0.4f * t + 0.7f * static_cast<float>(index_);
    camera.position = centre + turned(start_.position - centre, angle);
    camera.forward = turned(start_.forward, angle);
    camera.up = turned(start_.up, angle);
    return camera;
}

void LoadViewer::sendCamera(double now) {
    const Camera camera = cameraAt(now);
    inputAt_[++inputId_] = now;
    lastInputAt_ = now;
    say({{"type", "camera"},
         {"inputId", inputId_},
         {"position", numbers(camera.position)},
         {"forward", numbers(camera.forward)},
         {"up", numbers(camera.up)},
         {"fieldOfView", camera.fieldOfView},
         {"moving", true}});
}

void LoadViewer::sendSettings(double now) {
    if (!schema_.is_array() || schema_.empty()) return;
    const json& row = schema_[random_() % schema_.size()];
    const std::string name = row.value("name", ""), type = row.value("type", "");
    // What would ask for another device or for minutes of work is another test.
    if (name == "fieldOfView" || name == "cameraPath" || name == "samples" || type == "choice") return;
    json value = type == "bool" ? json(random_() % 2 == 0) : row.at("default");
    if (type != "bool" && random_() % 2 == 0) value = row.at("low");
    inputAt_[++inputId_] = now;
    lastInputAt_ = now;
    say({{"type", "settings"}, {"inputId", inputId_}, {"values", {{name, value}}}});
}

void LoadViewer::attack() { outgoing_.push_back(ATTACKS[random_() % std::size(ATTACKS)]); }

void LoadViewer::tick(double now, bool inputs) {
    if (!ready_ || !inputs || script_ == Script::idle || script_ == Script::path || script_ == Script::watch ||
        now < nextInput_)
        return;
    nextInput_ = std::max(nextInput_ + 1.0 / plan_.inputsPerSecond, now);
    if (script_ == Script::attacker) attack();
    else if (script_ == Script::settings) sendSettings(now);
    else sendCamera(now);
}

std::optional<std::string> LoadViewer::nextMessage() {
    if (outgoing_.empty()) return std::nullopt;
    std::string message = std::move(outgoing_.front());
    outgoing_.pop_front();
    return message;
}

std::optional<double> LoadViewer::lastInputMs() const {
    if (lastInputAt_ == 0.0 || lastInputShownAt_ < lastInputAt_) return std::nullopt;
    return (lastInputShownAt_ - lastInputAt_) * 1e3;
}

}  // namespace heliograph::load
