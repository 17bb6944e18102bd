// The bridge that lets one source be three programs: GLSL for Vulkan, scalar C++, and C++ on SIMD lanes (kernel.h,
// kernel_lanes.h). Rules of the shared subset:
//   no swizzles, no in/out keywords but IN() for large structs, OUT() and INOUT(), `f` on every literal, no array or struct constructors;
//   only math.glsl for transcendental functions;
//   a choice between values is SELECT(condition, yes, no), both sides are computed;
//   a branch on values is `if (ANY(condition))` and chooses with SELECT inside, since some lanes may say no;
//   plain `if` only for what is the same for the whole frame: HAS(effect), FRAME fields, a light's fields;
//   MET(variety) is false only if the scene holds nothing of the kind, so that the result is the same without asking;
//   fields of scene arrays are read as ARRAY(index, field), so that lanes load only what is used.
#ifndef HELIOGRAPH_COMPAT_GLSL
#define HELIOGRAPH_COMPAT_GLSL

#ifdef __cplusplus
#define KERNEL_CONSTANT static constexpr
#define MET(variety) true
#else
#ifndef MET
#define MET(variety) true
#endif
#define IN(T) T
#define OUT(T) out T
#define INOUT(T) inout T
#define KERNEL_CONSTANT const
#define SELECT(condition, yes, no) ((condition) ? (yes) : (no))
#define ANY(condition) (condition)
#define FLOAT_CONSTANT(name, value) const float name = value;
#define UINT_CONSTANT(name, value) const uint name = value;
#define EFFECT_CONSTANT(name, bit) const uint name = 1u << (bit & 31);
#define UNIFORM_UINT uint
#endif

#endif
