import assert from 'node:assert/strict';
import { test } from 'node:test';
import { deviceColor, kindOf, knowDevices, rgbOf } from '../../src/panels/device_colors.js';
import { ProtocolError } from '../../src/wire/frame.js';
import { borderLines, describePartition, pixelShares } from '../../src/panels/partition/partition.js';
import { NOBODY, type Partition, type Timeline, type Track } from '../../src/wire/partition_message.js';
import { pictureBox, placeInPicture } from '../../src/picture/picture_box.js';
import { parseMessage } from '../../src/wire/protocol.js';
import { MapStore } from '../../src/panels/map_store.js';
import { ShownMap } from '../../src/panels/shown_map.js';
import { busyBins, busyShare, describeAt, MOST_ROWS, timelineRows } from '../../src/panels/partition/timeline.js';

/** 50 x 20 pixels in cells of 16 x 16: 4 columns, 2 rows, the last ones 2 and 4 pixels. */
const MESSAGE = {
  type: 'partition',
  frameId: 7,
  width: 50,
  height: 20,
  cellWidth: 16,
  cellHeight: 16,
  devices: ['embree', 'vulkan:0'],
  cells: '0011011.',
  timeline: {
    ms: 10,
    workers: [
      {
        device: 'embree',
        worker: 0,
        batches: [
          [0, 4, 3],
          [6, 8, 1],
        ],
      },
      { device: 'vulkan:0', worker: 0, batches: [[1, 9, 4]] },
      { device: 'embree', worker: 1, batches: [] },
    ],
  },
};

function partition(changes: object = {}): Partition {
  const message = parseMessage(JSON.stringify({ ...MESSAGE, ...changes }));
  assert.ok(message?.type === 'partition');
  return message;
}

const timeline = (): Timeline => partition().timeline!;

test('partition: reads cells and timeline', () => {
  const read = partition();
  assert.deepEqual([read.frameId, read.columns, read.rows], [7, 4, 2]);
  assert.deepEqual([...read.owners], [0, 0, 1, 1, 0, 1, 1, NOBODY]);
  assert.deepEqual(read.timeline?.workers[0]?.batches[1], { beginMs: 6, endMs: 8, cells: 1 });
  assert.equal(partition({ timeline: undefined }).timeline, null);
});

test('partition: digits go up to z', () => {
  const devices = Array.from({ length: 36 }, (_, i) => `node${i}`);
  assert.deepEqual([...partition({ devices, cells: '09azz.aa' }).owners], [0, 9, 10, 35, 35, NOBODY, 10, 10]);
});

test('partition: a device that is wrong about its times spoils nothing', () => {
  const workers = [
    {
      device: 'embree',
      worker: 0,
      batches: [
        [4, 2, 1],
        [1, 3, 1],
      ],
    },
  ];
  const read = partition({ timeline: { ms: 5, workers } }).timeline!;
  assert.deepEqual(read.workers[0]?.batches[0], { beginMs: 4, endMs: 4, cells: 1 });
  assert.deepEqual([...busyBins(timelineRows(read)[0]!, 5, 5)], [0, 1, 1, 0, 0]);
});

test('partition: refuses what does not fit together, naming the field', () => {
  const bad: readonly (readonly [RegExp, object])[] = [
    [/partition\.cells: 7 cells, allowed: 8/, { cells: '0011011' }],
    [/partition\.cells: undefined/, { cells: undefined }],
    [/partition\.cells\[2\]: "2"/, { cells: '0021011.' }],
    [/partition\.cells\[0\]: "A"/, { cells: 'A0110110' }],
    [/partition\.cellWidth: 0/, { cellWidth: 0 }],
    [/partition\.width: 1\.5/, { width: 1.5 }],
    [/partition\.frameId/, { frameId: -1 }],
    [/partition\.devices: 37/, { devices: new Array<string>(37).fill('x') }],
    [/partition\.timeline\.ms/, { timeline: { ms: -1, workers: [] } }],
    [/partition\.timeline batch: \[4\]/, { timeline: { ms: 5, workers: [{ batches: [[4]] }] } }],
  ];
  for (const [words, changes] of bad) {
    assert.throws(
      () => partition(changes),
      (error) => error instanceof ProtocolError && words.test(error.message),
      String(words),
    );
  }
});

test('pixelShares: counts pixels, the cells at the edges are smaller', () => {
  const shares = pixelShares(partition());
  // Row 0: 2 and 16 + 2 columns of 16 lines; row 1 (4 lines): 16, 32 and 2 pixels of nobody.
  assert.deepEqual(shares, [(32 * 16 + 16 * 4) / 1000, (18 * 16 + 32 * 4) / 1000, 8 / 1000]);
  assert.ok(Math.abs(shares.reduce((sum, share) => sum + share, 0) - 1) < 1e-12);
});

