import assert from 'node:assert/strict';
import { test } from 'node:test';
import { AccuracyModel, type Measured, type ViewThen } from '../../src/panels/accuracy/accuracy_model.js';
import {
  bestRows, changeWords, factWords, frameTime, givenRow, moreTime, otherRows, plottedRows, rowName, rowNow, rowWords, settingWords, valuesFor,
} from '../../src/panels/accuracy/accuracy_rows.js';
import { logScale, logTicks } from '../../src/panels/accuracy/log_scale.js';
import type { Accuracy, AccuracyRow } from '../../src/wire/accuracy_message.js';
import type { SettingRow, SettingValues } from '../../src/wire/protocol.js';

const SCHEMA = [
  ['aoSamples', 'AO samples', 'film'],
  ['softShadows', 'Soft shadows', 'film'],
  ['renderScale', 'Render scale', 'film'],
  ['jpegQuality', 'JPEG quality', 'display'],
  ['fog', 'Fog', 'film'],
  ['showPartition', 'Show partition', 'film'],
].map(([name, label, acts]) => ({ name, label, acts }) as SettingRow);

const THEN: ViewThen = {
  camera: { position: [0, 1, 2], forward: [0, 0, -1], up: [0, 1, 0], fieldOfView: 60 },
  values: { aoSamples: 9, softShadows: true, renderScale: 1, jpegQuality: 80, fog: false, showPartition: false },
  size: { width: 1280, height: 720 },
};

function row(knob: string, value: string, set: SettingValues, ms: number, rmse: number | null, more: Partial<AccuracyRow> = {}): AccuracyRow {
  const rest = { given: false, exact: false, byLight: false, coding: false, bias: 0, flip: 0.03, psnrDb: 38.12, front: false };
  return { knob, value, set, ms, low: 0.98 * ms, high: 1.02 * ms, rmse, ...rest, ...more };
}

const GIVEN = { given: true, front: true };
const ROWS = [
  row('renderScale', '0.5', { renderScale: 0.5 }, 5, 0.12, { front: true }),
  row('renderScale', '1', {}, 20, 0.031, GIVEN),
  row('softShadows', 'off', { softShadows: false }, 18, 0.4, { byLight: true }),
  row('softShadows', 'on', {}, 20, 0.031, GIVEN),
  row('aoSamples', '4', { aoSamples: 4 }, 16, 0.2),
  row('aoSamples', '9', {}, 20, 0.031, GIVEN),
  row('aoSamples', '25', { aoSamples: 25 }, 30.25, 0.018, { front: true, exact: true }),
  row('jpegQuality', '80', {}, 2, null, { ...GIVEN, front: false, coding: true }),
  row('jpegQuality', '90', { jpegQuality: 90 }, 2.5, null, { coding: true }),
  row('combination', 'aoSamples=4 renderScale=0.5', { aoSamples: 4, renderScale: 0.5 }, 4, 0.3, { front: true }),
];
const ACCURACY: Accuracy = {
  type: 'accuracy', state: 'ready', scene: 'courtyard', device: 'embree', width: 320, height: 180, scale: 4, samples: null, seconds: 29.8,
  referenceError: 0.004, modelError: 0.08, rows: ROWS, pictures: null,
};
const MEASURED: Measured = { accuracy: ACCURACY, then: THEN };
const words = (at: number): string => rowWords(ROWS[at]!, MEASURED, SCHEMA);
const names = (rows: readonly AccuracyRow[]): readonly string[] => rows.map((entry) => rowName(entry, SCHEMA));

test('words: a setting by its label, from what to what, error and time for the pixels of the view', () => {
  assert.equal(words(6), 'AO samples from 9 to 25: error 3.1 % to 1.8 %, +41 ms');
  assert.equal(words(0), 'Render scale from 1 to 0.5: error 3.1 % to 12 %, \u221260 ms');
  assert.equal(words(1), 'As it was: error 3.1 %, 80.0 ms');
  assert.equal(words(2), 'Soft shadows from on to off: error 40 % against all light, \u22128 ms');
  assert.equal(words(8), 'JPEG quality from 80 to 90: coding takes 10.0 ms, FLIP 0.030, PSNR 38.1 dB');
  assert.equal(words(9), 'AO samples 4, Render scale 0.5: error 3.1 % to 30 %, \u221264 ms');
  const alike = row('fog', 'on', { fog: true }, 20.1, 0.031);
  assert.equal(rowWords(alike, MEASURED, SCHEMA), 'Fog from off to on: error 3.1 % as before, as fast');
});

