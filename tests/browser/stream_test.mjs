// The stream in a real browser: the picture at rest is the server's byte for byte, a page that nobody sees is sent nothing, and what
// limits is told. Part of client_test.mjs; run alone: node tests/browser/stream_test.mjs. Writes screenshots to out/browser.

import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { Line, LINES } from '../load/line.mjs';
import { codecChecks } from './codec_checks.mjs';
import { promiseChecks } from './promise_checks.mjs';
import { compared, savedPicture } from './look.mjs';
import { Browser, Checks, expect, freePort, outFolder, pause, Server, unfoldFor, until } from './page.mjs';

const SIZE = { width: 1100, height: 700 };

const stateOf = (page) => page.evaluate(() => window.heliograph.state);

const exact = (page) =>
  until('an exact picture', 60_000, async () => {
    const { lastFrame, lastInputId } = await stateOf(page);
    return lastFrame?.exact && lastFrame.inputId === lastInputId;
  });

async function set(page, name, value) {
  await unfoldFor(page, name);
  const field = page.locator(`[data-setting="${name}"]`);
  if (typeof value === 'string') await field.locator('select').selectOption({ label: value }, { force: true });
  else if (typeof value === 'boolean') await field.locator('input[type=checkbox]').setChecked(value, { force: true });
  else {
    await field.locator('.number-field').fill(String(value));
    await field.locator('.number-field').press('Enter');
  }
  await until(`the echo of ${name}`, 10_000, async () => (await stateOf(page)).settings[name] === value);
}

async function drag(page, steps) {
  await page.mouse.move(440, 460);
  await page.mouse.down();
  for (let i = 1; i <= steps; i++) {
    await page.mouse.move(440 + 100 * Math.sin(i / 20), 460 + (i % 7));
    await pause(16);
  }
}

async function exactChecks(checks, page) {
  await checks.check('at rest the canvas is the server\u2019s picture, byte for byte', async () => {
    await exact(page);
    const { different, pixels, same } = await compared(page, await savedPicture(page));
    expect(same && pixels > 100_000, `${pixels} pixels`);
    expect(different === 0, `${different} of ${pixels} pixels differ`);
    await page.locator('.limit').getByText('Exact').waitFor({ timeout: 20_000 });
    await page.screenshot({ path: join(outFolder, 'badge-exact.png') });
  });
  await checks.check('without that setting the last picture is a JPEG, and differs', async () => {
    await set(page, 'exactAtRest', false);
    await until('the last picture', 30_000, async () => (await stateOf(page)).lastFrame.final);
    await pause(500);
    expect(!(await stateOf(page)).lastFrame.exact, 'it is said to be exact');
    const { different, pixels } = await compared(page, await savedPicture(page));
    expect(different > pixels / 100, `${different} of ${pixels} pixels differ: what would the test see?`);
    await set(page, 'exactAtRest', true);
    await exact(page);
  });
  await checks.check('a denoised picture says so, and is the server\u2019s all the same', async () => {
    await set(page, 'denoiser', 'filter');
    await until('a denoised picture', 30_000, async () => {
      const { lastFrame } = await stateOf(page);
      return lastFrame.denoised && lastFrame.exact;
    });
    await page.locator('.limit').getByText('Denoised').waitFor({ timeout: 20_000 });
    const { different, pixels } = await compared(page, await savedPicture(page));
    expect(different === 0, `${different} of ${pixels} pixels differ`);
    await page.screenshot({ path: join(outFolder, 'badge-denoised.png') });
    await set(page, 'denoiser', 'off');
    await exact(page);
    await page.locator('.limit').getByText('Exact').waitFor({ timeout: 20_000 });
    expect(!(await stateOf(page)).lastFrame.denoised, 'it is still denoised');
  });
  await checks.check('a denoiser that the server has not is told of, and the picture stays', async () => {
    await set(page, 'denoiser', 'oidn');
    await page.getByText('Open Image Denoise is not on this machine').first().waitFor({ timeout: 20_000 });
    await exact(page);
    await set(page, 'denoiser', 'off');
  });
  await checks.check('the trace holds each step of a frame', async () => {
    await drag(page, 10);
    await page.mouse.up();
    await exact(page);
    const download = page.waitForEvent('download');
    await page.getByRole('button', { name: 'Save', exact: false }).first().click();
    await page.getByText('chrome://tracing').click();
    const { traceEvents } = JSON.parse(readFileSync(await (await download).path(), 'utf8'));
    for (const name of ['event to message', 'to the server', 'render', 'develop', 'encode', 'to the page', 'decode', 'to the screen']) {
      expect(traceEvents.some((event) => event.name === name && event.ph === 'b'), `no ${name}`);
    }
  });
  await checks.check('moving ends it, and the next rest is exact again', async () => {
    await drag(page, 10);
    await until('a picture of the motion', 10_000, async () => !(await stateOf(page)).lastFrame.exact);
    await page.mouse.up();
    await exact(page);
    const { different } = await compared(page, await savedPicture(page));
    expect(different === 0, `${different} pixels differ`);
  });
}

