#include "server/net/protocol.h"

#include "server/base/json_text.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

namespace heliograph {

namespace {

using nlohmann::json;

/// A value as it was found, short enough for one line.
std::string shown(const json& value) {
    std::string text = value.dump(-1, ' ', false, json::error_handler_t::replace);
    if (text.size() > 60) text = text.substr(0, 57) + "...";
    return text;
}

/// Reads the fields of one message; a refusal names `type.field`.
class Fields {
public:
    Fields(const json& message, std::string type) : message_(message), type_(std::move(type)) {}

    uint32_t uint(const char* name, uint32_t low = 0, uint32_t high = std::numeric_limits<uint32_t>::max()) const {
        const json& value = at(name);
        std::string allowed = "a whole number from " + std::to_string(low) + " to " + std::to_string(high);
        // A number with a fraction part of zero (1.0) is whole for JavaScript, and so it is here.
        if (!value.is_number()) refuse(name, shown(value), allowed);
        double number = value.get<double>();
        if (!(number >= low && number <= high) || number != std::floor(number)) refuse(name, shown(value), allowed);
        return static_cast<uint32_t>(number);
    }

    double number(const char* name) const {
        const json& value = at(name);
        if (!value.is_number() || !std::isfinite(value.get<double>())) refuse(name, shown(value), "a finite number");
        return value.get<double>();
    }

    bool boolean(const char* name) const {
        const json& value = at(name);
        if (!value.is_boolean()) refuse(name, shown(value), "true or false");
        return value.get<bool>();
    }

    std::string text(const char* name, size_t longest) const {
        const json& value = at(name);
        if (!value.is_string()) refuse(name, shown(value), "a string");
        if (value.get_ref<const std::string&>().size() > longest) {
            refuse(name, "a string of " + std::to_string(value.get_ref<const std::string&>().size()) + " bytes",
                   "at most " + std::to_string(longest));
        }
        return value.get<std::string>();
    }

    vec3 vector(const char* name) const {
        const json& value = at(name);
        vec3 result(0.0f);
        bool good = value.is_array() && value.size() == 3;
        for (int i = 0; good && i < 3; i++) {
            good = value[i].is_number() && std::isfinite(static_cast<float>(value[i].get<double>()));
            if (good) result[i] = static_cast<float>(value[i].get<double>());
        }
        if (!good) refuse(name, shown(value), "three finite numbers");
        return result;
    }

    const json& object(const char* name) const {
        const json& value = at(name);
        if (!value.is_object()) refuse(name, shown(value), "an object");
        return value;
    }

    bool isNull(const char* name) const {
        auto found = message_.find(name);
        return found == message_.end() || found->is_null();
    }

    [[noreturn]] void refuse(const std::string& name, const std::string& found, const std::string& allowed) const {
        throw InputError(type_ + "." + name, found, allowed);
    }

private:
    const json& at(const char* name) const {
        auto found = message_.find(name);
        if (found == message_.end()) refuse(name, "missing", "it must be there");
        return *found;
    }

