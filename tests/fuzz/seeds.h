#pragma once
// Small valid inputs of every fuzz target.

#include <map>
#include <string>
#include <vector>

namespace heliograph::fuzz {

struct Seed {
    std::string name;
    std::string bytes;
};

/// By target: message, settings, header, upload, image, gltf, glb, obj.
std::map<std::string, std::vector<Seed>> seeds();

}  // namespace heliograph::fuzz
