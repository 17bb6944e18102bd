// The viewer's camera and the ways to move it: pure functions from one camera to the next. Y is up in the world; angles
// are radians but for `fieldOfView`. `forward` and `up` stay orthonormal.

import { add, clamp, cross, dot, length, normalize, rotate, scale, subtract, type Vec3 } from './vector.js';

export interface Camera {
  readonly position: Vec3;
  readonly forward: Vec3; // unit
  readonly up: Vec3; // unit, orthogonal to forward
  readonly fieldOfView: number; // vertical, degrees
}

export interface Bounds {
  readonly low: Vec3;
  readonly high: Vec3;
}

export const WORLD_UP: Vec3 = [0, 1, 0];
export const FIELD_OF_VIEW_LOW = 0.01; // degrees
export const FIELD_OF_VIEW_HIGH = 179; // degrees
/** Nearest that mouse-look comes to straight up or down, radians. */
const POLE_MARGIN = 0.01;

export const DEFAULT_CAMERA: Camera = { position: [0, 0, 0], forward: [0, 0, -1], up: WORLD_UP, fieldOfView: 60 };

export const rightOf = (camera: Camera): Vec3 => normalize(cross(camera.forward, camera.up));

/** From where all of `bounds` is in view, in the direction that is looked in; `aspect`: width over height. */
export function framing(camera: Camera, { low, high }: Bounds, aspect: number): Camera {
  const center = scale(add(low, high), 0.5);
  const half = (Math.min(camera.fieldOfView, 120) * Math.PI) / 360;
  const narrow = aspect < 1 ? Math.atan(Math.tan(half) * aspect) : half;
  const radius = Math.max(length(subtract(high, low)) / 2, 1e-6);
  return { ...camera, position: subtract(center, scale(camera.forward, radius / Math.sin(narrow))) };
}

/** Removes the rounding that repeated turns leave. */
function orthonormal(camera: Camera): Camera {
  const forward = normalize(camera.forward);
  const up = normalize(subtract(camera.up, scale(forward, dot(camera.up, forward))));
  return { ...camera, forward, up };
}

/**
 * The horizontal axis for pitch: level even when the camera is rolled, its own right when it looks along the world's
 * up.
 */
function levelRight(camera: Camera): Vec3 {
  const level = cross(camera.forward, WORLD_UP);
  return length(level) > 1e-4 ? normalize(level) : rightOf(camera);
}

/**
 * `pitch` shortened so that the view does not pass the pole. A view already past the margin may only turn away from
 * it.
 */
function limitedPitch(forward: Vec3, pitch: number): number {
  const fromUp = Math.acos(clamp(dot(forward, WORLD_UP), -1, 1));
  const highest = Math.max(0, fromUp - POLE_MARGIN);
  const lowest = Math.min(0, fromUp - (Math.PI - POLE_MARGIN));
  return clamp(pitch, lowest, highest);
}

/** Turns the view: `yaw` > 0 to the left about the world's up, `pitch` > 0 upwards. Roll is kept. */
export function look(camera: Camera, yaw: number, pitch: number): Camera {
  const right = levelRight(camera);
  const angle = limitedPitch(camera.forward, pitch);
  const turn = (v: Vec3): Vec3 => rotate(rotate(v, right, angle), WORLD_UP, yaw);
  return orthonormal({ ...camera, forward: turn(camera.forward), up: turn(camera.up) });
}

/** Turns the view towards the screen's right and up (radians), whatever the roll. */
export function lookOnScreen(camera: Camera, rightward: number, upward: number): Camera {
  const level = levelRight(camera);
  const levelUp = cross(level, camera.forward);
  const right = rightOf(camera);
  const angle = Math.atan2(dot(right, levelUp), dot(right, level));
  const cosine = Math.cos(angle);
  const sine = Math.sin(angle);
  return look(camera, -(rightward * cosine - upward * sine), rightward * sine + upward * cosine);
}

/** Turns the picture about the view direction: `angle` > 0 leans the camera to the right. */
export function roll(camera: Camera, angle: number): Camera {
  return orthonormal({ ...camera, up: rotate(camera.up, camera.forward, angle) });
}

/** Moves along the camera's own axes, in the scene's length unit. */
export function move(camera: Camera, right: number, up: number, forward: number): Camera {
  const sideways = add(scale(rightOf(camera), right), scale(camera.up, up));
  return { ...camera, position: add(camera.position, add(sideways, scale(camera.forward, forward))) };
}

/** Like `lookOnScreen`, but about the point `distance` ahead, which stays in the middle of the picture. */
export function orbit(camera: Camera, distance: number, rightward: number, upward: number): Camera {
  const pivot = add(camera.position, scale(camera.forward, distance));
  const turned = lookOnScreen(camera, rightward, upward);
  return { ...turned, position: subtract(pivot, scale(turned.forward, distance)) };
}

/** Where a point of the world lies in the picture, 0..1 from its top left corner; null behind the camera. `aspect`: width over height. */
export function placeOf(camera: Camera, point: Vec3, aspect: number): { readonly x: number; readonly y: number } | null {
  const to = subtract(point, camera.position);
  const depth = dot(to, camera.forward);
  if (!(depth > 0)) return null;
  const half = depth * Math.tan((camera.fieldOfView * Math.PI) / 360);
  return { x: 0.5 + dot(to, rightOf(camera)) / (2 * half * aspect), y: 0.5 - dot(to, camera.up) / (2 * half) };
}

/** Turned so that `point` is in the middle; the same camera where it stands at the point. */
export function lookingAt(camera: Camera, point: Vec3): Camera {
  const to = subtract(point, camera.position);
  if (length(to) < 1e-9) return camera;
  const forward = normalize(to);
  const up = length(cross(forward, camera.up)) > 1e-4 ? camera.up : camera.forward;
  return orthonormal({ ...camera, forward, up });
}

/** Length that one pixel covers at `distance` ahead, for a picture `height` pixels high. */
export function lengthPerPixel(camera: Camera, distance: number, height: number): number {
  return (2 * distance * Math.tan((camera.fieldOfView * Math.PI) / 360)) / Math.max(1, height);
}

export function withFieldOfView(camera: Camera, degrees: number): Camera {
  return { ...camera, fieldOfView: clamp(degrees, FIELD_OF_VIEW_LOW, FIELD_OF_VIEW_HIGH) };
}

/** How far ahead the orbit's pivot lies: level with the middle of the scene, within sensible limits of its size. */
export function pivotDistance(camera: Camera, bounds: Bounds, radius: number): number {
  const center = scale(add(bounds.low, bounds.high), 0.5);
  return clamp(dot(subtract(center, camera.position), camera.forward), 0.1 * radius, 4 * radius);
}
