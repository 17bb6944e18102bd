import assert from 'node:assert/strict';
import { test } from 'node:test';
import { CameraController } from '../../src/camera/camera_controller.js';
import { DEFAULT_CAMERA, type Camera } from '../../src/camera/camera.js';
import { LONG_PRESS_MS, LongPress } from '../../src/camera/long_press.js';
import { length, subtract } from '../../src/camera/vector.js';

/** A controller whose animation frames and pauses the test runs by hand. */
function setUp() {
  const sent: { camera: Camera; moving: boolean; eventTime: number | null }[] = [];
  let scheduled = 0;
  let rest: number | null = null;
  const controller = new CameraController({
    schedule: () => (scheduled += 1),
    restAfter: (ms) => (rest = ms),
    send: (camera, moving, eventTime) => sent.push({ camera, moving, eventTime }),
    changed: () => undefined,
  });
  controller.viewHeight = 600;
  controller.setScene({ low: [-5, -5, -5], high: [5, 5, 5] }, 10);
  return { controller, sent, scheduled: () => scheduled, rest: () => rest };
}

test('CameraController: many events between two animation frames become one camera with the first one\u2019s time', () => {
  const { controller, sent, scheduled } = setUp();
  for (let i = 0; i < 10; i += 1) controller.turn(3, 1, false, 1000 + i);
  assert.equal(sent.length, 0);
  assert.equal(scheduled(), 1);
  controller.step(1016);
  assert.equal(sent.length, 1);
  assert.deepEqual([sent[0]!.moving, sent[0]!.eventTime], [true, 1000]);
});

test('CameraController: after the last input comes one resting camera', () => {
  const { controller, sent, rest } = setUp();
  controller.turn(3, 0, false, 0);
  controller.step(16);
  assert.equal(rest(), 120);
  controller.rest(136);
  controller.rest(300);
  assert.deepEqual(
    sent.map((entry) => entry.moving),
    [true, false],
  );
  assert.deepEqual(sent[1]!.camera, sent[0]!.camera);
});

test('CameraController: letting go sends what is not yet sent, as resting', () => {
  const { controller, sent } = setUp();
  controller.turn(3, 0, false, 5);
  controller.end(10);
  assert.deepEqual(
    sent.map((entry) => [entry.moving, entry.eventTime]),
    [[false, 5]],
  );
  controller.step(16);
  controller.end(20);
  assert.equal(sent.length, 1);
});

test('CameraController: distance flown depends on time, not on the number of animation frames', () => {
  const flown = (frames: number): number => {
    const { controller } = setUp();
    controller.press('forward', 0);
    controller.step(0);
    const begin = controller.camera.position;
    for (let i = 1; i <= frames; i += 1) controller.step((960 * i) / frames);
    return length(subtract(controller.camera.position, begin));
  };
  assert.ok(Math.abs(flown(60) - 0.2 * 10 * 0.96) < 1e-9);
  assert.ok(Math.abs(flown(60) - flown(12)) < 1e-9);
});

test('CameraController: faster and slower are ten and a tenth', () => {
  const flown = (modifier: 'faster' | 'slower' | null): number => {
    const { controller } = setUp();
    controller.press('forward', 0);
    if (modifier !== null) controller.press(modifier, 0);
    controller.step(0);
    return length(subtract(controller.camera.position, DEFAULT_CAMERA.position));
  };
  const plain = flown(null);
  assert.ok(plain > 0);
  assert.ok(Math.abs(flown('faster') / plain - 10) < 1e-9);
  assert.ok(Math.abs(flown('slower') / plain - 0.1) < 1e-9);
});

test('CameraController: a stick that is half pushed flies half as fast, and rests once when it is let go', () => {
  const { controller, sent } = setUp();
  controller.push('gamepad', { forward: 0.5 }, 0);
  controller.step(0);
  const begin = controller.camera.position;
  for (let time = 16; time <= 960; time += 16) controller.step(time);
  assert.ok(Math.abs(length(subtract(controller.camera.position, begin)) - 0.5 * 0.2 * 10 * 0.96) < 1e-9);
  assert.ok(sent.every(({ moving }) => moving));
  controller.press('right', 970);
  controller.push('gamepad', null, 980);
  assert.equal(sent.at(-1)?.moving, true, 'a key is still held');
  controller.release('right', 990);
  assert.equal(sent.at(-1)?.moving, false);
  const count = sent.length;
  controller.push('gamepad', null, 1000);
  assert.equal(sent.length, count);
});

