import assert from 'node:assert/strict';
import { test } from 'node:test';
import { matches, presetOf, PRESETS, presetValues } from '../../src/panels/settings/presets.js';
import type { SettingRow, SettingValue } from '../../src/wire/protocol.js';

const row = (name: string, given: SettingValue, high = 4096): SettingRow =>
  ({ name, label: name, help: 'Rays of one sample.', default: given, low: 0, high }) as unknown as SettingRow;
const ROWS = [row('samples', 64, 512), row('indirectLight', false), row('contributionThreshold', 0.004), row('exposure', 0)];
const start = (entry: SettingRow): SettingValue => entry.default;
const [fast, balanced, exact] = PRESETS;

test('presets: values of the rows that a server has, within its limits', () => {
  assert.deepEqual(presetValues(fast!, ROWS, start), { samples: 16, indirectLight: false, contributionThreshold: 0.02 });
  assert.deepEqual(presetValues(balanced!, ROWS, start), { samples: 64, indirectLight: false, contributionThreshold: 0.004 });
  assert.deepEqual(presetValues(exact!, ROWS, start), { samples: 512, indirectLight: true, contributionThreshold: 0 });
});

test('presets: the present one is found by its values, as the server keeps them', () => {
  const values: Record<string, SettingValue> = { samples: 16, indirectLight: false, contributionThreshold: Math.fround(0.02), exposure: 2 };
  const now = (): string | null => presetOf(ROWS, start, (name) => values[name])?.name ?? null;
  assert.equal(now(), 'fast', 'exposure is no preset’s');
  values['samples'] = 17;
  assert.equal(now(), null);
  assert.equal(presetOf([], start, () => undefined)?.name, 'balanced');
});

test('search: all words, in name, label or help', () => {
  assert.ok(matches(ROWS[0]!, 'SAMPLE rays'));
  assert.ok(matches(ROWS[0]!, ''));
  assert.ok(!matches(ROWS[0]!, 'samples fog'));
});
