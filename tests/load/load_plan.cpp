#include "tests/load/load_plan.h"

#include "server/base/error.h"

#include <array>
#include <charconv>
#include <regex>
#include <utility>

namespace heliograph::load {

namespace {

constexpr std::array<std::pair<Script, const char*>, 8> SCRIPTS{{{Script::orbit, "orbit"},
                                                                 {Script::path, "path"},
                                                                 {Script::walk, "walk"},
                                                                 {Script::idle, "idle"},
                                                                 {Script::settings, "settings"},
                                                                 {Script::attacker, "attacker"},
                                                                 {Script::watch, "watch"},
                                                                 {Script::mixed, "mixed"}}};

const std::vector<NetworkProfile>& profiles() {
    static const std::vector<NetworkProfile> all{
        {"none"},
        {"slow", 250e3, 0.025},
        {"latency", 0.0, 0.15},
        {"lossy", 0.0, 0.025, 1.0, 0.25},
        {"stalls", 0.0, 0.0, 8.0, 3.0},
        {"close", 0.0, 0.0, 0.0, 0.0, 3.0},
    };
    return all;
}

template <class Range, class Name>
std::string listed(const Range& range, Name name) {
    std::string text;
    for (const auto& entry : range) text += (text.empty() ? "" : ", ") + std::string(name(entry));
    return text;
}

}  // namespace

Script scriptOf(const std::string& word) {
    for (const auto& [script, name] : SCRIPTS) {
        if (word == name) return script;
    }
    throw InputError("--script", "'" + word + "'", listed(SCRIPTS, [](const auto& row) { return row.second; }));
}

const char* wordOf(Script script) {
    for (const auto& [known, name] : SCRIPTS) {
        if (known == script) return name;
    }
    return "?";
}

NetworkProfile networkOf(const std::string& name) {
    for (const NetworkProfile& profile : profiles()) {
        if (profile.name == name) return profile;
    }
    throw InputError("--network", "'" + name + "'", listed(profiles(), [](const NetworkProfile& p) { return p.name; }));
}

bool Requirement::holds(double value) const {
    if (relation == "<=") return value <= bound;
    if (relation == "<") return value < bound;
    if (relation == ">=") return value >= bound;
    if (relation == ">") return value > bound;
    return value == bound;
}

Requirement requirementOf(const std::string& text) {
    static const std::regex FORM(R"(\s*([a-z0-9_]+)\s*(<=|>=|==|<|>)\s*([0-9.eE+-]+)\s*)");
    std::smatch part;
    Requirement requirement;
    const auto refuse = [&] { return InputError("--require", "'" + text + "'", "FIGURE<=NUMBER (also <, ==, >=, >)"); };
    if (!std::regex_match(text, part, FORM)) throw refuse();
    const std::string number = part[3];
    const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), requirement.bound);
    if (error != std::errc{} || end != number.data() + number.size()) throw refuse();
    requirement.text = text;
    requirement.figure = part[1];
    requirement.relation = part[2];
    return requirement;
}

Script scriptFor(const LoadPlan& plan, uint32_t index) {
    if (plan.script == Script::watch && index == 0) return Script::orbit;
    if (plan.script != Script::mixed) return plan.script;
    static constexpr Script DEALT[] = {Script::orbit, Script::walk, Script::idle, Script::path, Script::settings};
    return DEALT[index % std::size(DEALT)];
}

ServerAddress addressOf(const std::string& url) {
    static const std::regex FORM(R"((ws|http)(s?)://(\[[0-9a-fA-F:]+\]|[^/:\[\]]+)(?::([0-9]{1,5}))?(/.*)?)");
    std::smatch part;
    if (!std::regex_match(url, part, FORM)) throw InputError("URL", "'" + url + "'", "ws://HOST:PORT/PATH or wss://...");
    ServerAddress address;
    address.tls = part[2].length() > 0;
    address.host = part[3];
    if (address.host.front() == '[') address.host = address.host.substr(1, address.host.size() - 2);
    address.port = part[4].matched ? std::stoi(part[4]) : address.tls ? 443 : 80;
    if (address.port < 1 || address.port > 65535) throw InputError("URL", "port " + part[4].str(), "1 to 65535");
    address.path = part[5].matched ? part[5].str() : "/";
    // A page's address is what people have at hand; its socket lies beside it.
    if (address.path.back() == '/') address.path += "ws";
    return address;
}

}  // namespace heliograph::load
