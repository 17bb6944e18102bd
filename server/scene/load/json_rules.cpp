#include "server/scene/load/json_rules.h"

#include <cmath>

namespace heliograph {

using nlohmann::json;

namespace {

const char* wordFor(Is is) {
    switch (is) {
        case Is::boolean: return "true or false";
        case Is::text: return "a string";
        case Is::whole:
        case Is::index: return "an integer";
        case Is::number:
        case Is::above: return "a number";
        case Is::object:
        case Is::indexMap: return "an object";
        default: return "an array";
    }
}

bool hasType(const json& value, Is is) {
    switch (is) {
        case Is::boolean: return value.is_boolean();
        case Is::text: return value.is_string();
        case Is::whole:
        case Is::index:
            // Integers may be written as 1.0 (the specification asks readers to take them).
            return value.is_number_integer() ||
                   (value.is_number_float() && std::floor(value.get<double>()) == value.get<double>());
        case Is::number:
        case Is::above: return value.is_number();
        case Is::object:
        case Is::indexMap: return value.is_object();
        default: return value.is_array();
    }
}

std::string numberText(double value) { return json(value).dump(); }

std::string rangeText(const JsonRule& rule) {
    std::string text =
        rule.low == -ANY ? "" : std::string(rule.is == Is::above ? "more than " : "at least ") + numberText(rule.low);
    if (rule.high != ANY) text += (text.empty() ? "" : " and ") + std::string("at most ") + numberText(rule.high);
    return text;
}

}  // namespace

std::string shownJson(const json& value) {
    if (value.is_structured()) return value.is_array() ? "an array" : "an object";
    if (value.is_string() && value.get_ref<const std::string&>().size() > 80) return "a string";
    return value.dump(-1, ' ', true, json::error_handler_t::replace);
}

void JsonRules::check(const std::string& kind, const json& value, const std::string& where) const {
    if (!value.is_object()) refuse_(where, shownJson(value), "an object");
    checkExtensions(value, where);
    const auto rules = rulesOf_.find(kind);
    if (rules == rulesOf_.end()) return;
    for (const JsonRule* rule : rules->second) {
        const auto found = value.find(rule->property);
        if (found != value.end()) {
            checkProperty(*rule, *found, where + "/" + rule->property);
        } else if (rule->required) {
            refuse_(where, std::string("property '") + rule->property + "' is missing", wordFor(rule->is));
        }
    }
}

void JsonRules::checkExtensions(const json& value, const std::string& where) const {
    const auto extensions = value.find("extensions");
    if (extensions == value.end()) return;
    if (!extensions->is_object()) refuse_(where + "/extensions", shownJson(*extensions), "an object");
    for (const auto& [name, extension] : extensions->items()) {
        if (!extension.is_object()) refuse_(where + "/extensions/" + name, shownJson(extension), "an object");
        check(name, extension, where + "/extensions/" + name);
    }
}

void JsonRules::checkProperty(const JsonRule& rule, const json& value, const std::string& where) const {
    if (!hasType(value, rule.is)) refuse_(where, shownJson(value), wordFor(rule.is));
    switch (rule.is) {
        case Is::whole:
        case Is::number:
        case Is::above: checkNumber(rule, value, where); break;
        case Is::index: checkIndex(rule.target, value, where); break;
        case Is::object:
            if (*rule.target) check(rule.target, value, where);
            break;
        case Is::indexMap:
            for (const auto& [name, index] : value.items()) checkIndex(rule.target, index, where + "/" + name);
            break;
        case Is::numbers:
        case Is::wholes:
        case Is::list: checkArray(rule, value, where); break;
        default: break;
    }
}

void JsonRules::checkNumber(const JsonRule& rule, const json& value, const std::string& where) const {
    const double number = value.get<double>();
    const bool inside = rule.is == Is::above ? number > rule.low : number >= rule.low;
    if (!inside || !(number <= rule.high) || !std::isfinite(number)) refuse_(where, shownJson(value), rangeText(rule));
}

void JsonRules::checkIndex(const char* array, const json& value, const std::string& where) const {
    if (!hasType(value, Is::index)) refuse_(where, shownJson(value), "an integer");
    const bool below = *array == '/';
    const json* list = nullptr;
    if (below && root_.contains(json::json_pointer(array))) list = &root_[json::json_pointer(array)];
    if (!below && root_.contains(array)) list = &root_[array];
    const size_t count = list && list->is_array() ? list->size() : 0;
    const double index = value.get<double>();
    if (!(index >= 0.0 && index < static_cast<double>(count)))
        refuse_(where, shownJson(value), "an index below " + std::to_string(count) + " (" + array + ")");
}

void JsonRules::checkArray(const JsonRule& rule, const json& value, const std::string& where) const {
    const double size = static_cast<double>(value.size());
    if (rule.is == Is::numbers && rule.low != -ANY && (size < rule.low || size > rule.high)) {
        const std::string low = numberText(rule.low);
        refuse_(where, "an array of " + std::to_string(value.size()),
                low + (rule.high > rule.low ? " or more" : "") + " numbers");
    }
    if (value.empty()) complain_(where, "an empty array", "at least one element");
    size_t i = 0;
    for (const json& element : value) {
        const std::string at = where + "/" + std::to_string(i++);
        if (rule.is == Is::list) {
            check(rule.target, element, at);
        } else if (rule.is == Is::wholes) {
            checkIndex(rule.target, element, at);
        } else if (!element.is_number()) {
            refuse_(at, shownJson(element), "a number");
        }
    }
}

}  // namespace heliograph
