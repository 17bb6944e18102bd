// The address of the page is the view, against the fake server. Part of client_test.mjs; run alone:
// node tests/browser/link_test.mjs.

import { pathToFileURL } from 'node:url';
import { Session } from './fake_session.mjs';
import { difference, picture } from './look.mjs';
import { Browser, Checks, expect, pause, typeNumber, until } from './page.mjs';

const DESKTOP = { width: 1440, height: 900 };

const far = (a, b) => Math.hypot(...a.map((value, i) => value - b[i]));
const position = async (session) => (await session.state()).camera.position;
const addressSays = (page, words) => until(`${words} in the address`, 5000, () => page.url().includes(words));

async function fly(session) {
  await session.page.locator('body > canvas').focus();
  await session.page.keyboard.down('w');
  await pause(300);
  await session.page.keyboard.up('w');
  await session.shown((await session.state()).scene.name);
}

async function exposure(session, value) {
  await typeNumber(session.page, 'exposure', value);
  await until('the echo', 5000, async () => (await session.state()).settings.exposure === value);
}

async function chooseCourtyard(session) {
  await session.page.locator('.picker').click();
  await session.page.getByRole('menuitemradio', { name: /^Courtyard/ }).click();
  await session.shown('courtyard');
}

async function reloads(checks, session) {
  const { page } = session;
  await checks.check('scene, camera and settings stand in the address, the defaults do not', async () => {
    await pause(600);
    expect(new URL(page.url()).hash === '', page.url());
    await chooseCourtyard(session);
    await fly(session);
    await exposure(session, 0.75);
    for (const words of ['scene=courtyard', 'at=', 'set.exposure=0.75']) await addressSays(page, words);
    expect(!page.url().includes('set.shadows'), page.url());
  });
  await checks.check('they are kept over a reload', async () => {
    const before = await session.state();
    await page.reload();
    await session.shown('courtyard');
    await until('the setting', 5000, async () => (await session.state()).settings.exposure === 0.75);
    const after = await session.state();
    expect(far(after.camera.position, before.camera.position) < 1e-4, `${after.camera.position}`);
  });
}

async function looks(checks, session) {
  const { page } = session;
  const menu = page.getByRole('button', { name: 'Look', exact: true });
  await checks.check('a scene with looks offers them, from where it is seen', async () => {
    if ((await session.state()).scene.name !== 'courtyard') await chooseCourtyard(session);
    expect(!(await menu.isVisible()), 'a scene without looks offers some');
    await page.locator('.picker').click();
    await page.getByRole('menuitemradio', { name: /^Cornell/ }).click();
    await session.shown('cornell');
    await fly(session);
    const before = (await session.state()).camera.position;
    await menu.click();
    expect(await page.getByRole('menuitemradio', { name: "The file's own" }).isChecked(), 'the own look');
    await page.getByRole('menuitemradio', { name: 'street' }).click();
    await session.shown('cornell#street');
    expect(far((await session.state()).camera.position, before) < 1e-4, 'the camera jumped');
    await addressSays(page, 'scene=cornell%23street');
    await menu.click();
    expect(await page.getByRole('menuitemradio', { name: 'street' }).isChecked(), 'the look that is shown');
    await page.keyboard.press('Escape');
  });
  await checks.check('a look is kept over a reload and given back', async () => {
    await page.reload();
    await session.shown('cornell#street');
    await menu.click();
    await page.getByRole('menuitemradio', { name: "The file's own" }).click();
    await session.shown('cornell');
    await chooseCourtyard(session);
  });
}

