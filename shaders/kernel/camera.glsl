// From pixels to rays.

// Unit direction through position (x, y), in pixels from the top left corner.
vec3 cameraDirection(float x, float y) {
    float sx = (2.0f * x) / float(FRAME.resolution.x) - 1.0f;
    float sy = 1.0f - (2.0f * y) / float(FRAME.resolution.y);
    return normalize3(FRAME.camera.forward + FRAME.camera.right * sx + FRAME.camera.up * sy);
}
