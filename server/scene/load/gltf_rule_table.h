#pragma once
// The properties of glTF 2.0 objects that we read. Private to server/scene.

#include "server/scene/load/json_rules.h"

namespace heliograph {

/// Rows for JsonRules; the document itself is of kind "root".
std::span<const JsonRule> gltfRuleTable();

}  // namespace heliograph
