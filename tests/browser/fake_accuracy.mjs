// What the fake server says of the accuracy of a view: rows as a sweep has them, made up, and two pictures.

import { paint } from './fake_picture.mjs';

const [WIDTH, HEIGHT] = [160, 90];

/** A setting, its value as given, and of others: value, ms, error; `front` where nothing is both faster and nearer. */
const KNOBS = [
  ['renderScale', '1', [['0.25', 2.1, 0.21, 'front'], ['0.5', 4.9, 0.094, 'front'], ['0.75', 11, 0.052]]],
  ['samples', '4', [['1', 5.4, 0.12], ['2', 9.8, 0.061, 'front'], ['8', 27, 0.0225, 'front'], ['16', 75, 0.0142, 'front']]],
  ['shadowSamples', '4', [['1', 14.2, 0.047, 'front'], ['2', 16.1, 0.037, 'front'], ['16', 47, 0.027]]],
  ['aoSamples', '9', [['4', 17.5, 0.039], ['25', 29.2, 0.018, 'front'], ['64', 61, 0.0158, 'front']]],
  ['contributionThreshold', '0.004', [['0.03', 18.2, 0.044], ['0.001', 20.9, 0.0311]]],
];
const COMBINED = [
  [{ renderScale: 0.5, aoSamples: 4 }, 4.2, 0.11, 'front'],
  [{ samples: 16, aoSamples: 25, shadowSamples: 16 }, 131, 0.0041, 'front'],
  [{ samples: 8, shadowSamples: 2, contributionThreshold: 0.001 }, 35, 0.0245],
];
const GIVEN = [19.8, 0.031];
const CODING = [['70', 1.9, 36.1], ['90', 2.4, 42.7]];

const row = (knob, value, set, ms, rmse, front = '') => ({
  knob,
  value,
  set,
  given: false,
  exact: false,
  byLight: false,
  coding: false,
  ms,
  low: 0.97 * ms,
  high: 1.04 * ms,
  rmse,
  bias: -0.001,
  flip: rmse === null ? 0.012 : rmse / 2,
  psnrDb: 38.1,
  front: front !== '',
});

function rows() {
  const given = (knob, value) => ({ ...row(knob, value, {}, ...GIVEN, 'front'), given: true });
  const turned = KNOBS.flatMap(([knob, was, others]) => [
    given(knob, was),
    ...others.map(([value, ms, rmse, front]) => row(knob, value, { [knob]: Number(value) }, ms, rmse, front)),
  ]);
  const light = { ...row('indirectLight', 'on', { indirectLight: true }, 44, 0.071), byLight: true };
  const coded = CODING.map(([value, ms, psnrDb]) => ({
    ...row('jpegQuality', value, { jpegQuality: Number(value) }, ms, null),
    coding: true,
    psnrDb,
  }));
  const combined = COMBINED.map(([set, ms, rmse, front]) => {
    const value = Object.entries(set).map(([name, to]) => `${name}=${to}`).join(' ');
    return row('combination', value, set, ms, rmse, front);
  });
  const off = { ...given('indirectLight', 'off'), byLight: true, front: false, rmse: 0.08 };
  const quality = { ...given('jpegQuality', '80'), coding: true, front: false, ms: 2.1, rmse: null };
  return [...turned, off, light, quality, ...coded, ...combined];
}

/** A view measured to the end. */
export function accuracy(scene, camera) {
  const picture = (exposure) => paint(scene, camera, WIDTH, HEIGHT, exposure).toString('base64');
  return {
    type: 'accuracy',
    state: 'ready',
    scene,
    device: 'embree',
    size: [WIDTH, HEIGHT],
    scale: 4,
    samples: 4,
    seconds: 29.8,
    referenceError: 0.004,
    modelError: 0.08,
    rows: rows(),
    pictures: { exact: picture(0), given: picture(-0.7) }, // far enough apart to be told
  };
}
