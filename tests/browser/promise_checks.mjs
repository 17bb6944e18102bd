// What a viewer is promised, against a real server: a time budget that a moving picture keeps by leaving things out and that a
// resting one does not feel, and an error target at which the picture ends. Part of stream_test.mjs.

import { join } from 'node:path';
import { compared, savedPicture } from './look.mjs';
import { expect, outFolder, pause, until } from './page.mjs';

const stateOf = (page) => page.evaluate(() => window.heliograph.state);

async function budget(checks, page, { set, drag, exact }) {
  const list = page.locator('#statistics-panel .hurry');
  await checks.check('for a time budget a drag does without what the list says, and rest with nothing', async () => {
    await set(page, 'ambientOcclusion', true);
    await set(page, 'aoSamples', 64);
    await set(page, 'timeBudget', 12);
    let text = '';
    await until('the list', 60_000, async () => {
      await drag(page, 60);
      text = (await list.isVisible()) ? await list.innerText() : '';
      await page.mouse.up();
      return /Time budget 12 ms: /i.test(text) && /AO samples 64 → \d+/.test(text);
    });
    const [, rest] = text.match(/: ([\d.]+) ms a picture/i);
    const [, without] = text.match(/AO samples 64 → \d+\s+([\d.]+) ms without/);
    expect(Number(without) > Number(rest), text); // the step is told to save something
    await page.screenshot({ path: join(outFolder, 'budget-drag.png') });
    await exact(page);
    expect((await stateOf(page)).settings.aoSamples === 64, 'a setting was changed');
    const withBudget = await savedPicture(page);
    const { different, pixels, same } = await compared(page, withBudget);
    expect(same && different === 0, `${different} of ${pixels} pixels differ from the server's`);
    await set(page, 'timeBudget', 0);
    for (const samples of [63, 64]) {
      await set(page, 'aoSamples', samples); // a picture of its own, not the one before sent again
      await exact(page);
    }
    const after = await compared(page, withBudget);
    expect(after.same && after.different === 0, `${after.different} of ${after.pixels} pixels differ from those without a budget`);
    await until('no list without a budget', 5000, async () => !(await list.isVisible()));
  });
}

async function target(checks, page, { set, exact }) {
  await checks.check('at an error target the picture ends, exact, and no sample more is taken', async () => {
    await set(page, 'samples', 1024);
    await set(page, 'errorTarget', 8);
    await exact(page);
    const { lastFrame } = await stateOf(page);
    expect(lastFrame.final && lastFrame.samples < 1024, `${lastFrame.samples} samples, final ${lastFrame.final}`);
    const line = page.locator('#statistics-panel .line', { hasText: 'Relative error' });
    let error = NaN; // the statistics are written a moment after the picture
    await until('the target in the statistics', 5000, async () => {
      error = Number((await line.textContent()).match(/([\d.]+) % · target reached$/)?.[1]);
      return !Number.isNaN(error);
    });
    expect(error <= 8 && error > 0, `${error} %`);
    await page.screenshot({ path: join(outFolder, 'target-reached.png') });
    await pause(1500);
    expect((await stateOf(page)).lastFrame.samples === lastFrame.samples, 'samples went on');
    await set(page, 'errorTarget', 0);
    await until('more samples', 30_000, async () => (await stateOf(page)).lastFrame.samples > lastFrame.samples);
    await set(page, 'samples', 4);
    await set(page, 'aoSamples', 9);
    await set(page, 'ambientOcclusion', false);
    await exact(page);
  });
}

/** Shows or folds the statistics. */
const fold = (page) => page.locator('#statistics-panel .panel-head').click();

export async function promiseChecks(checks, page, by) {
  const folded = await page.locator('#statistics-panel .panel-body').isHidden();
  if (folded) await fold(page);
  await budget(checks, page, by);
  await target(checks, page, by);
  if (folded) await fold(page);
}
