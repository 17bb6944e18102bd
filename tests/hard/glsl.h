#pragma once
// GLSL's vectors with the swizzles that shaders/vulkan/bvh.glsl uses, for compiling it as C++. A swizzle is a member function here
// and its name a macro, defined where that file is included (own_tree.inc).

#include "server/kernel/kernel_types.h"

namespace heliograph::hard::glsl {

using uint = std::uint32_t;

struct vec4;

struct vec3 : glm::vec3 {
    using glm::vec3::vec3;
    vec3() = default;
    vec3(const glm::vec3& v) : glm::vec3(v) {}
    vec4 xxyy_() const;
    vec4 zzzz_() const;
};

struct vec4 : glm::vec4 {
    using glm::vec4::vec4;
    vec4() = default;
    vec4(const glm::vec4& v) : glm::vec4(v) {}
    vec3 xyz_() const { return {x, y, z}; }
};

inline vec4 vec3::xxyy_() const { return {x, x, y, y}; }
inline vec4 vec3::zzzz_() const { return {z, z, z, z}; }

struct uvec3 : glm::uvec3 {
    using glm::uvec3::uvec3;
    uvec3(const glm::uvec3& v) : glm::uvec3(v) {}
    friend uvec3 operator<<(const uvec3& v, int bits) { return {v.x << bits, v.y << bits, v.z << bits}; }
};

struct uvec4 : glm::uvec4 {
    using glm::uvec4::uvec4;
    uvec4() = default;
    uvec4(const glm::uvec4& v) : glm::uvec4(v) {}
    glm::uvec3 xyz_() const { return {x, y, z}; }
};

using uvec2 = glm::uvec2;

// GLM's own templates would take these for scalars.
inline float dot(const vec3& a, const vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline vec3 cross(const vec3& a, const vec3& b) { return glm::cross<float, glm::defaultp>(a, b); }
inline vec4 min(const vec4& a, const vec4& b) { return glm::min<4, float, glm::defaultp>(a, b); }
inline vec4 max(const vec4& a, const vec4& b) { return glm::max<4, float, glm::defaultp>(a, b); }
inline uvec4 mix(const uvec4& no, const uvec4& yes, const glm::bvec4& choice) {
    return {choice.x ? yes.x : no.x, choice.y ? yes.y : no.y, choice.z ? yes.z : no.z, choice.w ? yes.w : no.w};
}

struct Hit {
    uint instance = NO_INDEX;
    uint primitive = 0u;
    Hit() = default;
    Hit(uint i, uint p) : instance(i), primitive(p) {}
};

}  // namespace heliograph::hard::glsl