async function links(checks, session) {
  const { page } = session;
  const other = new Browser();
  try {
    await checks.check('a copied link shows the same picture in another browser', async () => {
      await session.browser.context.grantPermissions(['clipboard-read', 'clipboard-write']);
      await page.getByRole('button', { name: 'Copy link' }).click();
      await page.locator('.toast', { hasText: 'in the clipboard' }).waitFor({ timeout: 20_000 });
      const link = await page.evaluate(() => navigator.clipboard.readText());
      expect(link.includes('scene=courtyard') && link.includes('set.exposure=0.75'), link);
      const there = await other.start(DESKTOP);
      await there.goto(link);
      const final = (where) => where.evaluate(() => window.heliograph.state.lastFrame?.final === true);
      await until('both pictures', 20_000, async () => {
        const { settings, scene } = await there.evaluate(() => window.heliograph.state);
        const same = scene?.name === 'courtyard' && settings.exposure === 0.75;
        return same && (await final(page)) && (await final(there));
      });
      await pause(200);
      const apart = difference(await picture(page), await picture(there));
      expect(apart < 1, `mean difference ${apart}`);
    });
  } finally {
    await other.stop();
  }
  await checks.check('a scene that is not offered is said so, and its camera is not taken', async () => {
    const address = `http://127.0.0.1:${session.server.port}/`;
    await page.goto('about:blank');
    await page.goto(`${address}#scene=gone&at=1,2,3&look=0,0,-1&up=0,1,0&fov=40`);
    await session.shown('cornell');
    await page.locator('.toast', { hasText: 'gone' }).waitFor({ timeout: 20_000 });
    expect(far(await position(session), [1, 2, 3]) > 1, 'the camera of another scene');
  });
  await checks.check('nonsense in the address shows the server\u2019s own view', async () => {
    await page.goto('about:blank');
    await page.goto(`http://127.0.0.1:${session.server.port}/#at=1,2&look=0,0,0&set.exposure=x&set.nothing=1&%%%`);
    await session.shown('cornell');
    expect((await session.state()).settings.exposure === 0, 'exposure was set');
  });
}

async function histories(checks, session) {
  const { page } = session;
  await checks.check('back and forward go through views: a flight, a reset, another scene', async () => {
    await page.goto('about:blank');
    await page.goto(`http://127.0.0.1:${session.server.port}/`);
    await session.shown('cornell');
    const start = await position(session);
    await fly(session);
    const flown = await position(session);
    expect(far(flown, start) > 0.01, 'the camera did not move');
    await page.keyboard.press('r');
    await session.shown('cornell');
    await pause(600);
    await chooseCourtyard(session);
    await pause(600);
    const at = (place) => until(`the camera at ${place}`, 8000, async () => far(await position(session), place) < 1e-3);
    await page.goBack();
    await session.shown('cornell');
    await at(start);
    await page.goBack();
    await at(flown);
    await page.goForward();
    await at(start);
    await page.goForward();
    await session.shown('courtyard');
  });
}

async function framed(checks, session) {
  const { page } = session;
  await checks.check('V brings all of the scene into view, and Back leads back', async () => {
    const before = await position(session);
    await page.locator('body > canvas').focus();
    await page.keyboard.press('v');
    await session.shown('courtyard');
    expect(far(await position(session), before) > 0.5, 'the camera did not move');
    await pause(600);
    await page.goBack();
    await until('the place of before', 8000, async () => far(await position(session), before) < 1e-3);
  });
  await checks.check('the title says when the picture is done, and the hint comes once', async () => {
    await until('the mark', 20_000, async () => (await page.title()).startsWith('\u2713 Courtyard'));
    await page.keyboard.down('w');
    await until('no mark', 8000, async () => (await page.title()).startsWith('Courtyard'));
    await page.keyboard.up('w');
    await page.reload();
    await session.shown('courtyard');
    expect((await page.locator('.toast', { hasText: 'Drag to look around' }).count()) === 0, 'the hint again');
  });
}

/** Runs everything; failures and passes are counted in `checks`. */
export async function linkChecks(checks) {
  const session = new Session();
  try {
    if (!(await checks.check('the page is ready for links', () => session.start(DESKTOP)))) return;
    await checks.check('the first time a hint says how to move, until somebody does', async () => {
      const hint = session.page.locator('.toast', { hasText: 'Drag to look around' });
      await hint.waitFor({ timeout: 20_000 });
      await session.page.keyboard.press('Shift');
      expect((await hint.count()) === 0, 'the hint stays');
    });
    await reloads(checks, session);
    await links(checks, session);
    await histories(checks, session);
    await framed(checks, session);
    await looks(checks, session);
    await checks.check('nothing was wrong in the browser\u2019s console (links)', async () => {
      expect(session.browser.problems.length === 0, session.browser.problems.join('\n'));
    });
  } finally {
    await session.stop();
  }
}

if (import.meta.url === pathToFileURL(process.argv[1]).href) {
  const checks = new Checks();
  await linkChecks(checks);
  checks.finish();
}
