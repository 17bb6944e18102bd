// Rays and their origins.

// Where a ray leaves a surface point for the side to which the geometric normal n points, by Surface::clearance.
vec3 offsetRayOrigin(vec3 p, vec3 n, float clearance) { return p + n * clearance; }

// What a device may trace: a ray that begins within reach of the scene, has a direction of about unit length and an end. Anything
// else (not a number, infinite, so far away that it leaves float in some instance's space) meets nothing, on every device.
bool isTraceable(vec3 origin, vec3 direction, float tMax, float reach) {
    return abs(origin.x) + abs(origin.y) + abs(origin.z) <= reach &&
           abs(direction.x) + abs(direction.y) + abs(direction.z) <= 2.0f && tMax == tMax;
}