test('words: names of settings, wherever they stand', () => {
  assert.equal(settingWords('aoSamples=9, about 12 s left', SCHEMA), 'AO samples 9, about 12 s left');
  assert.equal(settingWords('aoSamples=4 renderScale=0.5', SCHEMA), 'AO samples 4, Render scale 0.5');
  assert.equal(settingWords('reference, about 3 s left', SCHEMA), 'reference, about 3 s left');
  assert.equal(settingWords('newKnob=on', SCHEMA), 'newKnob on');
});

test('times: two digits of a difference, seconds from one on', () => {
  assert.deepEqual([41.2, -0.034, 0, 1234, -216.4].map(moreTime), ['+41 ms', '\u22120.034 ms', '+0 ms', '+1.2 s', '\u2212216 ms']);
  assert.deepEqual([12.34, 0.5, 1234].map(frameTime), ['12.3 ms', '0.50 ms', '1.23 s']);
});

test('rows: the best and as it was by time, the rest by setting, nothing twice', () => {
  assert.deepEqual(names(bestRows(ACCURACY)), ['AO samples 4, Render scale 0.5', 'Render scale 0.5', 'As it was', 'AO samples 25']);
  assert.deepEqual(
    otherRows(ACCURACY, SCHEMA).map(({ title, rows }) => [title, rows.map(({ value }) => value).join()]),
    [
      ['Soft shadows (on as it was, against all light)', 'off'],
      ['AO samples (9 as it was)', '4'],
      ['JPEG quality (80 as it was, coding alone)', '90'],
    ],
  );
  assert.deepEqual(plottedRows(ACCURACY).map((entry) => ROWS.indexOf(entry)), [0, 1, 4, 6, 9]);
});

test('givenRow: as it was, not with the samples that were measured instead', () => {
  const fewer = row('samples', '16', { samples: 16 }, 20, 0.031, GIVEN);
  assert.equal(givenRow({ ...ACCURACY, rows: [fewer, ...ROWS] }), ROWS[1]);
  assert.equal(givenRow({ ...ACCURACY, rows: [fewer] }), fewer);
  assert.equal(givenRow({ ...ACCURACY, rows: ROWS.filter(({ given, coding }) => !given || coding) }), null);
});

test('valuesFor: the values of the row, and of another row that was chosen before', () => {
  const at = (changed: SettingValues) => (name: string) => ({ ...THEN.values, ...changed })[name];
  assert.deepEqual(valuesFor(ROWS[6]!, MEASURED, at({})), { aoSamples: 25 });
  assert.deepEqual(valuesFor(ROWS[6]!, MEASURED, at({ renderScale: 0.5, fog: true })), { aoSamples: 25, renderScale: 1 });
  assert.deepEqual(valuesFor(ROWS[1]!, MEASURED, at({ aoSamples: 25 })), { aoSamples: 9 });
  assert.deepEqual(valuesFor(ROWS[1]!, MEASURED, at({})), {});
});

test('rowNow: the row whose settings those of now are', () => {
  const at = (changed: SettingValues) => (name: string) => ({ ...THEN.values, ...changed })[name];
  assert.equal(rowNow(MEASURED, at({})), ROWS[1]);
  assert.equal(rowNow(MEASURED, at({ aoSamples: 25 })), ROWS[6]);
  assert.equal(rowNow(MEASURED, at({ aoSamples: 4, renderScale: 0.5 })), ROWS[9]);
  assert.equal(rowNow(MEASURED, at({ aoSamples: 7 })), null);
});

