// Motion blur of a moving camera: each sample has its own time while the shutter was open and sees the scene from where the camera
// was then. Cook, Porter & Carpenter, "Distributed Ray Tracing" (1984). Left out: moving things, of which scenes have none.

UINT_CONSTANT(MOTION_SALT, 0x6d6f7665u)

// Where the camera was at the sample's time: between FRAME.cameraBefore, a frame ago, and now, at most FRAME.shutter frames ago. Times
// of a pixel's samples follow the golden ratio's multiples, which fill a line evenly; each pixel starts elsewhere.
CameraPose cameraInMotion(uvec2 pixel, UNIFORM_UINT sampleIndex) {
    float ago = FRAME.shutter * unitFloat(hashPixel(pixel, MOTION_SALT + FRAME.seed) + sampleIndex * 0x9e3779b9u);
    CameraPose c;
    c.origin = FRAME.camera.origin + (FRAME.cameraBefore.origin - FRAME.camera.origin) * ago;
    c.forward = FRAME.camera.forward + (FRAME.cameraBefore.forward - FRAME.camera.forward) * ago;
    c.right = FRAME.camera.right + (FRAME.cameraBefore.right - FRAME.camera.right) * ago;
    c.up = FRAME.camera.up + (FRAME.cameraBefore.up - FRAME.camera.up) * ago;
    return c;
}
