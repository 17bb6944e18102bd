import assert from 'node:assert/strict';
import test from 'node:test';
import { eased, pressedButtons, pushOf, type PadState } from '../../src/camera/gamepad.js';

const pad = (axes: number[], pressed: readonly number[] = []): PadState => ({
  axes,
  buttons: Array.from({ length: 16 }, (_, i) => ({ value: Number(pressed.includes(i)), pressed: pressed.includes(i) })),
});

test('eased: nothing near the middle, all at the end, finer between', () => {
  assert.deepEqual([0, 0.1, -0.15, 1, -1, 1.2].map(eased), [0, 0, 0, 1, -1, 1]);
  assert.ok(eased(0.575) > 0.2 && eased(0.575) < 0.3);
  assert.equal(eased(NaN), 0);
});

test('pushOf: up on the sticks is ahead and up, triggers go down and up, a shoulder alone moves nothing', () => {
  assert.equal(pushOf(pad([0.1, -0.1, 0, 0.05])), null);
  assert.deepEqual(pushOf(pad([0, -1, 0, -1])), { right: 0, forward: 1, turnRight: 0, turnUp: 1, up: 0, faster: 0 });
  assert.equal(pushOf(pad([0, 0, 0, 0], [6]))?.up, -1);
  assert.equal(pushOf(pad([0, 0, 0, 0], [5])), null);
  assert.equal(pushOf(pad([1, 0, 0, 0], [5]))?.faster, 1);
  assert.equal(pushOf(pad([])), null, 'a gamepad of another layout');
});

test('pressedButtons: once for each press', () => {
  let calls = 0;
  const actions = { 3: () => void (calls += 1) };
  let pressed: ReadonlySet<number> = new Set();
  for (const down of [[3], [3], [], [3, 9]]) pressed = pressedButtons(pad([], down), pressed, actions);
  assert.deepEqual([calls, [...pressed]], [2, [3]]);
});
