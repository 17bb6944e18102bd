import assert from 'node:assert/strict';
import { test } from 'node:test';
import { parseNumber } from '../../src/panels/settings/number_text.js';
import { SettingsModel } from '../../src/panels/settings/settings_model.js';
import { UndoStack } from '../../src/panels/settings/undo.js';
import type { SettingRow } from '../../src/wire/protocol.js';

test('parseNumber: a decimal comma is one, thousands may be apart', () => {
  assert.equal(parseNumber('0,5'), 0.5);
  assert.equal(parseNumber(' -0.5 '), -0.5);
  assert.equal(parseNumber('\u22122'), -2);
  assert.equal(parseNumber('1.234,5'), 1234.5);
  assert.equal(parseNumber('1,234.5'), 1234.5);
  assert.equal(parseNumber('1,234,567'), 1234567);
  assert.equal(parseNumber('65 536'), 65536);
  assert.equal(parseNumber('1e-3'), 0.001);
  for (const text of ['', 'abc', '1,2,3.4.5', '--1', '.', '5 px']) assert.equal(parseNumber(text), null, text);
});

const ROW: SettingRow = {
  name: 'samples',
  group: 'picture',
  acts: 'view',
  type: 'int',
  default: 64,
  low: 1,
  high: 65536,
  unit: '',
  label: 'Samples',
  effect: '',
  price: 'up',
  help: '',
  choices: [],
} as unknown as SettingRow;

test('SettingsModel: what the server starts with is the default, whatever the table says', () => {
  const model = new SettingsModel();
  model.setSchema([ROW]);
  model.echo({ samples: 256 }, null);
  assert.deepEqual([model.default(ROW), model.isDefault(ROW)], [256, true]);
  model.change({ samples: 64 }, 1);
  model.echo({ samples: 64 }, 1);
  assert.equal(model.isDefault(ROW), false);
  assert.deepEqual(model.defaults(), { samples: 256 });
  model.setSchema([ROW]); // another server
  model.echo({ samples: 64 }, null);
  assert.deepEqual(model.defaults(), { samples: 64 });
});

test('UndoStack: changes of the same settings in quick succession are one', () => {
  const undo = new UndoStack();
  undo.record({ exposure: 0 }, 0);
  undo.record({ exposure: 0.5 }, 400);
  undo.record({ exposure: 1 }, 800);
  undo.record({ shadows: true }, 900);
  undo.record({ shadows: false }, 3000);
  assert.equal(undo.size, 3);
  assert.deepEqual([undo.pop(), undo.pop(), undo.pop(), undo.pop()], [
    { shadows: false },
    { shadows: true },
    { exposure: 0 },
    null,
  ]);
});
