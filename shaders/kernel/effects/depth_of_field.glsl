// Depth of field: camera rays start anywhere on a thin lens and meet in the plane of focus. Cook, Porter & Carpenter,
// "Distributed Ray Tracing" (1984); Kolb, Mitchell & Hanrahan, "A Realistic Camera Model for Computer Graphics" (1995), for
// what a thin lens leaves out: here no distortion and no vignetting.

UINT_CONSTANT(LENS_SALT, 0x6c656e73u)  // no vertex of a path has it but by chance

// Moves a camera ray to its point on the lens, a disc of FRAME.aperture metres across the camera's origin. It still meets the
// plane FRAME.focusDistance ahead where it did before.
void throughLens(IN(CameraPose) c, uvec2 pixel, UNIFORM_UINT sampleIndex, INOUT(vec3) origin, INOUT(vec3) direction) {
    uint shift = hashPixel(pixel, LENS_SALT + FRAME.seed);
    uvec2 point = shuffledPoint(sampleIndex, shift);
    float r = (0.5f * FRAME.aperture) * sqrt(unitFloat(point.x ^ shift));
    float sine;
    float cosine;
    sinCosTurn(unitFloat(point.y ^ hashUint(shift)), sine, cosine);
    vec3 onLens = normalize3(c.right) * (r * cosine) + normalize3(c.up) * (r * sine);
    vec3 inFocus = direction * (max(FRAME.focusDistance, 1.0e-3f) / dot(direction, c.forward));
    origin = origin + onLens;
    direction = normalize3(inFocus - onLens);
}
