import assert from 'node:assert/strict';
import { test } from 'node:test';
import { pageTitle } from '../../src/page/scene_name.js';
import { TimeLeft, waitText } from '../../src/picture/time_left.js';

test('TimeLeft: by the samples of this picture alone', () => {
  const left = new TimeLeft();
  assert.equal(left.until(64, 0), null);
  left.shown(1, 1000);
  left.shown(2, 1100);
  assert.equal(left.until(64, 1100), null, 'too early to say');
  left.shown(11, 2000);
  assert.equal(left.until(64, 2000), 5300);
  assert.equal(left.until(64, 3000), 4300);
  assert.equal(left.until(11, 3000), null);
  left.shown(1, 9000); // the camera moved
  assert.equal(left.until(64, 9500), null);
});

test('waitText and pageTitle', () => {
  assert.deepEqual([5300, 100_000, 8_000_000, 10].map(waitText), ['5 s', '2 min', '2 h', '1 s']);
  assert.equal(pageTitle('cornell', true), '✓ Cornell · Heliograph');
  assert.equal(pageTitle('cornell', false), 'Cornell · Heliograph');
  assert.equal(pageTitle('', true), 'Heliograph');
});
