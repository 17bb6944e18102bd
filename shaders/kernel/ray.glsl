// Rays and their origins.

// Moves a surface point off its surface along the geometric normal n by a number of ulps. Waechter & Binder, "A Fast and
// Robust Method for Avoiding Self-Intersection", Ray Tracing Gems (2019), ch. 6.
vec3 offsetRayOrigin(vec3 p, vec3 n) {
    const float origin = 0.03125f;            // 1/32
    const float floatScale = 1.52587890625e-5f;  // 1/65536
    const float intScale = 256.0f;
    int ix = int(intScale * n.x);
    int iy = int(intScale * n.y);
    int iz = int(intScale * n.z);
    float px = intBitsToFloat(floatBitsToInt(p.x) + SELECT(p.x < 0.0f, -ix, ix));
    float py = intBitsToFloat(floatBitsToInt(p.y) + SELECT(p.y < 0.0f, -iy, iy));
    float pz = intBitsToFloat(floatBitsToInt(p.z) + SELECT(p.z < 0.0f, -iz, iz));
    return vec3(SELECT(abs(p.x) < origin, p.x + floatScale * n.x, px),
                SELECT(abs(p.y) < origin, p.y + floatScale * n.y, py),
                SELECT(abs(p.z) < origin, p.z + floatScale * n.z, pz));
}

// What a device may trace: a ray that begins within reach of the scene, has a direction of about unit length and an end. Anything
// else (not a number, infinite, so far away that it leaves float in some instance's space) meets nothing, on every device.
bool isTraceable(vec3 origin, vec3 direction, float tMax, float reach) {
    return abs(origin.x) + abs(origin.y) + abs(origin.z) <= reach &&
           abs(direction.x) + abs(direction.y) + abs(direction.z) <= 2.0f && tMax == tMax;
}
