import assert from 'node:assert/strict';
import { test } from 'node:test';
import { brokenText, progressText } from '../src/upload/upload_progress.js';

test('progressText: share and bytes at once, the time left when the line is known', () => {
  const sent = { loaded: 5e6, total: 20e6, ms: 1000 };
  assert.equal(progressText('boat.glb', sent), 'Uploading boat.glb: 25 %, 5 MB of 20 MB');
  assert.equal(progressText('boat.glb', { ...sent, ms: 4000 }), 'Uploading boat.glb: 25 %, 5 MB of 20 MB, 12 s left');
  assert.equal(progressText('boat.glb', { ...sent, loaded: 0, ms: 4000 }), 'Uploading boat.glb: 0.00 %, 0 kB of 20 MB');
  assert.equal(progressText('boat.glb', { ...sent, loaded: 20e6 }), 'Uploading boat.glb: all is sent, the server reads it');
});

test('brokenText: how far it came, and that nothing of it is kept', () => {
  const text = brokenText('boat.glb', { loaded: 5e6, total: 20e6, ms: 1000 });
  assert.ok(text.includes('25 % of boat.glb') && text.includes('keeps nothing'), text);
  assert.ok(brokenText('boat.glb', { loaded: 0, total: 0, ms: 0 }).includes('0.00 %'));
});
