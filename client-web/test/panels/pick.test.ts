import assert from 'node:assert/strict';
import { test } from 'node:test';
import { lookingAt, placeOf, type Camera } from '../../src/camera/camera.js';
import { PickModel } from '../../src/panels/pick/pick_model.js';
import { lengthText, normalText, titleOf } from '../../src/panels/pick/pick_words.js';
import type { PickedSurface } from '../../src/wire/picked_message.js';
import { parseMessage } from '../../src/wire/protocol.js';

const surface = (position: readonly [number, number, number]): PickedSurface => ({
  object: 'chair',
  material: 'oak',
  distance: 3,
  depth: 3,
  position,
  normal: [0, 1, 0],
});

function model(): { pick: PickModel; asked: number[] } {
  const asked: number[] = [];
  return { asked, pick: new PickModel((id) => asked.push(id), () => undefined) };
}

test('the newest question alone is answered', () => {
  const { pick, asked } = model();
  pick.ask(0.1, 0.1);
  pick.ask(0.5, 0.5);
  pick.answered({ type: 'picked', id: asked[0]!, surface: surface([9, 9, 9]) });
  assert.deepEqual({ ...pick.state }, { name: 'asked' });
  pick.answered({ type: 'picked', id: asked[1]!, surface: null });
  assert.deepEqual({ ...pick.state }, { name: 'nothing' });
  pick.answered({ type: 'picked', id: asked[1]!, surface: surface([9, 9, 9]) });
  assert.deepEqual({ ...pick.state }, { name: 'nothing' });
});

test('two points are measured, from where the viewer said', () => {
  const { pick, asked } = model();
  pick.measure();
  assert.equal(pick.from, null);
  const point = (x: number): void => {
    pick.ask(0, 0);
    pick.answered({ type: 'picked', id: asked.at(-1)!, surface: surface([x, 0, 4]) });
  };
  point(1);
  pick.measure();
  assert.equal(pick.measured, null);
  point(4);
  assert.equal(pick.measured, 3);
  pick.forget();
  assert.equal(pick.from, null);
  assert.equal(pick.measured, null);
});

test('a point in the picture is where the camera sees it', () => {
  const camera: Camera = { position: [1, 2, 3], forward: [0, 0, -1], up: [0, 1, 0], fieldOfView: 90 };
  assert.deepEqual(placeOf(camera, [1, 2, -7], 2), { x: 0.5, y: 0.5 });
  const corner = placeOf(camera, [1 + 20, 2 + 10, -7], 2)!; // 10 ahead, where the picture is 40 x 20
  assert.ok(Math.abs(corner.x - 1) < 1e-12 && Math.abs(corner.y) < 1e-12, JSON.stringify(corner));
  assert.equal(placeOf(camera, [1, 2, 4], 2), null);
});

test('looking at a point brings it into the middle, also straight above', () => {
  const camera: Camera = { position: [0, 0, 0], forward: [0, 0, -1], up: [0, 1, 0], fieldOfView: 60 };
  for (const point of [[3, 1, -2], [0, 5, 0], [0, 0, 8]] as const) {
    const place = placeOf(lookingAt(camera, point), point, 1.5)!;
    assert.ok(Math.abs(place.x - 0.5) < 1e-9 && Math.abs(place.y - 0.5) < 1e-9, String(point));
  }
  assert.equal(lookingAt(camera, [0, 0, 0]), camera);
});

test('lengths have a unit that fits, normals a word where they lie along an axis', () => {
  assert.deepEqual([0, 0.0042, 0.5, 12.345, 4200].map(lengthText), ['0 m', '4.2 mm', '50 cm', '12.3 m', '4.2 km']);
  assert.equal(normalText([0, 1, 0]), 'up (+y)');
  assert.equal(normalText([-0.6, 0.8, 0]), '−0.60, 0.80, 0.00');
  assert.equal(normalText([0, 0, 0]), 'none');
  assert.equal(titleOf({ object: '', material: 'oak' }), 'oak');
  assert.equal(titleOf({ object: '', material: '' }), 'A surface');
});

test('the message is read, and a broken one is refused by its field', () => {
  const found = { type: 'picked', id: 4, found: true, object: 'a', position: [1, 2, 3], normal: [0, 0, 1], distance: 2, depth: 1 };
  const message = parseMessage(JSON.stringify(found));
  assert.ok(message?.type === 'picked' && message.surface?.object === 'a' && message.surface.material === '');
  assert.throws(() => parseMessage(JSON.stringify({ ...found, position: [1, 2] })), /picked.position/);
  const nothing = parseMessage('{"type":"picked","id":4,"found":false}');
  assert.ok(nothing?.type === 'picked' && nothing.surface === null);
});
