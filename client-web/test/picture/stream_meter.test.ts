import assert from 'node:assert/strict';
import { test } from 'node:test';
import { deviceRows } from '../../src/panels/statistics/device_rows.js';
import { StreamMeter } from '../../src/picture/stream_meter.js';
import type { Frame } from '../../src/wire/frame.js';

const frame = (inputId: number): Frame => ({ inputId }) as Frame;

test('StreamMeter: seldom frames have a rate below one, never zero', () => {
  const meter = new StreamMeter();
  assert.equal(meter.shownRate(0, 1500), null);
  meter.presented(frame(1), 1, 1000, 1000);
  meter.presented(frame(1), 1, 3000, 3000);
  assert.equal(meter.shownRate(3100, 15_000), 0.5);
  assert.equal(meter.shownRate(7000, 15_000), 0.25);
  assert.equal(meter.shownRate(7000, 1500), null);
  for (let time = 7000; time < 8000; time += 100) meter.presented(frame(1), 1, time, time);
  assert.equal(meter.shownRate(7950, 1500), 10);
});

test('StreamMeter: no motion to photon before any motion', () => {
  const meter = new StreamMeter();
  assert.equal(meter.presented(frame(3), 1, 1000, 1000), null);
  assert.equal(meter.motionToPhoton.window.quantile(0.5), null);
});

test('deviceRows: tiles of a device that makes no pictures any more are not shown', () => {
  const names = (kinds: readonly string[]): readonly string[] =>
    deviceRows({ embree: 10, 'vulkan:0': 20 }, [], kinds).map((row) => row.device);
  assert.deepEqual(names(['vulkan']), ['vulkan:0']);
  assert.deepEqual(names(['embree', 'vulkan']), ['embree', 'vulkan:0']);
  assert.deepEqual(names([]), ['embree', 'vulkan:0']);
  assert.equal(deviceRows({ embree: 10, 'vulkan:0': 20 }, [], ['vulkan'])[0]?.share, 1);
});
