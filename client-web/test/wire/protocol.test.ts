import assert from 'node:assert/strict';
import { test } from 'node:test';
import { deviceNames, parseFrame, ProtocolError } from '../../src/wire/frame.js';
import { HEADER_BYTES } from '../../src/wire/limits.js';
import { parseMessage } from '../../src/wire/protocol.js';

const DEVICE_KINDS = [
  { name: 'embree', words: ['embree'], kind: 'processor', side: 'cpu', bit: 0 },
  { name: 'raster', words: ['raster'], kind: 'preview', side: 'gpu', bit: 2 },
];

test('deviceNames: the kinds that hello named, and one `other` for all the rest', () => {
  assert.deepEqual(deviceNames(0, DEVICE_KINDS), []);
  assert.deepEqual(deviceNames(1 | 4, DEVICE_KINDS), ['embree', 'raster']);
  assert.deepEqual(deviceNames(1 | 8 | 16, DEVICE_KINDS), ['embree', 'other']);
  assert.deepEqual(deviceNames(1, []), ['other']);
});

/** A header as docs/reference/protocol.md lays it out, with distinct values in all fields. */
function frameBytes(payload: readonly number[] = [0xff, 0xd8], headerBytes = HEADER_BYTES): ArrayBuffer {
  const buffer = new ArrayBuffer(headerBytes + payload.length);
  const view = new DataView(buffer);
  new Uint8Array(buffer).set([0x48, 0x47, 1, 0], 0);
  view.setUint16(4, headerBytes, true);
  view.setUint8(6, 1 | 4);
  view.setUint8(7, 80);
  view.setUint32(8, 4_000_000_001, true);
  view.setUint32(12, 77, true);
  view.setUint32(16, 5, true);
  [640, 360, 1280, 720].forEach((value, i) => view.setUint16(20 + 2 * i, value, true));
  view.setUint32(28, 16, true);
  view.setFloat32(32, 0.25, true);
  [20_500, 1_500, 3_000, 700, 250].forEach((value, i) => view.setUint32(36 + 4 * i, value, true));
  view.setUint32(56, payload.length, true);
  view.setUint32(60, 1 | 4, true);
  new Uint8Array(buffer).set(payload, headerBytes);
  return buffer;
}

function changed(offset: number, value: number): ArrayBuffer {
  const buffer = frameBytes();
  new DataView(buffer).setUint8(offset, value);
  return buffer;
}

test('parseFrame: a picture of a video says whether it needs one before it', () => {
  assert.equal(parseFrame(changed(3, 3), DEVICE_KINDS).codec, 'vp9');
  assert.equal(parseFrame(changed(3, 4), DEVICE_KINDS).codec, 'h264');
  assert.deepEqual([parseFrame(changed(6, 1), DEVICE_KINDS).key, parseFrame(changed(6, 9), DEVICE_KINDS).key], [false, true]);
});

test('parseFrame: reads every field', () => {
  const { payload, ...header } = parseFrame(frameBytes(), DEVICE_KINDS);
  assert.deepEqual(header, {
    kind: 'frame',
    place: null,
    codec: 'jpeg',
    moving: true,
    final: false,
    errorReached: false,
    denoised: false,
    path: true,
    key: false,
    exact: false,
    quality: 80,
    frameId: 4_000_000_001,
    inputId: 77,
    generation: 5,
    width: 640,
    height: 360,
    fullWidth: 1280,
    fullHeight: 720,
    samples: 16,
    relativeError: 0.25,
    renderMs: 20.5,
    developMs: 1.5,
    encodeMs: 3,
    queueMs: 0.7,
    sendMs: 0.25,
    devices: ['embree', 'raster'],
  });
  assert.deepEqual([...payload], [0xff, 0xd8]);
});

