#pragma once
// JSON from strangers. nlohmann's parser needs no stack for nesting, but writing, comparing and copying what it returns
// do: a deep text must be refused before anything is done with it.

#include <nlohmann/json.hpp>

#include <cstdint>
#include <string>
#include <string_view>

namespace heliograph {

/// How deep and how large a JSON text is.
struct JsonExtent {
    uint64_t depth = 0;   // arrays and objects open at once, at most
    uint64_t values = 0;  // an upper bound of the values in it
};

/// Reads the brackets and commas outside of strings; the text need not be valid JSON. Stops once deeper than `deepest`.
inline JsonExtent jsonExtent(std::string_view text, uint64_t deepest) {
    JsonExtent extent;
    uint64_t open = 0;
    bool inString = false;
    for (size_t i = 0; i < text.size(); i++) {
        const char c = text[i];
        if (inString) {
            if (c == '\\') i++;
            else if (c == '"') inString = false;
            continue;
        }
        if (c == '"') inString = true;
        if (c == '[' || c == '{') {
            extent.values++;
            if (++open > extent.depth) extent.depth = open;
            if (extent.depth > deepest) break;
        }
        if ((c == ']' || c == '}') && open > 0) open--;
        if (c == ',') extent.values++;
    }
    return extent;
}

/// The value as a text that ends a line; bytes that are no UTF-8 become U+FFFD. indent: columns for each depth; -1: one line.
inline std::string dumped(const nlohmann::ordered_json& json, int indent = 2) {
    return json.dump(indent, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace heliograph
