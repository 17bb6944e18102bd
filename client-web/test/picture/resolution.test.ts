import assert from 'node:assert/strict';
import { test } from 'node:test';
import { frameSizeText } from '../../src/picture/resolution.js';

test('a picture that is smaller than the full one says of what', () => {
  const full = { fullWidth: 1280, fullHeight: 720 };
  assert.equal(frameSizeText({ width: 1280, height: 720, ...full }), '1280 × 720 px');
  assert.equal(frameSizeText({ width: 569, height: 320, ...full }), '569 × 320 of 1280 × 720 px');
});