test('changeWords: the view that is another one, beside the row that was chosen', () => {
  const say = (now: Partial<ViewThen>, values: SettingValues = {}): string =>
    changeWords(MEASURED, { ...THEN, ...now, values: { ...THEN.values, ...values } }, SCHEMA);
  assert.equal(say({}), '');
  assert.equal(say({}, { aoSamples: 25, jpegQuality: 30, showPartition: true }), 'Changed since: AO samples. The figures are of the view before.');
  assert.equal(say({}, { aoSamples: 25 }), '', 'a row of the list');
  assert.equal(say({}, { aoSamples: 7 }), 'Changed since: AO samples. The figures are of the view before.');
  const camera = { ...THEN.camera, position: [0, 1, 2.1] as const };
  const moved = say({ camera, size: { width: 640, height: 360 } }, { fog: true });
  assert.equal(moved, 'Changed since: camera, picture size, Fog. The figures are of the view before.');
  const many = say({ camera, size: { width: 640, height: 360 } }, { fog: true, aoSamples: 7, renderScale: 0.3 });
  assert.match(many, /camera, picture size, AO samples, Render scale and 1 more\./);
  const trembled = { ...THEN.camera, position: [0, 1 + 1e-9, 2] as const };
  assert.equal(say({ camera: trembled }), '');
});

