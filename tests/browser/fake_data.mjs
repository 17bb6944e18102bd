// What the fake server says of settings, effects and devices: tables read from the kernel's sources, the rest made up.

import { readFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

const kernel = join(dirname(fileURLToPath(import.meta.url)), '../../shaders/kernel');
const common = { group: 'hybrid', acts: 'film', effect: '', price: '', unit: '' };

/** Rows of the protocol that the table may not have yet; a row of the table with the same name wins. */
const MORE_ROWS = [
  ['hybridBalance', { type: 'choice', default: 'auto', choices: ['auto', 'manual'], label: 'Hybrid balance' }],
  ['hybridShare', { type: 'int', default: 50, low: 0, high: 100, unit: 'percent', label: 'Share for the GPUs' }],
  ['showPartition', { type: 'bool', default: false, label: 'Show partition' }],
  ['enableEmbree', { type: 'bool', default: true, label: 'Use Embree' }],
  ['enableVulkan', { type: 'bool', default: true, label: 'Use Vulkan' }],
  ['aperture', { type: 'float', default: 0, low: 0, high: 1, unit: 'm', label: 'Aperture' }],
  ['focusDistance', { type: 'float', default: 5, low: 0.01, high: 1000, unit: 'm', label: 'Focus distance' }],
].map(([name, row]) => ({ ...common, name, help: `Stand-in of the fake server for ${name}.`, ...row }));

const words = (list) => [...list.matchAll(/"((?:[^"\\]|\\.)*)"|([^,\s"]+)/g)].map((m) => m[1] ?? m[2]);

function settingRow(kind, list) {
  const parts = words(list);
  const number = (word) => Number(word.replace(/f$/, ''));
  const [name, group, acts, preset] = parts;
  const [label, effect, price, help] = parts.slice(-4);
  const row = { name, group, acts, label, effect, price, help, unit: '' };
  if (kind === 'BOOL') return { ...row, type: 'bool', default: preset === 'true' };
  if (kind === 'CHOICE') {
    const choices = parts[4].split('|');
    return { ...row, type: 'choice', default: choices[Number(preset)], choices };
  }
  const range = { low: number(parts[4]), high: number(parts[5]), unit: parts[6] };
  return { ...row, type: kind.toLowerCase(), default: number(preset), ...range };
}