test('borderLines: only between cells of different devices, joined, and no longer than the picture', () => {
  assert.deepEqual(borderLines(partition()), [
    { x0: 16, y0: 16, x1: 16, y1: 20 },
    { x0: 32, y0: 0, x1: 32, y1: 16 },
    { x0: 48, y0: 16, x1: 48, y1: 20 },
    { x0: 16, y0: 16, x1: 32, y1: 16 },
    { x0: 48, y0: 16, x1: 50, y1: 16 },
  ]);
  assert.deepEqual(borderLines(partition({ cells: '11111111' })), []);
  assert.deepEqual(borderLines(partition({ cells: '00001111' })), [{ x0: 0, y0: 16, x1: 50, y1: 16 }]);
});

test('MapStore: a partition goes with its frame only, older ones are forgotten', () => {
  const store = new MapStore<Partition>();
  for (const frameId of [1, 2, 4]) store.put(partition({ frameId }));
  assert.equal(store.take(3), null);
  assert.equal(store.take(2), null);
  assert.equal(store.take(4)?.frameId, 4);
  assert.equal(store.take(4), null);
  store.put(partition({ frameId: 5 }));
  store.clear();
  assert.equal(store.take(5), null);
});

test('MapStore: ids may wrap, and what waits has an end', () => {
  const store = new MapStore<Partition>();
  store.put(partition({ frameId: 0xffffffff }));
  store.put(partition({ frameId: 0 }));
  assert.equal(store.take(0xffffffff)?.frameId, 0xffffffff);
  assert.equal(store.take(0)?.frameId, 0);
  for (let frameId = 1; frameId <= 100; frameId += 1) store.put(partition({ frameId }));
  assert.equal(store.take(50), null);
});

test('ShownMap: goes with its picture, while it is wanted and nothing else is shown', () => {
  let wanted = true;
  let changes = 0;
  const model = new ShownMap<Partition>(
    () => wanted,
    () => (changes += 1),
  );
  const draw = (frameId: number): void => model.drawn({ frameId, width: 50, height: 20 });
  draw(1);
  assert.deepEqual([model.shown, changes], [null, 0]);
  model.received(partition({ frameId: 2 }));
  model.received(partition({ frameId: 3 }));
  draw(2);
  assert.equal(model.shown?.map.frameId, 2);
  model.settingsChanged();
  assert.equal(model.shown?.map.frameId, 2, 'it is still wanted');
  wanted = false;
  model.settingsChanged();
  assert.deepEqual([model.shown, changes], [null, 2]);
  draw(3);
  assert.equal(model.shown, null, 'not wanted');
  wanted = true;
  for (const frameId of [4, 5]) model.received(partition({ frameId }));
  draw(4);
  model.forget();
  assert.equal(model.shown, null);
  draw(5);
  assert.equal(model.shown, null, 'of another scene');
});

test('describePartition: time, shares, workers and how busy they were', () => {
  assert.equal(
    describePartition(partition()),
    'The frame took 10.0 ms. embree: 58 % of the picture, 2 workers, busy 30 %. ' +
      'vulkan:0: 42 % of the picture, 1 worker, busy 80 %.',
  );
});

test('timelineRows: workers of a device stand together; too many become one row per device', () => {
  assert.deepEqual(
    timelineRows(timeline()).map((row) => row.label),
    ['embree worker 0', 'embree worker 1', 'vulkan:0 worker 0'],
  );
  const track = (worker: number): Track => ({
    device: 'embree',
    worker,
    batches: [{ beginMs: 0, endMs: 5, cells: 2 }],
  });
  const many = Array.from({ length: MOST_ROWS }, (_, i) => track(i));
  assert.equal(timelineRows({ ms: 10, workers: many }).length, MOST_ROWS);
  const rows = timelineRows({ ms: 10, workers: [...many, { ...track(0), device: 'vulkan:0' }] });
  assert.deepEqual(
    rows.map((row) => row.label),
    ['embree, 32 workers', 'vulkan:0 worker 0'],
  );
  assert.equal(describeAt(rows[0]!, 10, 1, 0), 'embree, 32 workers: 64 cells, busy 50 %');
});

test('busyBins: shares of each part; overlapping batches of a worker count once', () => {
  const row = timelineRows(timeline())[0]!;
  assert.deepEqual([...busyBins(row, 10, 5)], [1, 1, 0, 1, 0]);
  const quarters = [...busyBins(row, 10, 4)].map((share) => Number(share.toFixed(9)));
  assert.deepEqual(quarters, [1, 0.6, 0.6, 0.2]);
  const overlapping: Track = {
    device: 'vulkan:0',
    worker: 0,
    batches: [
      { beginMs: 0, endMs: 6, cells: 1 },
      { beginMs: 4, endMs: 50, cells: 1 },
    ],
  };
  const both = { device: 'vulkan:0', label: '', tracks: [overlapping, { ...overlapping, batches: [] }] };
  assert.deepEqual([...busyBins(both, 10, 2)], [0.5, 0.5]);
  assert.deepEqual([...busyBins(both, 0, 2)], [0, 0]);
});

