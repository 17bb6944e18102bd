import assert from 'node:assert/strict';
import { test } from 'node:test';
import { describeErrors, LEVEL_COLORS, LEVEL_NAMES, levelOf, levelShares } from '../../src/panels/errors/error_levels.js';
import type { ErrorMap } from '../../src/wire/errors_message.js';
import { parseMessage } from '../../src/wire/protocol.js';

const MESSAGE = { type: 'errors', frameId: 7, width: 70, height: 40, cellWidth: 32, cellHeight: 32 };

function read(fields: object): ErrorMap {
  const message = parseMessage(JSON.stringify({ ...MESSAGE, ...fields }));
  assert.ok(message?.type === 'errors');
  return message;
}

test('errors: cells in hundredths of a per cent, and what is wrong is named', () => {
  const map = read({ cells: [0, 49, 50, 150, 5000, null] });
  assert.deepEqual([map.columns, map.rows], [3, 2]);
  assert.deepEqual(map.cells, [0, 0.0049, 0.005, 0.015, 0.5, null]);
  assert.throws(() => read({ cells: [0] }), /errors.cells: 1, allowed: 6/);
  assert.throws(() => read({ cells: [0, 0, 0, 0, 0, -1] }), /errors.cells: -1/);
  assert.throws(() => read({ cells: [0, 0, 0, 0, 0, '1'] }), /errors.cells: "1"/);
  assert.throws(() => read({ width: 0, cells: [] }), /errors.width: 0/);
});

test('levels: each error has one, and all that are known are shared out', () => {
  assert.equal(LEVEL_NAMES.length, LEVEL_COLORS.length);
  assert.deepEqual([0, 0.0049, 0.005, 0.01, 0.03, 0.09, 0.1, 2].map(levelOf), [0, 0, 1, 2, 3, 4, 5, 5]);
  assert.deepEqual([LEVEL_NAMES[0], LEVEL_NAMES[1], LEVEL_NAMES[5]], ['under 0.5 %', '0.5 % to 1 %', '10 % and more']);
  assert.deepEqual(levelShares(read({ cells: [0, 49, 50, 5000, 5000, null] })), [0.4, 0.2, 0, 0, 0, 0.4]);
  assert.deepEqual(levelShares(read({ cells: [null, null, null, null, null, null] })), [0, 0, 0, 0, 0, 0]);
});

test('describeErrors: the middle one and the worst', () => {
  const words = 'Half of the picture has an error of at most 0.50 %, the worst part 50 %.';
  assert.equal(describeErrors(read({ cells: [0, 49, 50, 5000, 5000, null] })), words);
  assert.equal(describeErrors(read({ cells: [null, null, null, null, null, null] })), 'Nothing is known of the error yet.');
});
