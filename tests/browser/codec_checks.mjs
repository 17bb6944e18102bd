// Pictures of a changing view as a video, in a real browser: they come, they look like the server's, one that is lost ends nothing,
// and a browser without a decoder is sent JPEG and says so. Part of stream_test.mjs.

import { expect, pause, until } from './page.mjs';

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
const video = (page) => until('a picture of a video', 20_000, async () => (await stateOf(page)).lastFrame.codec === 'vp9');

/** `tools`: set, drag, exact and savedPicture of stream_test.mjs. `open(line, script)`: another page; the script runs before its own. */
export async function codecChecks(checks, open, { set, drag, exact, savedPicture }) {
  await checks.check('a moving view is a video where that is asked for, and exact at rest', async () => {
    const [page] = await open({});
    await set(page, 'samples', 65536);
    await choose(page, 'vp9');
    await drag(page, 20);
    await video(page);
    await page.mouse.up();
    await until('many samples', 30_000, async () => (await stateOf(page)).lastFrame.samples > 64);
    expect((await stateOf(page)).lastFrame.codec === 'vp9', 'what refines is no video');
    const difference = await meanDifference(page, await savedPicture(page));
    expect(difference > 0 && difference < 4, `codes differ by ${difference} in the mean`);
    await set(page, 'samples', 4);
    await exact(page);
  });
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
    await set(page, 'samples', 65536);
    await choose(page, 'vp9');
    await page.getByText('Pictures come as JPEG.', { exact: false }).first().waitFor({ timeout: 10_000 });
    const before = (await stateOf(page)).framesPresented;
    await drag(page, 20);
    await pause(100);
    await until('pictures', 20_000, async () => (await stateOf(page)).framesPresented > before + 2);
    expect((await stateOf(page)).lastFrame.codec === 'jpeg', 'a video came');
    await page.mouse.up();
  });
}
