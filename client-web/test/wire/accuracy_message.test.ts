import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { AccuracyMessage } from '../../src/wire/accuracy_message.js';
import { parseMessage } from '../../src/wire/protocol.js';

function read(fields: object): AccuracyMessage {
  const message = parseMessage(JSON.stringify({ type: 'accuracy', ...fields }));
  assert.ok(message?.type === 'accuracy');
  return message;
}

const ROW = {
  knob: 'aoSamples', value: '25', set: { aoSamples: 25 }, given: false, exact: false, byLight: false, coding: false,
  ms: 12.3, low: 12, high: 12.9, rmse: 0.018, bias: -0.001, flip: 0.03, psnrDb: 38.1, front: true,
};
const READY = {
  state: 'ready', scene: 'courtyard', device: 'embree', size: [320, 180], scale: 4, samples: 64, seconds: 29.8,
  referenceError: 0.004, modelError: null, rows: [ROW], pictures: { exact: 'aGk=', given: 'aG8=' },
};

test('accuracy: what is measured, given up or failed', () => {
  const type = 'accuracy';
  const what = 'aoSamples=9, about 12 s left';
  assert.deepEqual(read({ state: 'measuring', share: 0.37, what }), { type, state: 'measuring', share: 0.37, what });
  assert.deepEqual(read({ state: 'measuring', share: 7 }), { type, state: 'measuring', share: 1, what: '' });
  assert.deepEqual(read({ state: 'given-up' }), { type, state: 'given-up' });
  assert.deepEqual(read({ state: 'failed', what: 'device lost' }), { type, state: 'failed', what: 'device lost' });
});

test('accuracy: a result with all its fields', () => {
  const { size, ...rest } = READY;
  assert.deepEqual(read(READY), { type: 'accuracy', ...rest, width: size[0], height: size[1] });
  const bare = read({ ...READY, rows: [{ knob: 'jpegQuality', ms: 2, rmse: null }], pictures: undefined });
  assert.ok(bare.state === 'ready' && bare.pictures === null && bare.samples === 64);
  assert.deepEqual(bare.rows[0], {
    knob: 'jpegQuality', value: '', set: {}, given: false, exact: false, byLight: false, coding: false,
    ms: 2, low: 2, high: 2, rmse: null, bias: 0, flip: 0, psnrDb: 0, front: false,
  });
});

test('accuracy: what is wrong is named, with what was found', () => {
  const wrong: readonly (readonly [RegExp, object])[] = [
    [/accuracy\.state: done, allowed: measuring, given-up, failed, ready/, { state: 'done' }],
    [/accuracy\.size: \[320\]/, { ...READY, size: [320] }],
    [/accuracy\.size: \[320,0\]/, { ...READY, size: [320, 0] }],
    [/accuracy\.rows\[1\]\.ms: "1"/, { ...READY, rows: [ROW, { ...ROW, ms: '1' }] }],
    [/accuracy\.rows\[0\]\.ms: -1/, { ...READY, rows: [{ ...ROW, ms: -1 }] }],
    [/accuracy\.rows\[0\]\.rmse: -0\.1/, { ...READY, rows: [{ ...ROW, rmse: -0.1 }] }],
    [/accuracy\.referenceError: "no"/, { ...READY, referenceError: 'no' }],
    [/accuracy\.pictures\.given: no base64/, { ...READY, pictures: { exact: 'aGk=', given: '"><b>' } }],
    [/accuracy\.pictures\.exact: no base64/, { ...READY, pictures: {} }],
  ];
  for (const [message, fields] of wrong) assert.throws(() => read(fields), message);
});