async function hiddenChecks(checks, page, line) {
  const hide = (hidden) =>
    page.evaluate((value) => {
      Object.defineProperty(document, 'hidden', { value, configurable: true });
      document.dispatchEvent(new Event('visibilitychange'));
    }, hidden);
  await checks.check('a page that nobody sees is sent no picture, and the newest once it is seen', async () => {
    await hide(true);
    await pause(300);
    const { framesPresented } = await stateOf(page);
    const before = line.received;
    await page.keyboard.press('ArrowLeft', { delay: 400 });
    await pause(600);
    const state = await stateOf(page);
    const bytes = line.received - before;
    expect(bytes < 20_000, `${bytes} bytes`);
    expect(state.framesPresented === framesPresented, `${state.framesPresented - framesPresented} pictures`);
    expect(state.lastInputId > state.lastFrame.inputId, 'nothing was asked for meanwhile: what would the test see?');
    await hide(false);
    await exact(page);
  });
}

async function badgeChecks(checks, browserFor) {
  for (const [name, line, label] of [
    ['server', {}, 'Server'],
    ['line', LINES['2 Mbit/s 50 ms'], 'Line'],
  ]) {
    await checks.check(`the page says that the ${name} limits`, async () => {
      const page = await browserFor(line);
      // Dear enough for any machine, or cheap enough for any line to be the shorter one.
      if (name === 'server') for (const [setting, value] of [['shadowSamples', 64], ['frameRate', 60]]) await set(page, setting, value);
      else await set(page, 'automaticScale', false);
      await drag(page, 60);
      // The server and the browser share the processors here: which of them is the slower one is not for the test to say.
      const labels = name === 'server' ? /^(server|this computer)$/i : new RegExp(`^${label}$`);
      const badge = page.locator('.limit:visible').getByText(labels);
      for (let i = 0; i < 20 && (await badge.count()) === 0; i++) await drag(page, 20);
      expect((await badge.count()) > 0, `it says ${JSON.stringify((await stateOf(page)).pace)}`);
      await page.screenshot({ path: join(outFolder, `badge-${name}.png`) });
      await page.mouse.up();
    });
  }
}

export async function streamChecks(checks) {
  const server = new Server(await freePort(), 'cornell');
  const opened = []; // browsers and lines
  const open = async (line, script = () => undefined) => {
    const [browser, relay] = [new Browser(), await Line.open(server.port, { delayMs: 0, ...line })];
    opened.push([browser, relay]);
    const page = await browser.start(SIZE);
    await page.addInitScript(script);
    await page.goto(`http://127.0.0.1:${relay.port}/`);
    await until('a picture', 60_000, () => page.evaluate(() => window.heliograph?.state.lastFrame != null));
    return [page, relay];
  };
  try {
    if (!(await checks.check('the server starts (stream)', () => server.start()))) return;
    const [page, relay] = await open({});
    await set(page, 'samples', 4);
    await exactChecks(checks, page);
    await promiseChecks(checks, page, { set, drag, exact });
    await hiddenChecks(checks, page, relay);
    await codecChecks(checks, open, { set, drag, exact, savedPicture });
    await badgeChecks(checks, async (line) => (await open(line))[0]);
    await checks.check('nothing was wrong in the browser\u2019s console (stream)', () => {
      const problems = opened.flatMap(([browser]) => browser.problems);
      expect(problems.length === 0, problems.join('\n'));
    });
  } finally {
    for (const [browser, relay] of opened) {
      await browser.stop();
      relay.close();
    }
    await server.kill();
  }
}

if (import.meta.url === pathToFileURL(process.argv[1]).href) {
  const checks = new Checks();
  await streamChecks(checks);
  checks.finish();
}
