import assert from 'node:assert/strict';
import { test } from 'node:test';
import { ExactPicture } from '../../src/picture/exact_picture.js';
import type { Frame } from '../../src/wire/frame.js';

const part = (frameId: number, y: number, rows: number): Frame =>
  ({ kind: 'part', frameId, width: 8, height: 10, place: { x: 0, y, width: 8, height: rows } }) as Frame;

function puzzle() {
  const [acked, wholes, closed]: [number[], string[], number[]] = [[], [], []];
  let hold: Promise<void> = Promise.resolve();
  const picture = new ExactPicture<{ id: number; close(): void }>({
    decode: async ({ frameId }) => {
      await hold;
      if (frameId === 99) throw new Error('no PNG');
      return { id: frameId, close: () => closed.push(frameId) };
    },
    complete: (parts, frame) => wholes.push(`${parts.map(({ image }) => image.id).join('+')} as ${frame.frameId}`),
    acknowledge: ({ frameId }) => acked.push(frameId),
  });
  return { picture, acked, wholes, closed, wait: (until: Promise<void>): void => void (hold = until) };
}

test('ExactPicture: is there when all its rows are, and the last part is not acknowledged before it is seen', async () => {
  const { picture, acked, wholes, closed } = puzzle();
  await picture.push(part(1, 0, 4));
  await picture.push(part(2, 4, 4));
  assert.deepEqual([acked, wholes], [[1, 2], []]);
  await picture.push(part(3, 8, 2));
  assert.deepEqual([acked, wholes, closed], [[1, 2], ['1+2+3 as 3'], [1, 2, 3]]);
});

test('ExactPicture: parts of different pictures are never put together', async () => {
  const { picture, acked, wholes, closed, wait } = puzzle();
  await picture.push(part(1, 0, 4));
  let release = (): void => undefined;
  wait(new Promise((done) => (release = done)));
  const decoding = picture.push(part(2, 4, 4));
  picture.forget();
  release();
  await decoding;
  await picture.push(part(4, 0, 6));
  assert.deepEqual([acked, wholes, closed], [[1, 2, 4], [], [1, 2]]);
  await picture.push(part(5, 6, 4));
  assert.deepEqual(wholes, ['4+5 as 5']);
});

test('ExactPicture: a part that cannot be decoded is acknowledged, and nothing is shown', async () => {
  const { picture, acked, wholes } = puzzle();
  await picture.push(part(99, 0, 6));
  await picture.push(part(2, 6, 4));
  assert.deepEqual([acked, wholes], [[99, 2], []]);
});
