// Pictures of a changing view as a video, in a real browser: they come, they look like the server's, one that is lost ends nothing,
// and a browser without a decoder is sent JPEG and says so. Part of stream_test.mjs. HELIOGRAPH_H264=1: the server is built with it.

import { expect, pause, until } from './page.mjs';

const H264 = process.env.HELIOGRAPH_H264 === '1';

const stateOf = (page) => page.evaluate(() => window.heliograph.state);

async function choose(page, codec) {
  await page.evaluate(() => document.querySelectorAll('details').forEach((group) => (group.open = true)));
  await page.locator('[data-setting="codec"] select').selectOption({ label: codec }, { force: true });
  await until('the echo of codec', 10_000, async () => (await stateOf(page)).settings.codec === codec);
}

/** Mean difference of the codes on the canvas from those of a PNG file. */
const meanDifference = (page, png) =>
  page.evaluate(async (base64) => {
    const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
    const image = await createImageBitmap(new Blob([bytes], { type: 'image/png' }), { colorSpaceConversion: 'none' });
    const canvas = document.querySelector('body > canvas');
    const pixelsOf = (source) => {
      const context = new OffscreenCanvas(source.width, source.height).getContext('2d');
      context.drawImage(source, 0, 0);
      return context.getImageData(0, 0, source.width, source.height).data;
    };
    const [shown, saved] = [pixelsOf(canvas), pixelsOf(image)];
    return saved.reduce((sum, code, i) => sum + Math.abs(code - shown[i]), 0) / saved.length;
  }, png.toString('base64'));

/** As long as samples come, the picture is the video's, moving or not. */
const video = (page, codec = 'vp9') =>
  until(`a picture of a video (${codec})`, 20_000, async () => (await stateOf(page)).lastFrame.codec === codec);

async function seen(page, codec, { set, drag, exact, savedPicture }) {
  await set(page, 'samples', 65536);
  await choose(page, codec);
  await drag(page, 20);
  await video(page, codec);
  await page.mouse.up();
  await until('many samples', 30_000, async () => (await stateOf(page)).lastFrame.samples > 64);
  expect((await stateOf(page)).lastFrame.codec === codec, 'what refines is no video');
  const difference = await meanDifference(page, await savedPicture(page));
  expect(difference > 0 && difference < 4, `codes differ by ${difference} in the mean`);
  await set(page, 'samples', 4);
  await exact(page);
}

/** JPEG comes, and the page says why. */
async function instead(page, codec, why, { set, drag }) {
  await set(page, 'samples', 65536);
  await choose(page, codec);
  await page.getByText(why, { exact: false }).first().waitFor({ timeout: 10_000 });
  const before = (await stateOf(page)).framesPresented;
  await drag(page, 20);
  await pause(100);
  await until('pictures', 20_000, async () => (await stateOf(page)).framesPresented > before + 2);
  expect((await stateOf(page)).lastFrame.codec === 'jpeg', 'a video came');
  await page.mouse.up();
}

/** Of a server that has the codec, in sizes that it does not code as they are; of another one that JPEG comes. */
async function h264Checks(checks, open, tools) {
  if (!H264) {
    await checks.check('a server that is built without H.264 sends JPEG, and the page says so', async () => {
      const [page] = await open({});
      await instead(page, 'h264', 'This server is built without H.264. Pictures come as JPEG.', tools);
    });
    return;
  }
  await checks.check('a moving view is H.264 where that is asked for, of odd sizes too', async () => {
    const [page] = await open({});
    await page.setViewportSize({ width: 1101, height: 701 });
    await until('the other size', 20_000, async () => (await stateOf(page)).lastFrame.width % 2 === 1);
    await seen(page, 'h264', tools);
  });
  await checks.check('one video follows another', async () => {
    const [page] = await open({});
    await tools.set(page, 'samples', 65536);
    for (const codec of ['h264', 'vp9', 'h264']) {
      await choose(page, codec);
      await tools.drag(page, 20);
      await video(page, codec);
      await page.mouse.up();
    }
  });
}

/** `tools`: set, drag, exact and savedPicture of stream_test.mjs. `open(line, script)`: another page; the script runs before its own. */
export async function codecChecks(checks, open, tools) {
  const { set, drag, exact } = tools;
  await checks.check('a moving view is a video where that is asked for, and exact at rest', async () => {
    const [page] = await open({});
    await seen(page, 'vp9', tools);
  });
  await h264Checks(checks, open, tools);
  await checks.check('a picture of a video that is lost ends nothing', async () => {
    const [page] = await open({}, () => {
      const { decode } = VideoDecoder.prototype;
      window.lost = 0;
      VideoDecoder.prototype.decode = function (chunk) {
        if (window.loses && chunk.type === 'delta') {
          window.loses = false;
          window.lost += 1;
          throw new DOMException('lost');
        }
        return decode.call(this, chunk);
      };
    });
    await set(page, 'samples', 65536);
    await choose(page, 'vp9');
    await drag(page, 10);
    await video(page);
    await page.evaluate(() => (window.loses = true));
    await drag(page, 20);
    await until('the loss', 10_000, () => page.evaluate(() => window.lost === 1));
    const { frameId } = (await stateOf(page)).lastFrame;
    await drag(page, 20);
    await until('the video goes on', 20_000, async () => {
      const { lastFrame } = await stateOf(page);
      return lastFrame.codec === 'vp9' && lastFrame.frameId > frameId;
    });
    await page.mouse.up();
    await set(page, 'samples', 4);
    await exact(page);
  });
  await checks.check('a browser that decodes no video is sent JPEG, and says so', async () => {
    const [page] = await open({}, () => delete window.VideoDecoder);
    await instead(page, 'vp9', 'Pictures come as JPEG.', tools);
  });
}
