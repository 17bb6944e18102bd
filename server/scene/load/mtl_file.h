#pragma once
// Materials of MTL files as they stand there. Private to server/scene.

#include "server/kernel/kernel_types.h"

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

namespace heliograph {

/// An image and how it lies on the surface.
struct MtlMap {
    std::string file;  // as written, without quotes
    vec2 scale{1.0f, 1.0f};
    vec2 offset{0.0f, 0.0f};
    float bump = 1.0f;
    bool clamp = false;
};

struct MtlMaterial {
    std::string name;
    std::string folder;                                       // of the MTL file, as the OBJ file names it; empty: the same one
    std::optional<vec3> diffuse, specular, emission, filter;  // Kd Ks Ke Tf
    float exponent = 1.0f;                                    // Ns
    float index = 1.0f;                                       // Ni
    float dissolve = 1.0f;                                    // d, or 1 - Tr
    std::optional<float> mirror;                              // Ir, RayEngine's constant reflectance
    float roughness = 0.0f, metallic = 0.0f;                  // Pr Pm
    int model = 0;                                            // illum
    std::map<std::string, MtlMap> maps;                       // by key in lower case: map_kd, bump ...
};

struct MtlFile {
    std::vector<MtlMaterial> materials;
    std::set<std::string> notRead;  // keys and kinds of values that were left out
};

/// `file`: for messages. Throws InputError for what is no text.
MtlFile parseMtl(std::span<const uint8_t> bytes, const std::string& file);

}  // namespace heliograph
