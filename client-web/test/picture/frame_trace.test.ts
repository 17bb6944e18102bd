import assert from 'node:assert/strict';
import { test } from 'node:test';
import { FrameTrace, stretchesOf, traceFile } from '../../src/picture/frame_trace.js';
import type { Frame } from '../../src/wire/frame.js';

const frame = (frameId: number, inputId: number): Frame =>
  ({
    frameId,
    inputId,
    width: 640,
    height: 360,
    samples: 1,
    queueMs: 3,
    renderMs: 20,
    developMs: 2,
    encodeMs: 4,
    sendMs: 1,
    payload: new Uint8Array(9),
  }) as unknown as Frame;
const TIMES = { oneWay: 5, arrived: 1050, decoded: 1054, presented: 1060 };

test('FrameTrace: stretches run from the event to the screen without a gap', () => {
  const trace = new FrameTrace();
  trace.sent(7, 1000, 1002);
  trace.presented(frame(1, 7), TIMES);
  const all = stretchesOf(trace.frames[0]!);
  assert.deepEqual(
    all.map(({ who, what, end, begin }) => `${who} ${what} ${end - begin}`),
    [
      'page event to message 2',
      'line to the server 5',
      'server waits to be rendered 3',
      'server render 20',
      'server waits for the encoder 8',
      'server develop 2',
      'server encode 4',
      'server waits for the socket 1',
      'line to the page 5',
      'page decode 4',
      'page to the screen 6',
    ],
  );
  assert.deepEqual([all[0]!.begin, all.at(-1)!.end], [1000, 1060]);
  all.slice(1).forEach(({ begin }, i) => assert.equal(begin, all[i]!.end));
});

test('FrameTrace: a frame that shows an input again begins with its rendering', () => {
  const trace = new FrameTrace();
  trace.sent(7, 1000, 1002);
  trace.presented(frame(1, 7), TIMES);
  trace.presented(frame(2, 7), { oneWay: 5, arrived: 1150, decoded: 1154, presented: 1160 });
  const [first] = stretchesOf(trace.frames[1]!);
  assert.deepEqual(first, { who: 'server', what: 'render', begin: 1118, end: 1138 });
});

test('FrameTrace: keeps the last 600 frames without their bytes, and no input of a connection that ended', () => {
  const trace = new FrameTrace();
  trace.sent(900, 1000, 1002);
  trace.reset();
  for (let id = 1; id <= 900; id++) trace.presented(frame(id, id), TIMES);
  assert.equal(trace.frames.length, 600);
  assert.equal(trace.frames[0]!.frame.frameId, 301);
  assert.ok(!('payload' in trace.frames[0]!.frame));
  assert.equal(trace.frames.at(-1)!.input, null);
});

test('traceFile: each stretch is a pair of begin and end, in microseconds', () => {
  const trace = new FrameTrace();
  trace.sent(7, 1000, 1002);
  trace.presented(frame(1, 7), TIMES);
  const { traceEvents } = JSON.parse(traceFile(trace.frames)) as {
    traceEvents: { ph: string; name: string; id?: number; ts?: number; pid: number; args?: { name?: string } }[];
  };
  const named = new Map(traceEvents.filter(({ ph }) => ph === 'M').map(({ pid, args }) => [pid, args?.name]));
  assert.deepEqual([...named.values()], ['page', 'line', 'server']);
  const slices = traceEvents.filter(({ ph }) => ph !== 'M');
  assert.equal(slices.length, 22);
  for (let i = 0; i < slices.length; i += 2) {
    const [begin, end] = [slices[i]!, slices[i + 1]!];
    assert.deepEqual([begin.ph, end.ph, begin.name, begin.id], ['b', 'e', end.name, end.id]);
    assert.ok(end.ts! > begin.ts!);
  }
  const render = slices.find(({ name }) => name === 'render')!;
  assert.deepEqual([render.ts, named.get(render.pid)], [1_010_000, 'server']);
});
