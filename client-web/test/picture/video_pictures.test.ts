import assert from 'node:assert/strict';
import { test } from 'node:test';
import { VideoPictures } from '../../src/picture/video_pictures.js';
import { videoFaults, VideoSupport, type VideoFaults } from '../../src/picture/video_support.js';
import type { Frame, VideoCodec } from '../../src/wire/frame.js';

const frame = (frameId: number, key = false, codec: VideoCodec = 'vp9'): Frame =>
  ({ frameId, key, codec, payload: new Uint8Array([frameId]) }) as Frame;

/** A decoder that puts a picture out when it is told to. */
function video(heldMs?: number) {
  const log: string[] = [];
  let init: VideoDecoderInit | null = null;
  let made = 0;
  const pictures = new VideoPictures<{ id: number; frameId: number; close(): void }>({
    decoder: (given) => {
      init = given;
      const number = ++made;
      const decoder = {
        state: 'unconfigured' as CodecState,
        configure: ({ codec }: VideoDecoderConfig) => {
          if (codec !== 'vp09.00.61.08') log.push(`${number} is for ${codec}`);
          decoder.state = 'configured';
        },
        decode: (chunk: EncodedVideoChunk) => {
          log.push(`${number} takes ${chunk.type} ${chunk.timestamp}`);
          if (chunk.byteLength === 99) throw new Error('no');
        },
        close: () => (decoder.state = 'closed'),
      };
      return decoder;
    },
    chunk: ({ type, timestamp, data }) => ({ type, timestamp, byteLength: (data as Uint8Array)[0] }) as EncodedVideoChunk,
    image: async ({ timestamp }, { frameId }) => ({ id: timestamp, frameId, close: () => undefined }),
    failed: (codec, reason) => log.push(`${codec}: ${reason}`),
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
  assert.deepEqual(log.filter((line) => !line.includes('takes')), ['vp9: This browser fails to decode VP9 (lost).']);
});

test('VideoPictures: a chunk that is refused at once is one that cannot be decoded', async () => {
  const { pictures } = video();
  await assert.rejects(pictures.decode(frame(99, true)), /no/);
  await assert.rejects(pictures.decode(frame(1)), /missing/);
});

test('VideoPictures: a decoder that holds pictures back is left', async () => {
  const { pictures, log } = video(1);
  await assert.rejects(pictures.decode(frame(1, true)), /held back/);
  assert.equal(log.at(-1), 'vp9: This browser holds pictures of a video (VP9) back.');
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

test('VideoPictures: another codec is another video, with a decoder of its own, and its failures are counted anew', async () => {
  const { pictures, log, output, error } = video();
  for (const time of [1, 2]) {
    const broken = pictures.decode(frame(time, true));
    error('lost');
    await assert.rejects(broken, /lost/);
  }
  const old = pictures.decode(frame(3, true));
  await assert.rejects(pictures.decode(frame(4, false, 'h264')), /missing/);
  await assert.rejects(old, /another video/);
  const first = pictures.decode(frame(5, true, 'h264'));
  output(4);
  assert.equal((await first).frameId, 5, 'the picture is cut as its own frame says');
  for (const time of [6, 7, 8]) {
    const broken = pictures.decode(frame(time, true, 'h264'));
    error('lost');
    await assert.rejects(broken, /lost/);
  }
  const said = log.filter((line) => !line.includes('takes') && !line.includes('closed'));
  assert.deepEqual(said.filter((line) => line.includes('is for')).length, 3);
  assert.equal(said[0], '4 is for avc1.42e034');
  assert.deepEqual(said.filter((line) => line.includes(':')), ['h264: This browser fails to decode H.264 (lost).']);
});

const browser = (...known: string[]): Pick<typeof VideoDecoder, 'isConfigSupported'> => ({
  isConfigSupported: async (config) => {
    if (known.includes('refuses')) throw new TypeError('refused');
    return { config, supported: known.some((start) => config.codec.startsWith(start)) };
  },
});

test('videoFaults: tells apart why there is no video, by codec', async () => {
  assert.deepEqual(await videoFaults(browser('vp09', 'avc1'), true), { vp9: null, h264: null });
  assert.deepEqual(await videoFaults(browser('vp09'), true), { vp9: null, h264: 'This browser cannot decode H.264.' });
  assert.deepEqual(await videoFaults(browser('avc1'), true), { vp9: 'This browser cannot decode VP9.', h264: null });
  assert.match((await videoFaults(browser('refuses'), true)).h264 ?? '', /H\.264/);
  assert.match((await videoFaults(undefined, false)).vp9 ?? '', /https/);
  assert.match((await videoFaults(undefined, true)).h264 ?? '', /cannot decode video/);
});

/** What is said to the viewer and to the server. `made`: by the server. */
async function support(faults: VideoFaults, made: readonly string[] = ['vp9', 'h264']) {
  const [said, told]: [string[], Record<string, boolean>[]] = [[], []];
  const support: VideoSupport = new VideoSupport(
    { changed: () => told.push(support.shown), notice: (text) => said.push(text) },
    Promise.resolve(faults),
  );
  support.served(made);
  support.asked('automatic');
  await Promise.resolve();
  return { support, said, told };
}

test('VideoSupport: who asks for a video that cannot be shown is told once', async () => {
  for (const codec of ['vp9', 'h264'] as const) {
    for (const fault of ['No.', null]) {
      const { support: video, said, told } = await support({ vp9: null, h264: null, [codec]: fault });
      assert.deepEqual([said, told], [[], [{ vp9: true, h264: true, [codec]: fault === null }]]);
      for (const asked of [codec, codec, 'jpeg']) video.asked(asked);
      assert.deepEqual(said, fault === null ? [] : ['No. Pictures come as JPEG.']);
      video.asked(codec);
      said.length = 0;
      video.failed(codec, 'It broke.');
      video.failed(codec, 'It broke again.');
      assert.deepEqual(said, fault === null ? ['It broke. Pictures come as JPEG.'] : []);
      assert.equal(video.shown[codec], false);
    }
  }
});

test('VideoSupport: it is told also where that is found out later', async () => {
  const said: string[] = [];
  const video = new VideoSupport(
    { changed: () => undefined, notice: (text) => said.push(text) },
    Promise.resolve({ vp9: null, h264: 'No.' }),
  );
  video.served(['vp9', 'h264']);
  video.asked('h264');
  assert.match(said.pop() ?? '', /not known yet/);
  await Promise.resolve();
  assert.deepEqual(said, ['No. Pictures come as JPEG.']);
});

test('VideoSupport: a server that is built without the codec is named as what lacks it', async () => {
  const { support: video, said } = await support({ vp9: null, h264: null }, ['vp9']);
  video.asked('h264');
  assert.deepEqual(said, ['This server is built without H.264. Pictures come as JPEG.']);
  assert.deepEqual(video.shown, { vp9: true, h264: true }, 'the server is told what the browser can');
  video.asked('vp9');
  assert.equal(said.length, 1);
});

test('VideoSupport: where another video takes the place of one that fails nobody is told', async () => {
  const { support: video, said, told } = await support({ vp9: null, h264: null });
  video.failed('h264', 'It broke.');
  assert.deepEqual([said, told.at(-1)], [[], { vp9: true, h264: false }]);
  video.failed('vp9', 'It broke too.');
  assert.deepEqual(said, ['It broke too. Pictures come as JPEG.']);
});
