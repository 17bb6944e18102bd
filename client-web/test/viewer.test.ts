import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Frames } from '../src/frames.js';
import { StreamMeter } from '../src/picture/stream_meter.js';
import { Restoring } from '../src/reconnect.js';
import type { Frame } from '../src/wire/frame.js';
import type { SceneMessage } from '../src/wire/protocol.js';

const frame = (frameId: number, inputId = 0): Frame => ({ frameId, inputId, codec: 'jpeg' }) as Frame;

function frames() {
  const state = { lastFrame: null as Frame | null, framesPresented: 0, framesDropped: 0 };
  const meter = new StreamMeter();
  const [shown, acked, broken, lost]: [number[], string[], number[], number[]] = [[], [], [], []];
  let skipped = 0;
  const flow = new Frames(state, meter, {
    show: ({ frameId }) => shown.push(frameId),
    skipped: () => (skipped += 1),
    acknowledge: (frameId, presentedMs, shownMs, undecodable) => {
      acked.push(`${frameId} ${presentedMs} ${shownMs}`);
      if (undecodable) lost.push(frameId);
    },
    undecodable: ({ frameId }) => broken.push(frameId),
  });
  return { state, meter, flow, shown, acked, broken, lost, skipped: () => skipped };
}

test('Frames: a frame is acknowledged when it was presented, not when it came', () => {
  const { state, meter, flow, shown, acked } = frames();
  meter.motionToPhoton.sent(5, 1000);
  flow.arrived(frame(1, 5), false, 1028);
  assert.deepEqual([shown, acked, state.framesPresented], [[1], [], 0]);
  flow.presented({ frame: frame(1, 5), decodeMs: 2, time: 1040 });
  assert.deepEqual(acked, ['1 40 12']);
  assert.equal(state.lastFrame?.frameId, 1);
  assert.equal(state.framesPresented, 1);
});

test('Frames: a frame with no new input is acknowledged without a time', () => {
  const { flow, acked } = frames();
  flow.presented({ frame: frame(1), decodeMs: 2, time: 10 });
  assert.deepEqual(acked, ['1 null null']);
});

test('Frames: what is dropped is acknowledged once, and only what cannot be decoded is told', () => {
  const { state, flow, acked, broken } = frames();
  flow.arrived(frame(1), false, 10);
  flow.dropped(frame(1), 'newer', 14);
  flow.dropped(frame(2), 'undecodable', 15);
  assert.deepEqual(acked, ['1 null 4', '2 null null']);
  assert.deepEqual(broken, [2]);
  assert.equal(state.framesDropped, 2);
  assert.equal(state.lastFrame, null);
});

test('Frames: a frame of another scene than the one looked at is acknowledged and not shown', () => {
  const { state, flow, shown, acked } = frames();
  flow.arrived(frame(7), true, 3);
  assert.deepEqual([shown, acked, state.framesDropped], [[], ['7 null 0'], 1]);
});

test('Frames: a picture of a video that is lost is told to the server, not to people', () => {
  const { flow, broken, lost, skipped } = frames();
  const picture = (frameId: number): Frame => ({ ...frame(frameId), codec: frameId === 3 ? 'h264' : 'vp9' });
  flow.dropped(picture(1), 'newer', 1);
  assert.deepEqual([lost, skipped()], [[], 0]);
  flow.arrived(picture(2), true, 2);
  assert.deepEqual([lost, skipped()], [[2], 1], 'a hidden one is not decoded: those that build on it cannot be');
  flow.dropped(picture(3), 'undecodable', 3);
  assert.deepEqual([lost, broken], [[2, 3], []]);
});

const word = (name: string): SceneMessage => ({ type: 'scene', name, state: 'ready', what: '', share: 1, ready: null });
const OFFERED = ['cornell', 'glass'];

test('Restoring: without a scene from before, every word on a scene shows', () => {
  const restoring = new Restoring();
  assert.deepEqual(restoring.step(word('cornell'), OFFERED), { show: true, ask: null });
  assert.equal(restoring.finish('cornell'), false);
});

test('Restoring: the scene from before is asked for once, and others wait until it is shown', () => {
  const restoring = new Restoring();
  restoring.begin('glass');
  assert.deepEqual(restoring.step(word('cornell'), OFFERED), { show: false, ask: 'glass' });
  assert.deepEqual(restoring.step(word('cornell'), OFFERED), { show: false, ask: null });
  assert.ok(restoring.active);
  assert.deepEqual(restoring.step(word('glass'), OFFERED), { show: true, ask: null });
  assert.equal(restoring.finish('glass'), true);
  assert.ok(!restoring.active);
  assert.deepEqual(restoring.step(word('cornell'), OFFERED), { show: true, ask: null });
});

test('Restoring: a scene that the server no longer has is given up at once', () => {
  const restoring = new Restoring();
  restoring.begin('mine.glb');
  assert.deepEqual(restoring.step(word('cornell'), OFFERED), { show: true, ask: null });
  assert.ok(!restoring.active);
});

test('Restoring: when the scene fails to open, the newest word on the server\u2019s own shows', () => {
  const restoring = new Restoring();
  restoring.begin('glass');
  restoring.step({ ...word('cornell'), state: 'loading' }, OFFERED);
  restoring.step(word('cornell'), OFFERED);
  assert.equal(restoring.giveUp()?.state, 'ready');
  assert.ok(!restoring.active);
  assert.equal(restoring.giveUp(), null);
});

test('Restoring: what the viewer opens meanwhile counts, not the scene from before', () => {
  const restoring = new Restoring();
  restoring.begin('glass');
  restoring.step(word('cornell'), OFFERED);
  restoring.cancel();
  assert.deepEqual(restoring.step(word('cornell'), OFFERED), { show: true, ask: null });
  assert.equal(restoring.finish('glass'), false);
});