/** The kinds of devices of the real table, as `hello` has them. */
export function deviceKinds() {
  const text = readFileSync(join(kernel, '../../server/request/device_table.inc'), 'utf8');
  const rows = [...text.matchAll(/^DEVICE\((\w+), (\d+), (\w+), (\w+), "(.*?)"/gm)];
  return rows.map(([, name, bit, kind, side, words]) => ({ name, words: words.split('|'), kind, side, bit: Number(bit) }));
}

/** The rows of the real table, without those in `omit`. */
export function schema(omit) {
  const deviceWords = deviceKinds().flatMap((row) => row.words);
  const text = readFileSync(join(kernel, 'settings_table.glsl'), 'utf8').replace(
    ' DEVICE_WORDS,',
    ` "${['auto', ...deviceWords, 'hybrid'].join('|')}",`,
  );
  const rows = [...text.matchAll(/^SETTING_(?:K_)?(BOOL|INT|FLOAT|CHOICE)\((.*)\)$/gm)].map((m) =>
    settingRow(m[1], m[2]),
  );
  const device = rows.find((row) => row.name === 'device');
  if (!device.choices.includes('hybrid')) device.choices.push('hybrid');
  const more = MORE_ROWS.filter((row) => !rows.some((other) => other.name === row.name));
  return [...rows, ...more].filter((row) => !omit.includes(row.name));
}

const NOT_CALLED_FOR = {
  refractions: 'no transmissive material',
  absorption: 'no material with coloured glass',
  alphaBlend: 'no material lets light straight through',
  alphaMask: 'no cut-out material',
  transparentShadows: 'no transparent material',
  vertexColors: 'no mesh stores colours',
  tangents: 'no mesh stores tangents',
  secondTextureCoordinates: 'every texture uses the first coordinates',
  instancing: 'every mesh stands in one place',
};

/** The effects of the real table as a scene would call for them; `idle`: the name of one more that it has no use for. */
export function effects(idle = '') {
  const text = readFileSync(join(kernel, 'effect_table.glsl'), 'utf8');
  const table = [...text.matchAll(/^EFFECT\((.*)\)$/gm)].map((m) => {
    const [, , name, setting, , , rule, , help] = words(m[1]);
    const unused = name === idle || name in NOT_CALLED_FOR;
    const because = NOT_CALLED_FOR[name] ?? '3 materials (brass, marble, ...), 1,204 triangles';
    const given = setting === 'none' ? '' : setting;
    const choice = rule === 'anywhere' || rule === 'onLitSurfaces' || rule === 'path';
    return { name, calledFor: !choice && !unused, choice, because, help, setting: given, simulated: true };
  });
  const atRest = { because: '2 animations (walk, run); shown at rest', help: 'Objects that move in time.' };
  return [...table, { name: 'animation', calledFor: true, simulated: false, ...atRest }];
}

const CELL = 16;
const DEVICES = ['embree', 'vulkan:0'];

/** Who made which cell: a disc in the middle by vulkan:0, the rest by embree, the first cell by nobody. */
export function partition(frameId, width, height, workers, batchesEach) {
  const columns = Math.ceil(width / CELL);
  const rows = Math.ceil(height / CELL);
  let cells = '';
  for (let y = 0; y < rows; y += 1) {
    for (let x = 0; x < columns; x += 1) {
      const away = Math.hypot((x + 0.5) / columns - 0.5, (y + 0.5) / rows - 0.5);
      cells += x + y === 0 ? '.' : away < 0.32 ? '1' : '0';
    }
  }
  const tracks = Array.from({ length: workers }, (_, worker) =>
    track('embree', worker, batchesEach, 11.5 - worker * 0.05),
  );
  tracks.push(track('vulkan:0', 0, 3, 12));
  const size = { width, height, cellWidth: CELL, cellHeight: CELL };
  return { type: 'partition', frameId, ...size, devices: DEVICES, cells, timeline: { ms: 12.4, workers: tracks } };
}

/** One worker with `count` batches of 14 cells from 0.5 ms to `end`, with pauses of a tenth. */
function track(device, worker, count, end) {
  const step = (end - 0.5) / count;
  const batches = Array.from({ length: count }, (_, i) => [0.5 + i * step, 0.5 + (i + 0.9) * step, 14]);
  return { device, worker, batches };
}

/** The devices' part in the work, as `stats` states it. */
export const PARTS = [
  { device: 'embree', part: 'works', reason: '', mraysPerSecond: 38.7, share: 0.34, idleShare: 0.04 },
  { device: 'vulkan:0', part: 'works', reason: '', mraysPerSecond: 74.1, share: 0.66, idleShare: 0.02 },
  {
    device: 'vulkan:1',
    part: 'parked',
    reason: 'it would gain 1.2 % of the frame, less than 3 %',
    mraysPerSecond: 0.9,
    share: 0,
    idleShare: 1,
  },
];
export const SCHEDULER = { endLossMs: 0.31, decisionMs: 0.042, batches: 37, reissued: 1 };

/** Milliseconds and rays of each effect that is called for, on and off. */
export function effectCosts(scene) {
  const rows = effects()
    .filter((effect) => (effect.calledFor || effect.choice) && effect.simulated)
    .map(({ name }, i) => ({ name, cost: 5.2 / (i + 1), fewer: i }))
    .map(({ name, cost, fewer }) => ({
      name, onMs: 21.4, offMs: 21.4 - cost, lowMs: 0.8 * cost, highMs: 1.3 * cost, raysOn: 4020800, raysOff: 4020800 - fewer,
    }));
  return { type: 'effectCosts', state: 'ready', scene, device: 'embree', width: 320, height: 180, rows };
}
