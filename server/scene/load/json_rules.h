#pragma once
// A small schema for JSON files: one row per property. Private to server/scene.

#include <nlohmann/json.hpp>

#include <functional>
#include <limits>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

namespace heliograph {

constexpr double ANY = std::numeric_limits<double>::infinity();

/// What a property must be.
enum class Is {
    boolean,
    text,      // a string
    whole,     // an integer in [low, high]
    number,    // in [low, high]
    above,     // a number in (low, high]
    numbers,   // an array of numbers; its length in [low, high]
    wholes,    // an array of integers that index the root's array `target`, a property or a pointer that begins with '/'
    index,     // an integer that indexes the root's array `target`
    object,    // of kind `target`; an empty target: any
    list,      // an array of objects of kind `target`
    indexMap,  // an object whose values index the root's array `target`
};

struct JsonRule {
    const char* kind;  // of the object that has the property
    const char* property;
    Is is;
    double low = -ANY;
    double high = ANY;
    const char* target = "";
    bool required = false;
};

/// Receives (JSON pointer, what was found, what is allowed).
using JsonFault = std::function<void(const std::string& where, const std::string& found, const std::string& allowed)>;

/// Checks `value` as an object of `kind` and everything below it. `refuse` must throw; `complain` may return (empty
/// arrays). Objects' "extensions" are checked as objects of the kind that the extension's name names.
class JsonRules {
public:
    JsonRules(std::span<const JsonRule> rules, const nlohmann::json& root, JsonFault refuse, JsonFault complain)
        : root_(root), refuse_(std::move(refuse)), complain_(std::move(complain)) {
        for (const JsonRule& rule : rules) rulesOf_[rule.kind].push_back(&rule);
    }

    void check(const std::string& kind, const nlohmann::json& value, const std::string& where) const;

private:
    void checkProperty(const JsonRule& rule, const nlohmann::json& value, const std::string& where) const;
    void checkNumber(const JsonRule& rule, const nlohmann::json& value, const std::string& where) const;
    void checkIndex(const char* array, const nlohmann::json& value, const std::string& where) const;
    void checkArray(const JsonRule& rule, const nlohmann::json& value, const std::string& where) const;
    void checkExtensions(const nlohmann::json& value, const std::string& where) const;

    std::unordered_map<std::string, std::vector<const JsonRule*>> rulesOf_;  // by kind
    const nlohmann::json& root_;
    JsonFault refuse_;
    JsonFault complain_;
};

/// A value for messages: its JSON, shortened to one line.
std::string shownJson(const nlohmann::json& value);

}  // namespace heliograph
