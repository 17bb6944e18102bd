import assert from 'node:assert/strict';
import { test } from 'node:test';
import { autopilotRows, autopilotTitle } from '../../src/panels/statistics/autopilot_rows.js';
import { parseMessage, type Autopilot } from '../../src/wire/protocol.js';

function told(autopilot: unknown): Autopilot | null {
  const message = parseMessage(JSON.stringify({ type: 'stats', autopilot }));
  assert.equal(message?.type, 'stats');
  return message.type === 'stats' ? message.autopilot : null;
}

const HURRY = {
  budgetMs: 33,
  ms: 8,
  scale: 0.5,
  steps: [
    { setting: 'aoSamples', before: '25', after: '9', msWithout: 64 },
    { setting: 'ambientOcclusion', before: 'on', after: 'off', msWithout: 16 },
  ],
};
const label = (setting: string): string => (setting === 'aoSamples' ? 'AO samples' : setting);

test('autopilot: each step with what a picture would take without it', () => {
  const autopilot = told(HURRY);
  assert.equal(autopilotTitle(autopilot), 'Time budget 33 ms: 8.0 ms a picture');
  const rows = autopilotRows(autopilot, label).map(([, { label: name, text }]) => `${name} | ${text}`);
  assert.deepEqual(rows, ['AO samples 25 → 9 | 64 ms without', 'ambientOcclusion on → off | 16 ms without', 'Width 50 % | 32 ms without']);
  const shares = autopilotRows(autopilot, label).map(([, { share }]) => share);
  assert.deepEqual(shares, [1, 0.25, 0.5]);
});

test('autopilot: nothing without a budget, and only the budget while nothing is left out', () => {
  for (const none of [undefined, null, 3, 'x', []]) {
    assert.equal(autopilotTitle(told(none)), '');
    assert.deepEqual(autopilotRows(told(none), label), []);
  }
  const calm = told({ budgetMs: 33, ms: 0, scale: 1, steps: [] });
  assert.equal(autopilotTitle(calm), 'Time budget 33 ms');
  assert.deepEqual(autopilotRows(calm, label), []);
  assert.equal(autopilotRows(told({ budgetMs: 'x', steps: [{ setting: 4 }, null] }), label).length, 2);
});
