// How the picture follows the hand: drags in a real browser, over lines of different delay and rate.
//
//   node tests/load/feel.mjs [--scenes courtyard,cathedral,glass] [--lines free,"300 ms",...] [--seconds 6]
//                            [--size 1280x720] [--set name=value]... [--drag FILE.svg] [--json FILE]
//
// A table on stdout: pictures a second while dragging, motion to photon (median and 95 %), how long after letting go the last
// input was seen and the picture was full again, bytes a second, and the width of the pictures. HELIOGRAPH_BINARY and
// HELIOGRAPH_CHROMIUM name other programs. --drag plots scale and rate over the first drag. It measures; it judges nothing.
import { writeFileSync } from 'node:fs';
import { parseArgs } from 'node:util';

import { Browser, freePort, pause, Server, until } from '../browser/page.mjs';
import { dragPlot } from './feel_plot.mjs';
import { Line, LINES } from './line.mjs';

const STEP_MS = 16;
const PATIENCE = 60_000;

const { values: options } = parseArgs({
  options: {
    scenes: { type: 'string', default: 'courtyard,cathedral,glass' },
    lines: { type: 'string', default: Object.keys(LINES).join(',') },
    seconds: { type: 'string', default: '6' },
    size: { type: 'string', default: '1280x720' },
    set: { type: 'string', multiple: true, default: [] },
    drag: { type: 'string' },
    json: { type: 'string' },
  },
});
const [width, height] = options.size.split('x').map(Number);
const lines = options.lines.split(',');
for (const name of lines) if (LINES[name] === undefined) throw new Error(`--lines: ${name}, allowed: ${Object.keys(LINES)}`);

/** Waits in the page, frame by frame; milliseconds from now, or null when it takes too long. */
const waitInPage = (page, condition, patience) =>
  page.evaluate(
    ([source, patience]) =>
      new Promise((done) => {
        const begin = performance.now();
        const holds = new Function('state', `return ${source}`);
        const look = () => {
          const passed = performance.now() - begin;
          if (holds(window.heliograph.state)) done(passed);
          else if (passed > patience) done(null);
          else requestAnimationFrame(look);
        };
        look();
      }),
    [condition, patience],
  );

/** Notes of each picture, from now on: when it was seen, its width, its motion to photon where it shows a new input. */
const record = (page) =>
  page.evaluate(() => {
    const seen = (window.feelSeen = []);
    let [last, input] = [null, null];
    const look = () => {
      const { lastFrame, motionToPhotonMs } = window.heliograph.state;
      if (lastFrame !== null && lastFrame.frameId !== last) {
        const delay = lastFrame.inputId === input ? null : (motionToPhotonMs.last ?? null);
        seen.push([performance.now(), lastFrame.width, delay]);
      }
      last = lastFrame?.frameId ?? null;
      input = lastFrame?.inputId ?? null;
      requestAnimationFrame(look);
    };
    requestAnimationFrame(look);
  });

async function drag(page, seconds) {
  const middle = [width / 2, height / 2];
  await page.mouse.move(...middle);
  await page.mouse.down();
  const begin = performance.now();
  for (let next = begin; ; next += STEP_MS) {
    const time = performance.now() - begin;
    if (time > seconds * 1000) break;
    const turn = Math.sin((time / 1500) * Math.PI);
    await page.mouse.move(middle[0] + 0.3 * width * turn, middle[1] + 0.05 * height * Math.sin(time / 700));
    await pause(Math.max(0, next + STEP_MS - performance.now()));
  }
}

async function applySettings(page) {
  for (const entry of options.set) {
    const [name, value] = entry.split('=');
    const field = page.locator(`[data-setting="${name}"] :is(input, select)`).first();
    if ((await field.getAttribute('type')) === 'checkbox') await field.setChecked(value === 'true');
    else await field.fill(value).then(() => field.press('Enter'));
  }
}

async function measure(server, name) {
  const line = await Line.open(server.port, LINES[name]);
  const browser = new Browser();
  try {
    const page = await browser.start({ width, height });
    await page.goto(`http://127.0.0.1:${line.port}/`);
    await until('a picture', PATIENCE, () => page.evaluate(() => window.heliograph?.state.lastFrame != null));
    await applySettings(page);
    await until('a second sample', PATIENCE, () => page.evaluate(() => window.heliograph.state.lastFrame.samples > 1));
    await drag(page, 2); // what a line and a view can do is learnt by using them
    await page.mouse.up();
    await pause(1000);
    await record(page);
    const before = await page.evaluate(() => [performance.now(), window.heliograph.state.framesPresented]);
    const bytes = line.received;
    await drag(page, Number(options.seconds));
    const after = await page.evaluate(() => [
      performance.now(), window.heliograph.state.framesPresented, window.heliograph.state.motionToPhotonMs, window.feelSeen,
      window.heliograph.state.pace,
    ]);
    const sent = line.received - bytes;
    await page.mouse.up();
    const lastInput = await waitInPage(page, 'state.lastFrame.inputId >= state.lastInputId', 30_000);
    const full = await waitInPage(page, `state.lastFrame.width >= ${width}`, 30_000);
    const seconds = (after[0] - before[0]) / 1000;
    const delays = after[3].map(([, , delay]) => delay).filter((delay) => delay !== null).sort((a, b) => a - b);
    const quantile = (q) => delays[Math.min(delays.length - 1, Math.floor(q * delays.length))];
    const widths = after[3].map(([, w]) => w).sort((a, b) => a - b);
    return {
      line: name,
      picturesPerSecond: (after[1] - before[1]) / seconds,
      // A page that does not say the last one says those of the last 240 inputs.
      motionToPhotonMs: delays.length > 0 ? { median: quantile(0.5), p95: quantile(0.95) } : after[2],
      lastInputMs: lastInput,
      fullMs: lastInput === null || full === null ? null : lastInput + full,
      bytesPerSecond: sent / seconds,
      scale: { median: widths[widths.length >> 1] / width, least: widths[0] / width, most: widths.at(-1) / width },
      pace: after[4] ?? null,
      pictures: after[3].map(([time, w]) => [(time - before[0]) / 1000, w / width]),
    };
  } finally {
    await browser.stop();
    line.close();
  }
}

const number = (value, digits = 0) => (value === null || value === undefined ? '–' : value.toFixed(digits));
const results = [];
console.log('| scene | line | pictures/s | p50 ms | p95 ms | last input ms | full ms | kB/s | scale (least..most) | limit |');
console.log('| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |');
for (const scene of options.scenes.split(',')) {
  const server = new Server(await freePort(), scene);
  await server.start();
  try {
    for (const name of lines) {
      const r = { scene, ...(await measure(server, name)) };
      results.push(r);
      const { median, least, most } = r.scale;
      const cells = [scene, name, number(r.picturesPerSecond, 1), number(r.motionToPhotonMs.median), number(r.motionToPhotonMs.p95),
        number(r.lastInputMs), number(r.fullMs), number(r.bytesPerSecond / 1000),
        `${number(median, 2)} (${number(least, 2)}..${number(most, 2)})`, r.pace?.limit ?? '–'];
      console.log(`| ${cells.join(' | ')} |`);
    }
  } finally {
    await server.kill();
  }
}
if (options.drag) writeFileSync(options.drag, dragPlot(results[0]));
if (options.json) writeFileSync(options.json, JSON.stringify(results.map(({ pictures, ...rest }) => rest), null, 1) + '\n');
