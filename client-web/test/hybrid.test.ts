import assert from 'node:assert/strict';
import { test } from 'node:test';
import { withoutUse } from '../src/hybrid_rows.js';

test('withoutUse: hybrid settings count with device hybrid, the share only when the balance is manual', () => {
  const reason = (name: string, device: string, hybridBalance: string): string | null =>
    withoutUse(name, (asked) => ({ device, hybridBalance })[asked]);
  for (const name of ['hybridBalance', 'hybridShare', 'enableEmbree', 'enableVulkan']) {
    assert.equal(reason(name, 'embree', 'manual'), 'Only with device hybrid.');
  }
  for (const name of ['hybridBalance', 'enableEmbree', 'enableVulkan']) {
    assert.equal(reason(name, 'hybrid', 'auto'), null);
  }
  assert.equal(reason('hybridShare', 'hybrid', 'auto'), 'Only with a manual balance.');
  assert.equal(reason('hybridShare', 'hybrid', 'manual'), null);
  assert.equal(reason('showPartition', 'embree', 'auto'), null);
  assert.equal(reason('samples', 'embree', 'auto'), null);
});
