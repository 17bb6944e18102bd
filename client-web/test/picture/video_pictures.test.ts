import assert from 'node:assert/strict';
import { test } from 'node:test';
import { VideoPictures } from '../../src/picture/video_pictures.js';
import { videoFault, VideoSupport } from '../../src/picture/video_support.js';
import type { Frame } from '../../src/wire/frame.js';

const frame = (frameId: number, key = false): Frame =>
  ({ frameId, key, codec: 'vp9', payload: new Uint8Array([frameId]) }) as Frame;

/** A decoder that puts a picture out when it is told to. */
function video(heldMs?: number) {
  const log: string[] = [];
  let init: VideoDecoderInit | null = null;
  let made = 0;
  const pictures = new VideoPictures<{ id: number; close(): void }>({
    decoder: (given) => {
      init = given;
      const number = ++made;
      const decoder = {
        state: 'unconfigured' as CodecState,
        configure: () => (decoder.state = 'configured'),
        decode: (chunk: EncodedVideoChunk) => {
          log.push(`${number} takes ${chunk.type} ${chunk.timestamp}`);
          if (chunk.byteLength === 99) throw new Error('no');
        },
        close: () => (decoder.state = 'closed'),
      };
      return decoder;
    },
    chunk: ({ type, timestamp, data }) => ({ type, timestamp, byteLength: (data as Uint8Array)[0] }) as EncodedVideoChunk,
    image: async ({ timestamp }) => ({ id: timestamp, close: () => undefined }),
    failed: (reason) => log.push(reason),
  }, heldMs);
  const output = (timestamp: number): void =>
    init!.output({ timestamp, close: () => log.push(`closed ${timestamp}`) } as unknown as VideoFrame);
  return { pictures, log, output, error: (text: string): void => init!.error(new DOMException(text)) };
}

test('VideoPictures: each picture is decoded and given back, and closed when it was copied', async () => {
  const { pictures, log, output } = video();
  const first = pictures.decode(frame(1, true));
  const second = pictures.decode(frame(2));
  output(1);
  output(2);
  assert.deepEqual([(await first).id, (await second).id], [1, 2]);
  assert.deepEqual(log, ['1 takes key 1', '1 takes delta 2', 'closed 1', 'closed 2']);
  pictures.reset();
});

test('VideoPictures: after one that is missing nothing is decoded until a key picture', async () => {
  const { pictures, log, output } = video();
  await assert.rejects(pictures.decode(frame(1)), /missing/);
  const key = pictures.decode(frame(2, true));
  output(1);
  await key;
  pictures.skipped();
  await assert.rejects(pictures.decode(frame(4)), /missing/);
  const again = pictures.decode(frame(5, true));
  output(2);
  assert.equal((await again).id, 2);
  assert.deepEqual(log.filter((line) => line.includes('takes')), ['1 takes key 1', '1 takes key 2']);
  pictures.reset();
});

test('VideoPictures: what fails begins anew, and is given up after three times in a row', async () => {
  const { pictures, log, error } = video();
  for (const time of [1, 2, 3]) {
    const broken = pictures.decode(frame(time, true));
    const waits = time === 1 ? pictures.decode(frame(time)) : null;
    error('lost');
    await assert.rejects(broken, /lost/);
    if (waits !== null) await assert.rejects(waits, /lost/);
    await assert.rejects(pictures.decode(frame(time)), /missing/);
  }
  assert.deepEqual(log.filter((line) => !line.includes('takes')), ['This browser fails to decode video (lost).']);
});

test('VideoPictures: a chunk that is refused at once is one that cannot be decoded', async () => {
  const { pictures } = video();
  await assert.rejects(pictures.decode(frame(99, true)), /no/);
  await assert.rejects(pictures.decode(frame(1)), /missing/);
});

test('VideoPictures: a decoder that holds pictures back is left', async () => {
  const { pictures, log } = video(1);
  await assert.rejects(pictures.decode(frame(1, true)), /held back/);
  assert.equal(log.at(-1), 'This browser holds pictures of a video back.');
  await assert.rejects(pictures.decode(frame(2)), /missing/);
});

test('VideoPictures: what a connection that ended still decodes is thrown away', async () => {
  const { pictures, log, output } = video();
  const old = pictures.decode(frame(1, true));
  pictures.reset();
  output(1);
  await assert.rejects(old, /ended/);
  assert.deepEqual(log, ['1 takes key 1', 'closed 1']);
  await assert.rejects(pictures.decode(frame(2)), /missing/);
});

const browser = (supported: boolean): Pick<typeof VideoDecoder, 'isConfigSupported'> => ({
  isConfigSupported: async (config) => ({ config, supported }),
});

test('videoFault: tells apart why there is no video', async () => {
  assert.equal(await videoFault(browser(true), true), null);
  assert.match((await videoFault(browser(false), true)) ?? '', /VP9/);
  assert.match((await videoFault(undefined, false)) ?? '', /https/);
  assert.match((await videoFault(undefined, true)) ?? '', /cannot decode video/);
});

test('VideoSupport: who asks for a video that cannot be shown is told once, also where that is found out later', async () => {
  for (const fault of ['No.', null]) {
    const [said, changes]: [string[], boolean[]] = [[], []];
    const support: VideoSupport = new VideoSupport(
      { changed: () => changes.push(support.works), notice: (text) => said.push(text) },
      Promise.resolve(fault),
    );
    support.asked('automatic');
    await Promise.resolve();
    assert.deepEqual([said, changes], [[], [fault === null]]);
    for (const codec of ['vp9', 'vp9', 'jpeg']) support.asked(codec);
    support.failed('It broke.');
    support.failed('It broke again.');
    assert.deepEqual(said, [fault === null ? 'It broke. Pictures come as JPEG.' : 'No. Pictures come as JPEG.']);
    assert.equal(support.works, false);
  }
});
