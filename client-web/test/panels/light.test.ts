import assert from 'node:assert/strict';
import { test } from 'node:test';
import { isLightRow, lightRowFolded, lightRows, lightWithoutUse, shortName, wordOf } from '../../src/panels/light/light_rows.js';
import { angleAt, LOG_SCALE, turnedTo, TURN_SCALE } from '../../src/panels/light/light_scale.js';
import { LightTurn } from '../../src/panels/light/light_turn.js';
import type { SettingRow, SettingValues } from '../../src/wire/protocol.js';

const row = (name: string, low = 0, high = 1, preset = 0): SettingRow =>
  ({ name, group: 'picture', type: 'float', low, high, default: preset, choices: [] }) as unknown as SettingRow;

test('lightRows: those that the server has, in the panel’s order', () => {
  const rows = ['toneCurve', 'samples', 'exposure', 'surroundings'].map((name) => row(name));
  assert.deepEqual(lightRows(rows).map(({ name }) => name), ['surroundings', 'exposure', 'toneCurve']);
  assert.deepEqual([isLightRow(row('samples')), isLightRow(row('background'))], [false, true]);
});

test('wordOf: a word for what is known, none for what is not', () => {
  assert.equal(wordOf('toneCurve', 'neutral'), 'true');
  assert.equal(wordOf('toneCurve', 'moon'), '');
  assert.equal(wordOf('nothing', 'neutral'), '');
  assert.deepEqual([shortName('automatic'), shortName('sky')], ['auto', 'sky']);
});

test('lightWithoutUse: nothing to turn or to scale where nothing is, nor to turn what is even', () => {
  const around = (word: string) => () => word;
  assert.equal(lightWithoutUse('environmentRotation', around('studio')), null);
  assert.ok(lightWithoutUse('environmentRotation', around('grey')) !== null);
  assert.equal(lightWithoutUse('environmentStrength', around('grey')), null);
  assert.ok(lightWithoutUse('environmentStrength', around('none')) !== null);
  assert.equal(lightWithoutUse('exposure', around('none')), null);
});

test('lightRowFolded: what belongs to the sun, until it shines', () => {
  for (const on of [true, false]) {
    const folded = ['sun', 'sunSize', 'sunAzimuth', 'exposure'].map((name) => lightRowFolded(name, () => on));
    assert.deepEqual(folded, [false, !on, !on, false]);
  }
});

const STRENGTH = row('environmentStrength', 0, 100, 1);

test('LOG_SCALE: equal ways are equal factors, and both ends are exact', () => {
  const { from, to } = LOG_SCALE;
  assert.deepEqual([from(STRENGTH, 0), from(STRENGTH, 500), from(STRENGTH, 1000)], [0, 1, 100]);
  assert.deepEqual([to(STRENGTH, 0), Math.round(to(STRENGTH, 1)), to(STRENGTH, 100)], [0, 500, 1000]);
  assert.equal(Math.round(to(STRENGTH, 10) - to(STRENGTH, 1)), Math.round(to(STRENGTH, 1) - to(STRENGTH, 0.1)));
  for (const position of [0, 13, 250, 640, 999, 1000]) {
    const value = from(STRENGTH, position);
    assert.equal(from(STRENGTH, to(STRENGTH, value)), value, `position ${position}`);
  }
});

test('LOG_SCALE: arrows step by a tenth or so, reach nought and come back from it', () => {
  const { stepped } = LOG_SCALE;
  assert.equal(stepped(STRENGTH, 1, 1, false), 1.1);
  assert.equal(stepped(STRENGTH, 1.1, -1, false), 1);
  assert.equal(stepped(STRENGTH, 1, 1, true), 2.5);
  let value = 1;
  for (let i = 0; i < 200 && value > 0; i += 1) value = stepped(STRENGTH, value, -1, false);
  assert.equal(value, 0);
  assert.equal(stepped(STRENGTH, 0, 1, false), 0.01);
  assert.equal(stepped(STRENGTH, 100, 1, true), 100);
});

const TURN = row('environmentRotation', -180, 180, 0);

test('turnedTo: goes round where the range is a full turn, and ends where it is none', () => {
  assert.deepEqual([190, -190, 180, 44.6, 900].map((value) => turnedTo(TURN, value)), [-170, 170, -180, 45, -180]);
  const part = row('environmentRotation', -90, 90, 0);
  assert.deepEqual([120, -91].map((value) => turnedTo(part, value)), [90, -90]);
});

test('TURN_SCALE: a degree by the arrows, fifteen by the page keys, across the seam', () => {
  assert.equal(TURN_SCALE.stepped(TURN, 10, -1, false), 9);
  assert.equal(TURN_SCALE.stepped(TURN, 175, 1, true), -170);
});

test('angleAt: clockwise from the top; nothing in the middle', () => {
  assert.deepEqual([angleAt(0, -20), angleAt(20, 0), angleAt(0, 20), angleAt(-20, 0)], [0, 90, 180, -90]);
  assert.equal(angleAt(2, 3), null);
});

/** A turn of surroundings with what it set and told. */
function turn(around: string, rows: readonly SettingRow[] = [TURN]) {
  const values: SettingValues = { surroundings: around, environmentRotation: 170 };
  const now = { ...values };
  const told: string[] = [];
  const made = new LightTurn({
    rows: () => rows,
    value: (name) => now[name],
    set: (set) => void Object.assign(now, set),
    notice: (text) => void told.push(text),
  });
  return { made, now, told };
}

test('LightTurn: half a turn for the height of the picture, parts of a degree add up, across the seam', () => {
  const { made, now } = turn('studio');
  for (let i = 0; i < 100; i += 1) made.drag(1, 1000); // 18 degrees, 0.18 each
  assert.equal(now['environmentRotation'], -173); // 17 whole ones: sums of 0.18 stay under 18
  made.by(-15);
  assert.equal(now['environmentRotation'], 172);
});

test('LightTurn: says once why nothing turns', () => {
  const even = turn('grey');
  for (let i = 0; i < 5; i += 1) even.made.drag(50, 1000);
  assert.deepEqual([even.now['environmentRotation'], even.told.length], [170, 1]);
  const old = turn('studio', []);
  old.made.by(15);
  assert.deepEqual(old.told, ['This server does not turn surroundings.']);
});

test('LightTurn: the sun goes along while it shines, also where nothing else turns', () => {
  const sun = row('sunAzimuth', -180, 180, 35);
  const { made, now } = turn('studio', [TURN, sun]);
  Object.assign(now, { sun: true, sunAzimuth: 35 });
  made.by(15);
  assert.deepEqual([now['environmentRotation'], now['sunAzimuth']], [-175, 50]);
  now['sun'] = false;
  made.by(15);
  assert.deepEqual([now['environmentRotation'], now['sunAzimuth']], [-160, 50]);
  const even = turn('grey', [TURN, sun]);
  Object.assign(even.now, { sun: true, sunAzimuth: 170 });
  even.made.by(15);
  assert.deepEqual([even.now['environmentRotation'], even.now['sunAzimuth'], even.told.length], [170, -175, 0]);
});
