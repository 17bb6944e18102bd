// Values of settings, as JSON from a viewer and as text from a command line.

#include "server/request/settings.h"
#include "tests/fuzz/fuzz.h"

using namespace heliograph;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    const std::string_view text(reinterpret_cast<const char*>(data), size);
    fuzz::refusing([&] { Settings().setFromText(text); });
    const nlohmann::json values = size > 65536 ? nlohmann::json() : nlohmann::json::parse(text, nullptr, false);
    if (!values.is_object()) return 0;
    Settings settings;
    for (const auto& item : values.items()) fuzz::refusing([&] { settings.set(item.key(), item.value()); });
    // What was taken can be said again.
    Settings again;
    const nlohmann::json said = settings.toJson();
    for (const auto& [name, value] : said.items()) again.set(name, value);
    if (!(again == settings)) __builtin_trap();
    return 0;
}