test('factWords: where it was measured and what is known of the reference', () => {
  assert.equal(
    factWords(MEASURED),
    'Measured on embree at 320 × 180 pixels in 29.8 s. Times are told for this view, of 4 times as many pixels. ' +
      'The reference itself is known to 0.40 %. Without any limit this view is 8.0 % from all light.',
  );
  const bare = { ...ACCURACY, scale: 1, referenceError: null, modelError: null, seconds: 0.4 };
  assert.equal(factWords({ accuracy: bare, then: THEN }), 'Measured on embree at 320 × 180 pixels in 400 ms.');
  const fewer = { accuracy: { ...bare, samples: 16 }, then: { ...THEN, values: { samples: 64 } } };
  assert.match(factWords(fewer), /Pictures had 16 samples a pixel, of the view's 64\.$/);
});

test('logScale: equal factors are equal lengths; 0 sticks to the low end', () => {
  const scale = logScale([0, 0.01, 0.1, 1]);
  assert.ok(scale.low < 0.01 && scale.high > 1 && scale.low > 0.005);
  const near = (a: number, b: number): void => assert.ok(Math.abs(a - b) < 1e-9, `${a} is not ${b}`);
  near(scale.at(0.1) - scale.at(0.01), scale.at(1) - scale.at(0.1));
  near(scale.at(0.1), 0.5);
  assert.deepEqual([scale.at(0), scale.at(-1), scale.at(1e9)], [0, 0, 1]);
  for (const values of [[], [7], [7, 7.01]]) {
    const { low, high, at } = logScale(values);
    assert.ok(high / low >= 2, `${low} to ${high}`);
    near(at(Math.sqrt(low * high)), 0.5);
  }
});

test('logTicks: round values within, never more than asked for, and some', () => {
  assert.deepEqual(logTicks(logScale([1, 100]), 8), [1, 2, 5, 10, 20, 50, 100]);
  assert.deepEqual(logTicks(logScale([1, 100]), 6), [1, 3, 10, 30, 100]);
  for (const values of [[7], [0.0012, 0.9], [1e-7, 1e9], [12, 18], [95, 105]]) {
    const scale = logScale(values);
    const ticks = logTicks(scale, 6);
    assert.ok(ticks.length >= 2 && ticks.length <= 6, `${values}: ${ticks}`);
    assert.ok(ticks.every((tick) => tick >= scale.low && tick <= scale.high), `${values}: ${ticks}`);
  }
});

function model(): { model: AccuracyModel; sent: number[]; changes: () => number } {
  const sent: number[] = [];
  let changes = 0;
  return { model: new AccuracyModel((seconds) => sent.push(seconds), () => (changes += 1)), sent, changes: () => changes };
}
const MEASURING = { type: 'accuracy', state: 'measuring', share: 0.5, what: 'aoSamples=9' } as const;
const GIVEN_UP = { type: 'accuracy', state: 'given-up' } as const;

test('AccuracyModel: asked, measuring, ready; what nobody asked for is passed over', () => {
  const { model: accuracy, sent, changes } = model();
  accuracy.answered(MEASURING, 'courtyard');
  accuracy.answered(ACCURACY, 'courtyard');
  assert.deepEqual([accuracy.state, accuracy.measured, changes()], [{ name: 'idle' }, null, 0]);
  accuracy.ask(30, THEN);
  accuracy.ask(30, THEN);
  assert.deepEqual([sent, accuracy.state.name, accuracy.waits], [[30], 'asked', true]);
  accuracy.answered(MEASURING, 'courtyard');
  assert.deepEqual(accuracy.state, { name: 'measuring', share: 0.5, what: 'aoSamples=9' });
  accuracy.answered(ACCURACY, 'courtyard');
  assert.deepEqual([accuracy.state.name, accuracy.waits, accuracy.measured], ['ready', false, { accuracy: ACCURACY, then: THEN }]);
  accuracy.ask(10, THEN);
  assert.notEqual(accuracy.measured, null, 'the result stays while another one is measured');
});

test('AccuracyModel: given up by the viewer, by the server, and crossing with the result', () => {
  const { model: accuracy, sent } = model();
  accuracy.giveUp();
  accuracy.ask(30, THEN);
  accuracy.giveUp();
  accuracy.giveUp();
  assert.deepEqual([sent, accuracy.state.name], [[30, 0], 'ending']);
  accuracy.answered(MEASURING, 'courtyard');
  assert.equal(accuracy.state.name, 'ending', 'what was on its way');
  accuracy.answered(GIVEN_UP, 'courtyard');
  assert.deepEqual(accuracy.state, { name: 'ended', text: 'Given up.', wrong: false });
  accuracy.ask(30, THEN);
  accuracy.answered(GIVEN_UP, 'courtyard');
  assert.deepEqual(accuracy.state, { name: 'ended', text: 'The server gave it up.', wrong: true });
  accuracy.ask(30, THEN);
  accuracy.giveUp();
  accuracy.answered(ACCURACY, 'courtyard');
  assert.equal(accuracy.state.name, 'ready');
});

test('AccuracyModel: failed, refused, of another scene, driven by another viewer', () => {
  const { model: accuracy } = model();
  const text = (): string => (accuracy.state.name === 'ended' ? accuracy.state.text : accuracy.state.name);
  accuracy.ask(30, THEN);
  accuracy.answered({ type: 'accuracy', state: 'failed', what: 'device lost' }, 'courtyard');
  assert.equal(text(), 'It could not be measured: device lost');
  accuracy.ask(30, THEN);
  accuracy.refused('accuracy.seconds: 3, allowed: 0, 5 to 600');
  assert.equal(text(), 'accuracy.seconds: 3, allowed: 0, 5 to 600');
  accuracy.ask(30, THEN);
  accuracy.answered(ACCURACY, 'glass');
  assert.equal(text(), 'The server measured another scene: courtyard.');
  assert.equal(accuracy.measured, null);
  accuracy.ask(30, THEN);
  accuracy.handedOver();
  assert.equal(text(), 'Another viewer drives this view now.');
  accuracy.answered(ACCURACY, 'courtyard');
  assert.equal(accuracy.measured, null, 'what came too late');
});

test('AccuracyModel: another scene ends it, and a lost connection until the view is had again', () => {
  const { model: accuracy } = model();
  const text = (): string => (accuracy.state.name === 'ended' ? accuracy.state.text : accuracy.state.name);
  accuracy.sceneChanged();
  assert.equal(text(), 'idle');
  accuracy.ask(30, THEN);
  accuracy.disconnected();
  assert.equal(text(), 'The connection was lost while it was measured.');
  accuracy.answered(MEASURING, 'courtyard');
  assert.equal(text(), 'measuring');
  accuracy.answered(ACCURACY, 'courtyard');
  accuracy.disconnected();
  assert.equal(text(), 'ready');
  accuracy.sceneChanged();
  assert.deepEqual([text(), accuracy.measured], ['Another scene is shown: nothing is known of it yet.', null]);
  accuracy.ask(30, THEN);
  accuracy.sceneChanged();
  assert.equal(text(), 'Given up: another scene is shown.');
  accuracy.ask(30, THEN);
  accuracy.answered(GIVEN_UP, 'glass');
  assert.equal(text(), 'asked', 'what the new scene ended');
  accuracy.answered(GIVEN_UP, 'glass');
  assert.equal(text(), 'The server gave it up.');
});
