import assert from 'node:assert/strict';
import { test } from 'node:test';
import {
  DEFAULT_CAMERA,
  framing,
  lengthPerPixel,
  look,
  lookOnScreen,
  move,
  orbit,
  pivotDistance,
  rightOf,
  roll,
  withFieldOfView,
  type Bounds,
  type Camera,
} from '../../src/camera/camera.js';
import { add, cross, dot, length, normalize, scale, subtract, type Vec3 } from '../../src/camera/vector.js';

function close(actual: Vec3, expected: Vec3, tolerance = 1e-9): void {
  assert.ok(
    length(subtract(actual, expected)) <= tolerance,
    `found ${actual.join(' ')}, expected ${expected.join(' ')}`,
  );
}

function orthonormal(camera: Camera): void {
  assert.ok(Math.abs(length(camera.forward) - 1) < 1e-9);
  assert.ok(Math.abs(length(camera.up) - 1) < 1e-9);
  assert.ok(Math.abs(dot(camera.forward, camera.up)) < 1e-9);
}

test('look: a quarter turn to the left from -z faces -x', () => {
  const turned = look(DEFAULT_CAMERA, Math.PI / 2, 0);
  close(turned.forward, [-1, 0, 0]);
  close(turned.up, [0, 1, 0]);
});

test('look: pitch stops just before straight up and down', () => {
  for (const pitch of [10, -10]) {
    const turned = look(DEFAULT_CAMERA, 0, pitch);
    assert.ok(Math.abs(Math.abs(turned.forward[1]) - Math.cos(0.01)) < 1e-9);
    assert.ok(turned.up[1] > 0, 'the camera has not tipped over');
    orthonormal(turned);
  }
});

test('look: a camera that looks straight down can be turned up again', () => {
  const down: Camera = { ...DEFAULT_CAMERA, forward: [0, -1, 0], up: [0, 0, -1] };
  const turned = look(down, 0, 0.5);
  orthonormal(turned);
  close(turned.forward, [0, -Math.cos(0.5), -Math.sin(0.5)]);
});

test('look: keeps roll, and stays orthonormal over thousands of turns', () => {
  let camera = roll(DEFAULT_CAMERA, 0.4);
  const lean = rightOf(camera)[1];
  for (let i = 0; i < 5000; i += 1) camera = look(camera, 0.01, 0);
  orthonormal(camera);
  assert.ok(Math.abs(rightOf(camera)[1] - lean) < 1e-9);
});

test('lookOnScreen: goes towards the screen, also when the camera stands on its head', () => {
  const upside: Camera = { ...DEFAULT_CAMERA, up: [0, -1, 0] };
  for (const camera of [DEFAULT_CAMERA, upside, roll(DEFAULT_CAMERA, 1)]) {
    const turned = lookOnScreen(camera, 0.01, 0.02);
    assert.ok(dot(turned.forward, rightOf(camera)) > 0.009);
    assert.ok(dot(turned.forward, camera.up) > 0.019);
  }
});

test('roll: to the right brings the up vector to the right', () => {
  const rolled = roll(DEFAULT_CAMERA, Math.PI / 2);
  close(rolled.up, rightOf(DEFAULT_CAMERA));
});

test('move: along the camera\u2019s own axes', () => {
  close(move(DEFAULT_CAMERA, 1, 2, 3).position, [1, 2, -3]);
  close(rightOf(DEFAULT_CAMERA), cross(DEFAULT_CAMERA.forward, DEFAULT_CAMERA.up));
});

test('orbit: the pivot stays ahead at the same distance', () => {
  const before: Camera = { ...DEFAULT_CAMERA, position: [3, 2, 8] };
  const pivot = add(before.position, scale(before.forward, 5));
  let after = before;
  for (let i = 0; i < 100; i += 1) after = orbit(after, 5, 0.07, -0.01);
  close(add(after.position, scale(after.forward, 5)), pivot, 1e-6);
  orthonormal(after);
});

test('lengthPerPixel: the picture\u2019s height spans the field of view', () => {
  const camera = withFieldOfView(DEFAULT_CAMERA, 90);
  assert.ok(Math.abs(lengthPerPixel(camera, 10, 100) - 0.2) < 1e-12);
});

test('withFieldOfView: stays within 0.01 and 179 degrees', () => {
  assert.equal(withFieldOfView(DEFAULT_CAMERA, 500).fieldOfView, 179);
  assert.equal(withFieldOfView(DEFAULT_CAMERA, -5).fieldOfView, 0.01);
});

test('pivotDistance: level with the middle of the scene, never behind the camera', () => {
  const bounds = { low: [-1, -1, -11] as Vec3, high: [1, 1, -9] as Vec3 };
  assert.equal(pivotDistance(DEFAULT_CAMERA, bounds, 20), 10);
  assert.equal(pivotDistance({ ...DEFAULT_CAMERA, forward: [0, 0, 1] }, bounds, 20), 2);
});

test('framing: all of the scene is in view, also in a window that is higher than wide', () => {
  const bounds: Bounds = { low: [0, 0, 0], high: [2, 4, 6] };
  const forward = normalize([1, -1, 1]);
  const up = normalize([1, 2, 1]);
  for (const aspect of [0.5, 1, 2]) {
    const camera = framing({ ...DEFAULT_CAMERA, forward, up, fieldOfView: 50 }, bounds, aspect);
    const tangent = Math.tan((25 * Math.PI) / 180);
    for (const corner of [0, 1, 2, 3, 4, 5, 6, 7]) {
      const at: Vec3 = [corner & 1 ? 2 : 0, corner & 2 ? 4 : 0, corner & 4 ? 6 : 0];
      const to = subtract(at, camera.position);
      const depth = dot(to, camera.forward);
      assert.ok(depth > 0 && Math.abs(dot(to, camera.up)) <= depth * tangent * 1.0001, `corner ${corner}`);
      assert.ok(Math.abs(dot(to, rightOf(camera))) <= depth * tangent * aspect * 1.0001, `corner ${corner}`);
    }
  }
});
