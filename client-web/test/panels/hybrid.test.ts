import assert from 'node:assert/strict';
import { test } from 'node:test';
import { deviceRows, schedulerFacts } from '../../src/panels/statistics/device_rows.js';
import { duration } from '../../src/page/format.js';
import { withoutUse } from '../../src/panels/settings/hybrid_rows.js';
import { parseMessage, type Stats } from '../../src/wire/protocol.js';

test('withoutUse: hybrid settings count with device hybrid, the share only when the balance is manual', () => {
  const reason = (name: string, device: string, hybridBalance: string): string | null =>
    withoutUse({ name, group: name === 'samples' ? 'picture' : 'hybrid' }, (asked) => ({ device, hybridBalance })[asked]);
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

function stats(fields: object): Stats {
  const message = parseMessage(JSON.stringify({ type: 'stats', ...fields }));
  assert.ok(message?.type === 'stats');
  return message;
}

const PARTS = [
  { device: 'embree', part: 'works', reason: '', mraysPerSecond: 38.7, share: 0.34, idleShare: 0.04 },
  { device: 'vulkan:0', part: 'probes', reason: 'its rate is not known yet', mraysPerSecond: 0, share: 0.01 },
  { device: 'vulkan:1', part: 'parked', reason: 'it would gain 1.2 %', mraysPerSecond: 0.9, share: 0, idleShare: 1 },
  { device: 'node-a', part: 'lost', reason: '', mraysPerSecond: 0, share: 0 },
];

test('stats: parts and scheduler, which an older server leaves out', () => {
  const old = stats({ tiles: { embree: 3 } });
  assert.deepEqual([old.parts, old.scheduler], [[], null]);
  const scheduler = { endLossMs: 0.31, decisionMs: 0.042, batches: 37, reissued: 1 };
  const read = stats({ parts: PARTS, scheduler });
  assert.deepEqual(read.scheduler, scheduler);
  assert.deepEqual(read.parts[1], { ...PARTS[1], idleShare: 0 });
});

test('deviceRows: share and figures of who works, the reason of who does not, tiles where nothing else is stated', () => {
  assert.deepEqual(deviceRows({ embree: 1, 'vulkan:0': 3 }, []), [
    { device: 'embree', share: 0.25, text: '1', note: '' },
    { device: 'vulkan:0', share: 0.75, text: '3', note: '' },
  ]);
  const rows = deviceRows({ embree: 810, 'vulkan:0': 12, raster: 1 }, stats({ parts: PARTS }).parts);
  assert.deepEqual(
    rows.map(({ device, text, note }) => [device, text, note]),
    [
      ['embree', '34 %', '810 tiles \u00b7 38.7 Mrays/s \u00b7 4.0 % idle'],
      ['vulkan:0', '1.0 %', 'probes: its rate is not known yet'],
      ['vulkan:1', 'parked', 'it would gain 1.2 %'],
      ['node-a', 'lost', ''],
      ['raster', '1', ''],
    ],
  );
});

test('schedulerFacts: nothing without a scheduler, else times in fitting units', () => {
  assert.ok(schedulerFacts(null).every(([, text]) => text === null));
  const facts = schedulerFacts({ endLossMs: 0.31, decisionMs: 0.042, batches: 1037, reissued: 1 });
  assert.deepEqual(
    facts.map(([, text]) => text),
    ['0.31 ms', '42 \u00b5s', '1\u202f037', '1 batch'],
  );
  assert.deepEqual([0, 0.0012, 0.0996, 12.34].map(duration), ['0.00 ms', '1.2 \u00b5s', '0.10 ms', '12.3 ms']);
});
