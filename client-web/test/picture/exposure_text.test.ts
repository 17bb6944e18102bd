import assert from 'node:assert/strict';
import { test } from 'node:test';
import { exposureText } from '../../src/picture/exposure_text.js';

test('exposureText: a sign and a tenth', () => {
  assert.equal(exposureText(1.26), '+1.3 EV');
  assert.equal(exposureText(-9.44), '−9.4 EV');
  assert.equal(exposureText(-0.01), '+0.0 EV');
});
