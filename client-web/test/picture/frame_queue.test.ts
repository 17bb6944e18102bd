import assert from 'node:assert/strict';
import { test } from 'node:test';
import { FrameQueue, isNewer } from '../../src/picture/frame_queue.js';
import type { Frame } from '../../src/wire/frame.js';

interface FakeImage {
  readonly id: number;
  closed: boolean;
  close(): void;
}

/** A queue whose decoder answers when the test says so. */
function setUp() {
  const waiting = new Map<number, { resolve: (image: FakeImage) => void; reject: () => void }>();
  const images: FakeImage[] = [];
  const drawn: number[] = [];
  const dropped: string[] = [];
  let scheduled = 0;
  const queue = new FrameQueue<FakeImage>({
    decode: (frame) =>
      new Promise((resolve, reject) => waiting.set(frame.frameId, { resolve, reject: () => reject(new Error('bad')) })),
    schedule: () => (scheduled += 1),
    draw: (_, frame) => drawn.push(frame.frameId),
    dropped: (frame, reason) => dropped.push(`${frame.frameId} ${reason}`),
    now: () => 0,
  });
  const pushes = new Map<number, Promise<void>>();
  const push = (frameId: number): void => void pushes.set(frameId, queue.push({ frameId } as Frame));
  const decoded = async (frameId: number): Promise<FakeImage> => {
    const image: FakeImage = { id: frameId, closed: false, close: () => (image.closed = true) };
    images.push(image);
    waiting.get(frameId)!.resolve(image);
    await pushes.get(frameId);
    return image;
  };
  const failed = async (frameId: number): Promise<void> => {
    waiting.get(frameId)!.reject();
    await pushes.get(frameId);
  };
  return { queue, push, decoded, failed, drawn, dropped, scheduled: () => scheduled };
}

test('FrameQueue: of two decoded before the animation frame, the newer is drawn and the older acknowledged as dropped', async () => {
  const { queue, push, decoded, drawn, dropped, scheduled } = setUp();
  push(1);
  push(2);
  const first = await decoded(1);
  await decoded(2);
  queue.present();
  assert.deepEqual(drawn, [2]);
  assert.deepEqual(dropped, ['1 newer']);
  assert.ok(first.closed);
  assert.equal(scheduled(), 1);
});

test('FrameQueue: a frame decoded after a newer one was drawn never shows', async () => {
  const { queue, push, decoded, drawn, dropped } = setUp();
  push(1);
  push(2);
  await decoded(2);
  queue.present();
  const late = await decoded(1);
  queue.present();
  assert.deepEqual(drawn, [2]);
  assert.deepEqual(dropped, ['1 newer']);
  assert.ok(late.closed);
});

test('FrameQueue: what cannot be decoded is dropped and the next one shows', async () => {
  const { queue, push, decoded, failed, drawn, dropped } = setUp();
  push(1);
  await failed(1);
  push(2);
  await decoded(2);
  queue.present();
  assert.deepEqual(drawn, [2]);
  assert.deepEqual(dropped, ['1 undecodable']);
});

test('FrameQueue: nothing of an ended connection is drawn or acknowledged, and ids may begin anew', async () => {
  const { queue, push, decoded, drawn, dropped } = setUp();
  push(50);
  await decoded(50);
  push(51);
  queue.reset();
  const late = await decoded(51);
  queue.present();
  push(1);
  await decoded(1);
  queue.present();
  assert.deepEqual(drawn, [1]);
  assert.deepEqual(dropped, []);
  assert.ok(late.closed);
});

test('isNewer: over the wrap of 32 bits', () => {
  assert.ok(isNewer(2, 1));
  assert.ok(!isNewer(1, 1));
  assert.ok(isNewer(0, 0xffffffff));
  assert.ok(!isNewer(0xfffffff0, 5));
});