test('parseFrame: a part says which pixels it holds', () => {
  const buffer = frameBytes([7, 8], HEADER_BYTES + 8);
  const view = new DataView(buffer);
  view.setUint8(2, 3);
  [0, 120, 640, 24].forEach((value, i) => view.setUint16(HEADER_BYTES + 2 * i, value, true));
  const { kind, place, width, height, payload } = parseFrame(buffer, []);
  assert.deepEqual([kind, place, width, height], ['part', { x: 0, y: 120, width: 640, height: 24 }, 640, 360]);
  assert.deepEqual([...payload], [7, 8]);
});

test('parseFrame: skips what a longer header adds', () => {
  assert.deepEqual([...parseFrame(frameBytes([1, 2, 3], 80), []).payload], [1, 2, 3]);
});

test('parseFrame: refuses what is not a frame', () => {
  const bad: readonly (readonly [string, ArrayBuffer])[] = [
    ['bytes', new ArrayBuffer(63)],
    ['HG', changed(0, 0)],
    ['kind', changed(2, 4)],
    ['part header', changed(2, 3)],
    ['codec', changed(3, 9)],
    ['header', changed(4, 10)],
    ['payload', changed(56, 200)],
    ['payload', frameBytes().slice(0, HEADER_BYTES + 1)],
  ];
  for (const [word, buffer] of bad) {
    assert.throws(
      () => parseFrame(buffer, []),
      (error) => error instanceof ProtocolError && error.message.includes(word),
      word,
    );
  }
});

test('parseMessage: hello with its table; a choice\u2019s default may be a word or an index', () => {
  const row = { name: 'toneCurve', type: 'choice', label: 'Tone curve', choices: ['filmic', 'linear'] };
  for (const preset of ['linear', 1]) {
    const schema = [{ ...row, default: preset }];
    const hello = parseMessage(
      JSON.stringify({ type: 'hello', protocol: 'heliograph.v1', schema, devices: DEVICE_KINDS, videos: ['vp9'] }),
    );
    assert.ok(hello?.type === 'hello');
    assert.equal(hello.schema[0]?.default, 'linear');
    assert.equal(hello.maxUnacked, 2);
    assert.deepEqual(hello.devices, DEVICE_KINDS);
    assert.deepEqual(hello.videos, ['vp9']);
  }
});

test('parseMessage: a ready scene needs its camera and bounds', () => {
  const camera = { position: [0, 1, 2], forward: [0, 0, -1], up: [0, 1, 0], fieldOfView: 45 };
  const ready = {
    type: 'scene',
    name: 'cornell',
    state: 'ready',
    camera,
    bounds: { low: [-1, -1, -1], high: [1, 1, 1] },
    radius: 2,
  };
  const message = parseMessage(JSON.stringify(ready));
  assert.ok(message?.type === 'scene' && message.ready !== null);
  assert.deepEqual(message.ready.camera, camera);
  assert.deepEqual(message.ready.warnings, []);
  assert.throws(
    () => parseMessage(JSON.stringify({ ...ready, camera: { ...camera, up: [0, 1] } })),
    /scene\.camera\.up/,
  );
  assert.throws(() => parseMessage(JSON.stringify({ ...ready, state: 'gone' })), /scene\.state/);
});

test('parseMessage: unknown types are skipped, broken text is refused', () => {
  assert.equal(parseMessage('{"type":"weather"}'), null);
  for (const text of ['', '{', '[]', '3', 'null']) assert.throws(() => parseMessage(text), ProtocolError, text);
});

test('parseMessage: answers carry the input they answer, where there is one', () => {
  const error = parseMessage(
    '{"type":"error","message":"samples: 0, allowed: 1 to 65536","about":"settings","inputId":9}',
  );
  assert.ok(error?.type === 'error' && error.inputId === 9);
  const settings = parseMessage('{"type":"settings","values":{"samples":4,"shadows":true,"odd":{}}}');
  assert.ok(settings?.type === 'settings' && settings.inputId === null);
  assert.deepEqual(settings.values, { samples: 4, shadows: true });
});
