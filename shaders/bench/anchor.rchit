#version 460
#extension GL_EXT_ray_tracing : require
layout(location = 0) rayPayloadInEXT uvec2 found;
void main() { found = uvec2(gl_PrimitiveID, 1u); }
