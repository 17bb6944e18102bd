// Saved views and the comparison of two pictures, against the fake server. Part of client_test.mjs; run alone:
// node tests/browser/views_test.mjs.

import { pathToFileURL } from 'node:url';
import { Session } from './fake_session.mjs';
import { badControls } from './look.mjs';
import { Checks, expect, pause, typeNumber, until } from './page.mjs';

const DESKTOP = { width: 1440, height: 900 };
const far = (a, b) => Math.hypot(...a.map((value, i) => value - b[i]));
const position = async (session) => (await session.state()).camera.position;

async function chooseView(page, label) {
  await page.getByRole('button', { name: 'Viewpoint' }).click();
  await page.getByRole('menuitem', { name: label }).click();
}

async function setExposure(session, value) {
  await typeNumber(session.page, 'exposure', value);
  await until('the echo', 5000, async () => (await session.state()).settings.exposure === value);
}

async function saved(checks, session) {
  const { page } = session;
  await checks.check('a view is saved with a small picture, and found again with its settings', async () => {
    await setExposure(session, 1);
    const there = await position(session);
    await chooseView(page, /^Save this view/);
    await page.locator('.toast', { hasText: 'Saved as Cornell 1' }).waitFor({ timeout: 20_000 });
    await setExposure(session, 0);
    await page.locator('body > canvas').focus();
    await page.keyboard.down('w');
    await pause(400);
    await page.keyboard.up('w');
    await session.shown('cornell');
    expect(far(await position(session), there) > 0.01, 'the camera did not move');
    await page.getByRole('button', { name: 'Viewpoint' }).click();
    const picture = page.locator('.menu-picture');
    const width = await picture.evaluate((image) => image.decode().then(() => image.naturalWidth));
    expect(width === 96, `${width} px`);
    await session.screenshot('saved-views');
    await page.getByRole('menuitem', { name: 'Cornell 1' }).click();
    await until('the place', 8000, async () => far(await position(session), there) < 1e-3);
    await until('the setting', 5000, async () => (await session.state()).settings.exposure === 1);
  });
  await checks.check('saved views outlast a reload and can be forgotten', async () => {
    await page.reload();
    await session.shown('cornell');
    await page.getByRole('button', { name: 'Viewpoint' }).click();
    expect((await page.getByRole('menuitem', { name: 'Cornell 1' }).count()) === 1, 'it is gone');
    await page.getByRole('menuitem', { name: 'Forget saved views' }).click();
    await page.getByRole('button', { name: 'Viewpoint' }).click();
    expect((await page.getByRole('menuitem', { name: 'Cornell 1' }).count()) === 0, 'it stays');
    await page.keyboard.press('Escape');
  });
}

/** Mean of the colours of the frozen picture and of the present one in the same column, 0..255 each. */
const columns = (page) =>
  page.evaluate(() => {
    const mean = (canvas) => {
      const copy = document.createElement('canvas');
      [copy.width, copy.height] = [8, 8];
      const context = copy.getContext('2d');
      context.drawImage(canvas, 0, 0, 8, 8);
      const { data } = context.getImageData(0, 0, 8, 8);
      return data.filter((_, i) => i % 4 < 3).reduce((sum, value) => sum + value, 0) / 192;
    };
    return { frozen: mean(document.querySelector('.compare-frozen')), now: mean(document.querySelector('body > canvas')) };
  });

async function compared(checks, session) {
  const { page } = session;
  const handle = page.getByRole('slider', { name: /^Border between/ });
  await checks.check('a frozen picture is wiped over the one that changes', async () => {
    await setExposure(session, 0);
    await session.shown('cornell');
    await chooseView(page, /^Compare/);
    const before = await columns(page);
    expect(Math.abs(before.frozen - before.now) < 3, `${before.frozen} and ${before.now}`);
    await setExposure(session, 2);
    await session.shown('cornell');
    await until('another picture', 8000, async () => (await columns(page)).now > before.now + 10);
    expect(Math.abs((await columns(page)).frozen - before.frozen) < 1, 'the frozen picture changed');
    await page.mouse.move(720, 450);
    await page.mouse.down();
    await page.mouse.move(500, 460, { steps: 4 });
    await page.mouse.up();
    const share = Number(await handle.getAttribute('aria-valuenow'));
    expect(Math.abs(share - 35) < 3, `${share} %`);
    await session.screenshot('compare');
    const bad = await badControls(page);
    expect(bad.length === 0, bad.join('\n'));
  });
  await checks.check('arrows move the border, and Escape ends comparing', async () => {
    await handle.focus();
    const before = Number(await handle.getAttribute('aria-valuenow'));
    const camera = await position(session);
    await page.keyboard.press('ArrowRight');
    await page.keyboard.press('ArrowRight');
    expect(Number(await handle.getAttribute('aria-valuenow')) === before + 4, await handle.getAttribute('aria-valuenow'));
    await page.keyboard.press('End');
    expect((await handle.getAttribute('aria-valuenow')) === '100', 'End does not go to the end');
    expect(far(await position(session), camera) === 0, 'the camera moved');
    await page.keyboard.press('Escape');
    expect(await page.locator('.compare').isHidden(), 'it stays');
    expect((await page.evaluate(() => document.activeElement.tagName)) === 'CANVAS', 'the focus is elsewhere');
  });
}

/** Runs everything; failures and passes are counted in `checks`. */
export async function viewsChecks(checks) {
  const session = new Session();
  try {
    if (!(await checks.check('the page is ready for views', () => session.start(DESKTOP)))) return;
    await saved(checks, session);
    await compared(checks, session);
    await checks.check('nothing was wrong in the browser\u2019s console (views)', async () => {
      expect(session.browser.problems.length === 0, session.browser.problems.join('\n'));
    });
  } finally {
    await session.stop();
  }
}

if (import.meta.url === pathToFileURL(process.argv[1]).href) {
  const checks = new Checks();
  await viewsChecks(checks);
  checks.finish();
}