test('busyShare: overlaps count once, workers without a batch are idle', () => {
  const batches = [
    { beginMs: 0, endMs: 6, cells: 1 },
    { beginMs: 4, endMs: 8, cells: 1 },
  ];
  const row = (tracks: readonly Track[]) => ({ device: 'embree', label: '', tracks });
  const busy = { device: 'embree', worker: 0, batches };
  assert.equal(busyShare(row([busy]), 10), 0.8);
  assert.equal(busyShare(row([busy, { ...busy, batches: [] }]), 10), 0.4);
  assert.equal(busyShare(row([busy]), 0), 0);
});

test('describeAt: the batch under the pointer, the nearest one within reach, else idle', () => {
  const row = timelineRows(timeline())[0]!;
  assert.equal(describeAt(row, 10, 7, 0), 'embree worker 0: 1 cell, 6.0\u20138.0 ms');
  assert.equal(describeAt(row, 10, 4.3, 0.5), 'embree worker 0: 3 cells, 0.0\u20134.0 ms');
  assert.equal(describeAt(row, 10, 5, 0.5), 'embree worker 0: idle at 5.0 ms');
});

test('pictureBox: covers the window, centred, and finds places in the picture', () => {
  assert.deepEqual(pictureBox(200, 100, 400, 200), { x: 0, y: 0, width: 400, height: 200 });
  const wide = pictureBox(200, 100, 100, 100);
  assert.deepEqual(wide, { x: -50, y: 0, width: 200, height: 100 });
  assert.deepEqual(placeInPicture(wide, 0, 25), { x: 0.25, y: 0.25 });
  assert.equal(placeInPicture(wide, 0, 101), null);
});

/** How much of red and green (and of their difference in blue) those without green or red cones see as one colour. */
const VISIONS = { all: null, 'no green cones': [0.29275, -0.02234], 'no red cones': [0.11238, 0.00401] } as const;

/** CIE L*a*b* of sRGB 0..255 as seen with that vision (F. Vienot, H. Brettel, J. Mollon, 1999). */
function seenLab(rgb: readonly number[], vision: readonly [number, number] | null): readonly number[] {
  const linear = rgb.map((v) => (v <= 10.31 ? v / 255 / 12.92 : ((v / 255 + 0.055) / 1.055) ** 2.4));
  const [r, g, b] = linear as [number, number, number];
  const yellow = vision === null ? 0 : vision[0] * r + (1 - vision[0]) * g;
  const [x, y, z] = vision === null ? [r, g, b] : [yellow, yellow, b + vision[1] * (r - g)];
  const f = (t: number): number => (t > 0.008856 ? Math.cbrt(t) : 7.787 * t + 16 / 116);
  const fx = f((0.4124 * x + 0.3576 * y + 0.1805 * z) / 0.9505);
  const fy = f(0.2126 * x + 0.7152 * y + 0.0722 * z);
  const fz = f((0.0193 * x + 0.1192 * y + 0.9505 * z) / 1.089);
  return [116 * fy - 16, 500 * (fx - fy), 200 * (fy - fz)];
}

const DEVICE_KINDS = [
  { name: 'embree', words: ['embree'], kind: 'processor', side: 'cpu', bit: 0 },
  { name: 'vulkan', words: ['vulkan', 'vulkan:0'], kind: 'gpu', side: 'gpu', bit: 1 },
  { name: 'grey', words: ['grey'], kind: 'processor', side: 'cpu', bit: 4 },
];

test('deviceColor: steady, and told apart also without green or red cones', () => {
  knowDevices(DEVICE_KINDS);
  const names = ['embree', 'vulkan:0', 'vulkan:1', 'vulkan:2', 'node-a', 'node-b', 'node-c', 'node-d'];
  const colors = names.map(deviceColor);
  assert.deepEqual(names.map(deviceColor), colors);
  assert.equal(deviceColor('vulkan'), deviceColor('vulkan:0'));
  assert.equal(deviceColor('embree'), '#4f9cff');
  for (const [name, vision] of Object.entries(VISIONS)) {
    for (const [i, a] of colors.entries()) {
      for (const [j, b] of colors.slice(0, i).entries()) {
        const [p, q] = [seenLab(rgbOf(a), vision), seenLab(rgbOf(b), vision)];
        const away = Math.hypot(...p.map((value, k) => value - q[k]!));
        assert.ok(away > 15, `${names[i]} and ${names[j]}: ${away.toFixed(1)}, ${name}`);
      }
    }
  }
});

test('deviceColor: follows the kinds that the server tells of, not names', () => {
  knowDevices([{ name: 'cores', words: ['cores'], kind: 'processor', side: 'cpu', bit: 7 }]);
  assert.equal(deviceColor('cores'), '#4f9cff');
  assert.notEqual(deviceColor('embree'), '#4f9cff');
  knowDevices(DEVICE_KINDS);
  assert.equal(kindOf('vulkan:3')?.kind, 'gpu');
  assert.equal(kindOf('vulkanish'), undefined);
  assert.equal(kindOf('hybrid'), undefined);
  assert.notEqual(deviceColor('grey'), deviceColor('embree'));
});
