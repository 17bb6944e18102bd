#include "server/operations/serve_options.h"

#include "server/base/error.h"
#include "server/base/log.h"
#include "server/net/listen/listen_address.h"
#include "server/request/settings.h"

#include <algorithm>
#include <charconv>
#include <cstdio>

namespace heliograph {

namespace {

using O = ServeOptions;

void checkListen(const std::string& text) { parseListenAddress(text); }
void checkMode(const std::string& text) { parseSocketMode(text); }
void checkSetting(const std::string& text) { Settings().setFromText(text); }
void checkName(const std::string& text) {
    if (text.empty()) throw InputError("", "empty", "a name");
}

const OptionRow OPTION_ROWS[] = {
    {"scene", &O::scene, "SCENE", "courtyard, cathedral, glass, cornell, or a .gltf, .glb or .obj file", false, 0, 0,
     checkName},
    {"listen", &O::listen, "HOST:PORT|unix:/PATH",
     "Address and port, port 0 takes a free one; or a unix socket. May be given several times. Anything but this\nmachine's "
     "own "
     "addresses needs --token-file or --insecure. Sockets of systemd (LISTEN_FDS) are listened on, too, and\ninstead of the "
     "default",
     false, 0, 0, checkListen},
    {"socket-mode", &O::socketMode, "OCTAL", "File mode of unix sockets", false, 0, 0, checkMode},
    {"devices", &O::devices, "auto|LIST",
     "What viewers may render with: auto for all that is here, or names of the setting device below\nwith commas between, the "
     "first of which is where they start",
     false, 0, 0, checkName},
    {"environment", &O::environment, "FILE",
     "Lat-long image (HDR, EXR, JPG, PNG) that surrounds every scene instead of its own surroundings"},
    {"set", &O::settings, "KEY=VALUE", "What viewers start with; may be given several times", true, 0, 0, checkSetting},
    {"token-file", &O::tokenFile, "FILE",
     "File whose first line is the secret that viewers have to know (open the page with #token=SECRET)", true},
    {"admin-token-file", &O::adminTokenFile, "FILE",
     "File whose first line is the secret of admins: over /admin they list viewers, disconnect one, open scenes\nand let "
     "nobody else in. Without it there are none",
     true},
    {"insecure", &O::insecure, "", "Serve other machines without a token"},
    {"tls-cert", &O::certificate, "FILE", "Certificate for https (PEM)", true},
    {"tls-key", &O::key, "FILE", "Its key (PEM)", true},
    {"client", &O::client, "DIR", "Folder of the built browser client"},
    {"scenes", &O::scenes, "DIR",
     "Folder whose .gltf, .glb and .obj files, also in its folders, are offered beside the others"},
    {"uploads", &O::uploads, "DIR",
     "Folder for the files that viewers drop on the page: models and surroundings, private to who knows their name, and\ngone "
     "with the server. Without it nobody brings files"},
    {"upload-size", &O::uploadMib, "MIB", "The largest upload", false, 1, 16384},
    {"upload-quota", &O::uploadQuotaMib, "MIB",
     "Room for all uploads. Where it is full, those go that nobody has opened for an hour", false, 1, 1u << 20},
    {"upload-files", &O::uploadFiles, "N", "Files of one upload", false, 1, 10000},
    {"upload-seconds", &O::uploadSeconds, "SECONDS", "That one upload may take", false, 10, 86400},
    {"uploads-per-address", &O::uploadsPerAddress, "N", "Uploads of one address at one time, of four in all", false, 1, 4},
    {"upload-rate", &O::uploadRateKib, "KIB",
     "KiB a second that an upload has to bring, in each 20 seconds of it; 0: as slow as it likes", false, 0, 1024},
    {"allow-origin", &O::origins, "URL", "Another origin whose pages may connect, as https://example.org", true, 0, 0,
     checkName},
    {"max-viewers", &O::maxViewers, "N", "Viewers at once", true, 1, 1000},
    {"max-guests", &O::maxGuests, "N", "Viewers that have not said the token yet; the oldest goes", false, 1, 1000},
    {"spare-connections", &O::spareConnections, "N",
     "Connections beside those of viewers, 16 more for health checks; the oldest idle one goes", false, 0, 10000},
    {"spare-connections-per-address", &O::spareConnectionsPerAddress, "N", "The same of one address", false, 0, 10000},
    {"least-rate", &O::leastRate, "FPS",
     "Frames a second that every viewer shall have: another one is refused (503) when, by the frame\ntimes measured, it would "
     "see fewer. 0 lets everybody in; the first four always come in",
     false, 0, 1000},
    {"most-samples", &O::mostSamples, "N", "Samples a pixel that a viewer may set", false, 1, 65536},
    {"most-rays", &O::mostRays, "N", "Shadow, AO and fog rays a visible point that a viewer may set", false, 1, 256},
    {"most-bounces", &O::mostBounces, "N", "Reflections and refractions in a row that a viewer may set", false, 0, 31},
    {"film-memory", &O::filmMemoryMib, "MIB",
     "Memory for the pictures of all viewers, at most half of what the machine or the control group\nhas; 0 takes that half",
     false, 0, 1u << 24},
    {"keep-views", &O::keepViewSeconds, "SECONDS",
     "How long the view of a viewer whose line broke is kept for when it comes back, 8 views at most; 0 keeps none", false, 0,
     3600},
    {"watchdog", &O::watchdogSeconds, "SECONDS",
     "A part of the server that has not moved for so long is named in the log and by /readyz, and the\nservice manager is not "
     "told any more that all is well",
     true, 2, 3600},
    {"pool", &O::pool, "URL",
     "NATS broker whose render nodes (heliograph node) work along, as nats://HOST:4222 or tls://HOST:4222; several\nof a "
     "cluster with commas between"},
    {"pool-secret", &O::poolSecret, "FILE", "File whose first line is USER:PASSWORD or the token for the broker"},
    {"pool-ca", &O::poolCa, "FILE", "Certificate of who signed the broker's (PEM); else those of the system"},
    {"pool-cert", &O::poolCertificate, "FILE", "Certificate of this machine for the broker (PEM)"},
    {"pool-key", &O::poolKey, "FILE", "Its key (PEM)"},
    {"pool-insecure", &O::poolInsecure, "", "Use a broker on another machine that lets everybody in"},
    {"log-level", &O::logLevel, "LEVEL", "trace, debug, info, warn, error or off", true, 0, 0, checkLogLevel},
    {"log-json", &O::logJson, "", "Log as JSON, one object a line", true},
};

std::string shown(const GivenValue& given) {
    std::string text;
    for (const std::string& one : given.texts) text += (text.empty() ? "" : ", ") + one;
    if (given.texts.size() != 1) return "a list of " + std::to_string(given.texts.size()) + " values";
    return given.kind == GivenValue::Kind::text || given.kind == GivenValue::Kind::word ? "\"" + text + "\"" : text;
}

[[noreturn]] void refuse(const GivenValue& given, const std::string& allowed) {
    throw InputError(given.source, shown(given), allowed);
}

/// The one text of a value that is no list; only of the kind or of a word.
const std::string& single(const GivenValue& given, GivenValue::Kind kind, const std::string& allowed) {
    if (given.texts.size() != 1 || (given.kind != kind && given.kind != GivenValue::Kind::word)) refuse(given, allowed);
    return given.texts.front();
}

/// The check's own answer, with the source of the value before it.
void checkText(const OptionRow& row, const GivenValue& given, const std::string& text) {
    if (!row.check) return;
    try {
        row.check(text);
    } catch (const InputError& error) {
        std::string what = error.what();
        // The checks of others say the flag's name first, or nothing.
        for (const std::string& flag : {"--" + std::string(row.name) + ": ", std::string(": ")}) {
            if (what.starts_with(flag)) what.erase(0, flag.size());
        }
        throw InputError(given.source, what);
    }
}

void put(const OptionRow& row, const GivenValue& given, std::string O::*field, ServeOptions& options) {
    const std::string& text = single(given, GivenValue::Kind::text, "a text in quotes");
    if (text.find('\0') != std::string::npos) refuse(given, "a text without a zero byte");
    checkText(row, given, text);
    options.*field = text;
}

void put(const OptionRow&, const GivenValue& given, bool O::*field, ServeOptions& options) {
    const std::string& text = single(given, GivenValue::Kind::boolean, "true or false");
    const bool yes = text == "true" || (given.kind == GivenValue::Kind::word && text == "1");
    const bool no = text == "false" || (given.kind == GivenValue::Kind::word && text == "0");
    if (!yes && !no) refuse(given, "true or false");
    options.*field = yes;
}

void put(const OptionRow& row, const GivenValue& given, uint64_t O::*field, ServeOptions& options) {
    const std::string allowed = "a whole number from " + std::to_string(row.low) + " to " + std::to_string(row.high);
    const std::string& text = single(given, GivenValue::Kind::number, allowed);
    uint64_t number = 0;
    auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc() || stop != text.data() + text.size() || number < row.low || number > row.high)
        refuse(given, allowed);
    options.*field = number;
}

void put(const OptionRow& row, const GivenValue& given, std::vector<std::string> O::*field, ServeOptions& options) {
    if (given.kind != GivenValue::Kind::text && given.kind != GivenValue::Kind::word)
        refuse(given, "a text or a list of texts, as [\"one\", \"two\"]");
    std::vector<std::string> texts;
    for (const std::string& text : given.texts) {
        for (size_t begin = 0; begin <= text.size();) {
            const size_t end = std::min(text.find(',', begin), text.size());
            texts.push_back(text.substr(begin, end - begin));
            checkText(row, given, texts.back());
            begin = end + 1;
        }
    }
    std::vector<std::string>& list = options.*field;
    if (row.name != "set") list.clear();
    list.insert(list.end(), texts.begin(), texts.end());
}

size_t editDistance(std::string_view a, std::string_view b) {
    std::vector<size_t> row(b.size() + 1);
    for (size_t j = 0; j <= b.size(); j++) row[j] = j;
    for (size_t i = 1; i <= a.size(); i++) {
        size_t diagonal = row[0];
        row[0] = i;
        for (size_t j = 1; j <= b.size(); j++) {
            const size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
            diagonal = row[j];
            row[j] = std::min({row[j] + 1, row[j - 1] + 1, substituted});
        }
    }
    return row.back();
}

}  // namespace

