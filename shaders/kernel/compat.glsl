// The bridge that lets one source be GLSL and C++: glslang compiles the kernel for Vulkan, g++ compiles the same files
// inside `struct Kernel` (kernel.h). Rules of the shared subset: no swizzles, OUT()/INOUT() for reference parameters,
// `f` on every literal, no array or struct constructors, only math.glsl for transcendental functions.
#ifndef HELIOGRAPH_COMPAT_GLSL
#define HELIOGRAPH_COMPAT_GLSL

#ifdef __cplusplus
#define OUT(T) T&
#define INOUT(T) T&
#define PRECISE
#define KERNEL_CONSTANT static constexpr
#else
#define OUT(T) out T
#define INOUT(T) inout T
#define PRECISE precise
#define KERNEL_CONSTANT const
#endif

#endif
