#pragma once
// What a glTF 2.0 file may contain, as far as we read it: the table for JsonRules, checks that a table cannot say, and
// the extensions. Private to server/scene.

#include "server/scene/load/json_rules.h"

#include <vector>

namespace heliograph {

/// Checks the whole document. Throws InputError (file, JSON pointer, found, allowed) for what cannot be loaded safely
/// or breaks the specification's structure; appends to `warnings` what is only odd.
void checkGltfJson(const nlohmann::json& root, const std::string& file, std::vector<std::string>& warnings);

/// True for the extensions that the loader draws or may safely read past.
bool knowsGltfExtension(const std::string& name);

}  // namespace heliograph