std::span<const OptionRow> optionRows() { return OPTION_ROWS; }

const OptionRow* optionNamed(std::string_view name) {
    const auto* row = std::ranges::find(OPTION_ROWS, name, &OptionRow::name);
    return row == std::end(OPTION_ROWS) ? nullptr : row;
}

std::string environmentName(std::string_view option) {
    std::string name = "HELIOGRAPH_";
    for (char c : option) name += c == '-' ? '_' : static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    return name;
}

std::string nearestOption(std::string_view word) {
    if (word.size() > 64) return {};
    std::string normal;
    for (char c : word) normal += c == '_' ? '-' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    const auto distance = [&](const OptionRow& row) { return editDistance(normal, row.name); };
    const OptionRow& best = *std::ranges::min_element(OPTION_ROWS, {}, distance);
    return distance(best) <= 2 ? std::string(best.name) : "";
}

void apply(const GivenValue& given, ServeOptions& options) {
    const OptionRow* row = optionNamed(given.option);
    if (!row) {
        const std::string near = nearestOption(given.option);
        throw InputError(given.source, "no such option",
                         near.empty() ? "the options of heliograph serve --help" : "did you mean " + near + "?");
    }
    std::visit([&](auto field) { put(*row, given, field, options); }, row->field);
}

std::string tomlText(std::string_view text) {
    std::string quoted = "\"";
    for (char c : text) {
        char code[8];
        const auto byte = static_cast<unsigned char>(c);
        if (c == '"' || c == '\\') quoted += '\\';
        if (byte < 0x20 || byte == 0x7f) std::snprintf(code, sizeof code, "\\u%04X", byte), quoted += code;
        else quoted += c;
    }
    return quoted + "\"";
}

std::string tomlValue(const OptionRow& row, const ServeOptions& options) {
    struct Writer {
        const ServeOptions& options;
        std::string operator()(std::string O::*field) const { return tomlText(options.*field); }
        std::string operator()(bool O::*field) const { return options.*field ? "true" : "false"; }
        std::string operator()(uint64_t O::*field) const { return std::to_string(options.*field); }
        std::string operator()(std::vector<std::string> O::*field) const {
            std::string list;
            for (const std::string& text : options.*field) list += (list.empty() ? "" : ", ") + tomlText(text);
            return "[" + list + "]";
        }
    };
    return std::visit(Writer{options}, row.field);
}

}  // namespace heliograph
