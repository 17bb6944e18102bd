#version 460
// Corners of an instance's triangles, fetched from the scene's arrays; no vertex input.
#extension GL_GOOGLE_include_directive : require
#include "raster/raster.glsl"

layout(location = 0) flat out uvec2 instanceAndPrimitive;

void main() {
    uint instance = uint(gl_InstanceIndex);
    uint primitive = uint(gl_VertexIndex) / 3u;
    uvec4 corners = TRIANGLE(INSTANCE(instance, firstTriangle) + primitive);
    uint corner = uint(gl_VertexIndex) % 3u;
    vec4 p = vec4(POSITION(corner == 0u ? corners.x : (corner == 1u ? corners.y : corners.z)).xyz, 1.0);
    vec3 world = vec3(dot(INSTANCE(instance, toWorld0), p), dot(INSTANCE(instance, toWorld1), p), dot(INSTANCE(instance, toWorld2), p));
    KernelCamera camera = FRAME.camera;
    vec3 v = world - camera.origin;
    float z = dot(v, camera.forward);
    // right and up are scaled by the tangents of half the angles: dividing by their squares undoes it.
    float x = dot(v, camera.right) / dot(camera.right, camera.right);
    float y = dot(v, camera.up) / dot(camera.up, camera.up);
    // The sample's point of the pixel moves to the pixel's centre.
    vec2 shift = (vec2(1.0) - 2.0 * jitter) / vec2(FRAME.resolution);
    gl_Position = vec4(x + shift.x * z, -y + shift.y * z, nearest, z);  // depth near/z: 1 at the near plane, 0 far away
    instanceAndPrimitive = uvec2(instance, primitive);
}
