// From pixels to rays.

// Where the camera stands for one sample.
struct CameraPose {
    vec3 origin;
    vec3 forward;  // the same scales as KernelCamera's
    vec3 right;
    vec3 up;
};

CameraPose cameraAtRest() {
    CameraPose c;
    c.origin = FRAME.camera.origin;
    c.forward = FRAME.camera.forward;
    c.right = FRAME.camera.right;
    c.up = FRAME.camera.up;
    return c;
}

// Unit direction through position (x, y), in pixels from the top left corner.
vec3 directionFrom(IN(CameraPose) c, float x, float y) {
    float sx = (2.0f * x) / float(FRAME.resolution.x) - 1.0f;
    float sy = 1.0f - (2.0f * y) / float(FRAME.resolution.y);
    return normalize3(c.forward + c.right * sx + c.up * sy);
}

vec3 cameraDirection(float x, float y) { return directionFrom(cameraAtRest(), x, y); }