    const json& message_;
    std::string type_;
};

void read(const Fields& fields, CameraMessage& message) {
    message.inputId = fields.uint("inputId");
    message.moving = fields.boolean("moving");
    Camera camera{fields.vector("position"), fields.vector("forward"), fields.vector("up"),
                  static_cast<float>(fields.number("fieldOfView"))};
    message.camera = checkedCamera(camera);
}

void read(const Fields& fields, SettingsMessage& message) { message = {fields.uint("inputId"), fields.object("values")}; }

void read(const Fields& fields, ResolutionMessage& message) {
    message.inputId = fields.uint("inputId");
    message.size = uvec2(fields.uint("width", MIN_SIDE, MAX_SIDE), fields.uint("height", MIN_SIDE, MAX_SIDE));
    uint64_t pixels = static_cast<uint64_t>(message.size.x) * message.size.y;
    if (pixels > MAX_PIXELS) {
        fields.refuse("width x height", std::to_string(pixels) + " pixels", "at most " + std::to_string(MAX_PIXELS));
    }
}

void read(const Fields& fields, SceneMessage& message) { message.name = fields.text("name", SCENE_NAME_LIMIT); }

/// A time that a viewer may leave out.
std::optional<double> milliseconds(const Fields& fields, const char* name) {
    if (fields.isNull(name)) return std::nullopt;
    const double ms = fields.number(name);
    if (ms < 0.0 || ms > MAX_PRESENTED_MS)
        fields.refuse(name, nlohmann::json(ms).dump(), "0 to " + std::to_string(MAX_PRESENTED_MS) + ", or null");
    return ms;
}

void read(const Fields& fields, AckMessage& message) {
    message.frameId = fields.uint("frameId");
    message.presentedMs = milliseconds(fields, "presentedMs");
    message.shownMs = milliseconds(fields, "shownMs");
    if (!fields.isNull("undecodable")) message.undecodable = fields.boolean("undecodable");
}

void read(const Fields& fields, PictureMessage& message) {
    const std::string format = fields.text("format", 16);
    if (format == "png") message.format = PictureFormat::png;
    else if (format == "exr") message.format = PictureFormat::exr;
    else if (format == "jpg") message.format = PictureFormat::jpg;
    else fields.refuse("format", shown(format), "png, exr or jpg");
}

void read(const Fields& fields, PathMessage& message) { message.playing = fields.boolean("playing"); }
void read(const Fields& fields, PingMessage& message) {
    message.time = fields.number("time");
    message.roundTripMs = milliseconds(fields, "roundTripMs");
}
void read(const Fields& fields, TokenMessage& message) { message.token = fields.text("token", TOKEN_LIMIT); }
void read(const Fields&, EffectCostsMessage&) {}

void read(const Fields& fields, AccuracyMessage& message) {
    message.seconds = fields.number("seconds");
    if (message.seconds != 0.0 && (message.seconds < MIN_SWEEP_SECONDS || message.seconds > MAX_SWEEP_SECONDS)) {
        fields.refuse("seconds", nlohmann::json(message.seconds).dump(),
                      "0, or " + std::to_string(MIN_SWEEP_SECONDS) + " to " + std::to_string(MAX_SWEEP_SECONDS));
    }
}

/// A place in the picture.
double share(const Fields& fields, const char* name) {
    const double value = fields.number(name);
    if (value < 0.0 || value > 1.0) fields.refuse(name, nlohmann::json(value).dump(), "0 to 1");
    return value;
}

void read(const Fields& fields, FocusMessage& message) {
    message = {fields.uint("inputId"), share(fields, "x"), share(fields, "y")};
}

void read(const Fields& fields, PickMessage& message) { message = {fields.uint("id"), share(fields, "x"), share(fields, "y")}; }

void read(const Fields& fields, WatchMessage& message) {
    message.inputId = fields.uint("inputId");
    if (!fields.isNull("view")) message.view = fields.text("view", VIEW_ID_LIMIT);
    if (!fields.isNull("key")) message.key = fields.text("key", VIEW_ID_LIMIT);
}

void read(const Fields& fields, DriveMessage& message) {
    message.inputId = fields.uint("inputId");
    if (!fields.isNull("viewer")) message.viewer = fields.uint("viewer");
    if (!fields.isNull("refuse")) message.refuse = fields.boolean("refuse");
}

void read(const Fields& fields, ClientMessage& message) {
    if (!fields.isNull("visible")) message.visible = fields.boolean("visible");
    if (!fields.isNull("exact")) message.exact = fields.boolean("exact");
    if (!fields.isNull("vp9")) message.vp9 = fields.boolean("vp9");
    if (!fields.isNull("h264")) message.h264 = fields.boolean("h264");
}

/// The alternatives of ViewerMessage by their TYPE.
template <typename Variant>
struct Types;
template <typename... Message>
struct Types<std::variant<Message...>> {
    static std::string names() {
        std::string names;
        ((names += (names.empty() ? "" : ", ") + std::string(Message::TYPE)), ...);
        return names;
    }
    /// False for a type that is none of them.
    static bool read(const std::string& type, const Fields& fields, std::variant<Message...>& message) {
        auto readAs = [&](auto& m) {
            heliograph::read(fields, m);
            return true;
        };
        return ((type == Message::TYPE && readAs(message.template emplace<Message>())) || ...);
    }
};
using KnownTypes = Types<ViewerMessage>;

/// The input id of a message that may be wrong in other ways.
std::optional<uint32_t> inputIdOf(const json& message) {
    auto found = message.find("inputId");
    if (found == message.end() || !found->is_number_unsigned()) return std::nullopt;
    uint64_t id = found->get<uint64_t>();
    if (id > std::numeric_limits<uint32_t>::max()) return std::nullopt;
    return static_cast<uint32_t>(id);
}

}  // namespace

ViewerMessage parseViewerMessage(std::string_view text) {
    json message;
    if (jsonExtent(text, MESSAGE_DEPTH).depth > MESSAGE_DEPTH) {
        throw MessageError(InputError("message", "JSON nested deeper than " + std::to_string(MESSAGE_DEPTH), "one JSON object"),
                           "", std::nullopt);
    }
    try {
        message = json::parse(text);
    } catch (const json::exception& e) {
        // The library's message may quote bytes of the text; the position is all that helps.
        std::string found = "not JSON";
        if (auto* parse = dynamic_cast<const json::parse_error*>(&e)) found += " at byte " + std::to_string(parse->byte);
        throw MessageError(InputError("message", found, "one JSON object"), "", std::nullopt);
    }
    if (!message.is_object()) {
        throw MessageError(InputError("message", shown(message), "one JSON object"), "", std::nullopt);
    }
    auto type = message.find("type");
    if (type == message.end() || !type->is_string()) {
        throw MessageError(InputError("type", type == message.end() ? "missing" : shown(*type), KnownTypes::names()), "",
                           std::nullopt);
    }
    const std::string& name = type->get_ref<const std::string&>();
    try {
        ViewerMessage result;
        if (KnownTypes::read(name, Fields(message, name), result)) return result;
        throw InputError("type", shown(*type), KnownTypes::names());
    } catch (const InputError& e) {
        throw MessageError(e, name.substr(0, 60), inputIdOf(message));
    }
}

namespace {

template <typename T>
void put(std::span<uint8_t> bytes, size_t offset, T value) {
    for (size_t i = 0; i < sizeof(T); i++) bytes[offset + i] = static_cast<uint8_t>(value >> (8 * i));
}

template <typename T>
T get(std::span<const uint8_t> bytes, size_t offset) {
    T value = 0;
    for (size_t i = 0; i < sizeof(T); i++) value = static_cast<T>(value | static_cast<T>(bytes[offset + i]) << (8 * i));
    return value;
}

constexpr size_t SEND_MICROS_OFFSET = 52;

}  // namespace

void writeFrameHeader(const FrameHeader& header, std::span<uint8_t, FRAME_HEADER_BYTES> bytes) {
    bytes[0] = 'H';
    bytes[1] = 'G';
    bytes[2] = static_cast<uint8_t>(header.kind);
    bytes[3] = static_cast<uint8_t>(header.codec);
    put<uint16_t>(bytes, 4, FRAME_HEADER_BYTES);
    bytes[6] = header.flags;
    bytes[7] = header.quality;
    put<uint32_t>(bytes, 8, header.frameId);
    put<uint32_t>(bytes, 12, header.inputId);
    put<uint32_t>(bytes, 16, header.generation);
    put<uint16_t>(bytes, 20, static_cast<uint16_t>(header.size.x));
    put<uint16_t>(bytes, 22, static_cast<uint16_t>(header.size.y));
    put<uint16_t>(bytes, 24, static_cast<uint16_t>(header.fullSize.x));
    put<uint16_t>(bytes, 26, static_cast<uint16_t>(header.fullSize.y));
    put<uint32_t>(bytes, 28, header.samples);
    put<uint32_t>(bytes, 32, std::bit_cast<uint32_t>(header.relativeError));
    put<uint32_t>(bytes, 36, header.renderMicros);
    put<uint32_t>(bytes, 40, header.developMicros);
    put<uint32_t>(bytes, 44, header.encodeMicros);
    put<uint32_t>(bytes, 48, header.inputMicros);
    put<uint32_t>(bytes, SEND_MICROS_OFFSET, header.sendMicros);
    put<uint32_t>(bytes, 56, header.payloadBytes);
    put<uint32_t>(bytes, 60, header.devices);
}

void writePartHeader(const FrameHeader& header, const PartPlace& place,
                     std::span<uint8_t, FRAME_HEADER_BYTES + PART_PLACE_BYTES> bytes) {
    writeFrameHeader(header, bytes.first<FRAME_HEADER_BYTES>());
    put<uint16_t>(bytes, 4, FRAME_HEADER_BYTES + PART_PLACE_BYTES);
    const uint32_t fields[] = {place.origin.x, place.origin.y, place.size.x, place.size.y};
    for (size_t i = 0; i < 4; i++) put<uint16_t>(bytes, FRAME_HEADER_BYTES + 2 * i, static_cast<uint16_t>(fields[i]));
}

FrameHeader readFrameHeader(std::span<const uint8_t> bytes) {
    if (bytes.size() < FRAME_HEADER_BYTES) {
        throw InputError("frame", std::to_string(bytes.size()) + " bytes", "a header of 64 and the payload");
    }
    if (bytes[0] != 'H' || bytes[1] != 'G') throw InputError("frame magic", "other bytes", "HG");
    size_t length = get<uint16_t>(bytes, 4);
    if (length < FRAME_HEADER_BYTES || length > bytes.size()) {
        throw InputError("frame header length", std::to_string(length), "64 up to the size of the message");
    }
    FrameHeader header;
    header.kind = static_cast<FrameKind>(bytes[2]);
    header.codec = static_cast<FrameCodec>(bytes[3]);
    header.flags = bytes[6];
    header.quality = bytes[7];
    header.frameId = get<uint32_t>(bytes, 8);
    header.inputId = get<uint32_t>(bytes, 12);
    header.generation = get<uint32_t>(bytes, 16);
    header.size = uvec2(get<uint16_t>(bytes, 20), get<uint16_t>(bytes, 22));
    header.fullSize = uvec2(get<uint16_t>(bytes, 24), get<uint16_t>(bytes, 26));
    header.samples = get<uint32_t>(bytes, 28);
    header.relativeError = std::bit_cast<float>(get<uint32_t>(bytes, 32));
    header.renderMicros = get<uint32_t>(bytes, 36);
    header.developMicros = get<uint32_t>(bytes, 40);
    header.encodeMicros = get<uint32_t>(bytes, 44);
    header.inputMicros = get<uint32_t>(bytes, 48);
    header.sendMicros = get<uint32_t>(bytes, SEND_MICROS_OFFSET);
    header.payloadBytes = get<uint32_t>(bytes, 56);
    header.devices = get<uint32_t>(bytes, 60);
    return header;
}

void stampSendTime(std::span<uint8_t, FRAME_HEADER_BYTES> header, uint32_t micros) {
    put<uint32_t>(header, SEND_MICROS_OFFSET, micros);
}

}  // namespace heliograph