test('CameraController: sticks and keys add up, and nothing is pushed any more when the window loses the focus', () => {
  const { controller } = setUp();
  controller.push('thumb', { right: 1, up: 1 }, 0);
  controller.press('left', 0);
  controller.step(0);
  const [x, y] = controller.camera.position;
  assert.ok(Math.abs(x) < 1e-12 && y > 0, `${x}, ${y}`);
  controller.releaseAll(10);
  controller.step(16);
  controller.step(32);
  assert.equal(controller.camera.position[1], y);
});

test('CameraController: a held modifier alone moves nothing and says nothing', () => {
  const { controller, sent } = setUp();
  controller.press('faster', 0);
  controller.step(16);
  controller.release('faster', 20);
  assert.equal(sent.length, 0);
});

test('CameraController: while the server moves the camera, input is ignored', () => {
  const { controller, sent } = setUp();
  controller.enabled = false;
  controller.turn(30, 0, false, 0);
  controller.press('forward', 0);
  controller.step(16);
  controller.end(20);
  assert.equal(sent.length, 0);
  assert.deepEqual(controller.camera, DEFAULT_CAMERA);
});

test('CameraController: zooming in orbit mode never reaches the pivot', () => {
  const { controller } = setUp();
  controller.jump({ ...DEFAULT_CAMERA, position: [0, 0, 20] });
  controller.setMode('orbit');
  for (let i = 0; i < 200; i += 1) controller.wheel(-100, i);
  const z = controller.camera.position[2];
  assert.ok(z > 0 && z < 0.1, `z = ${z}`);
});

test('CameraController: jump is sent at once as resting, resend repeats it', () => {
  const { controller, sent } = setUp();
  const camera: Camera = { ...DEFAULT_CAMERA, position: [1, 2, 3] };
  controller.jump(camera);
  controller.resend();
  assert.deepEqual(
    sent.map((entry) => [entry.camera, entry.moving, entry.eventTime]),
    [
      [camera, false, null], // no motion of the viewer, whose delay would be measured
      [camera, false, null],
    ],
  );
});

test('CameraController: a finger turns enough to look around, a pinch comes nearer by small steps', () => {
  const { controller } = setUp();
  controller.viewHeight = 844; // a phone
  controller.turn(100, 0, true, 0);
  const [x, , z] = controller.camera.forward;
  const degrees = (Math.abs(Math.atan2(x, -z)) * 180) / Math.PI;
  assert.ok(degrees > 14 && degrees < 25, `${degrees} degrees for 100 pixels`);
  const before = controller.camera.position;
  controller.pinch(5, 1); // fingers from 60 to 300 pixels
  const way = length(subtract(controller.camera.position, before));
  assert.ok(way > 1 && way < 4, `${way} of a radius of 10`);
});

/** What a long press says after each step; `elapsed` only where a timer runs. */
function press(steps: (finger: LongPress) => void): readonly (readonly [number, number])[] {
  const pressed: (readonly [number, number])[] = [];
  let timer: number | null = null;
  const finger = new LongPress({ after: (ms) => (timer = ms), pressed: (x, y) => pressed.push([x, y]) });
  steps(finger);
  if (timer === LONG_PRESS_MS) finger.elapsed();
  return pressed;
}

test('LongPress: one resting finger counts at the place where it came down', () => {
  const resting = press((finger) => {
    finger.down(50, 60);
    finger.move(55, 63);
  });
  assert.deepEqual(resting, [[50, 60]]);
});

test('LongPress: dragging, letting go and a second finger are none', () => {
  const dragging = press((finger) => {
    finger.down(50, 60);
    finger.move(62, 60);
    finger.move(50, 60);
  });
  const letGo = press((finger) => {
    finger.down(50, 60);
    finger.up();
  });
  const pinching = press((finger) => {
    finger.down(50, 60);
    finger.down(90, 60);
    finger.up();
  });
  assert.deepEqual([dragging, letGo, pinching], [[], [], []]);
});
