// Keyboard and focus of the page in Chromium, against the fake server. Part of client_test.mjs; run alone:
// node tests/browser/keys_test.mjs.

import { pathToFileURL } from 'node:url';
import { Session } from './fake_session.mjs';
import { Checks, expect, pause, typeNumber, until } from './page.mjs';

const DESKTOP = { width: 1440, height: 900 };

/** A key as the window hears of it, without the browser's own doing. */
const key = (page, type, code, more = {}) =>
  page.evaluate(
    ([name, at, rest]) =>
      window.dispatchEvent(new KeyboardEvent(name, { code: at, key: at, bubbles: true, cancelable: true, ...rest })),
    [type, code, more],
  );

const windowEvent = (page, name) => page.evaluate((type) => window.dispatchEvent(new Event(type)), name);

async function moves(session, during = async () => undefined) {
  const { position } = (await session.state()).camera;
  await during();
  const after = (await session.state()).camera.position;
  return Math.hypot(...after.map((value, i) => value - position[i])) > 0;
}

/** Nothing is held any more: the camera is where it was half a second ago. */
async function standsStill(session, what) {
  await pause(250);
  expect(!(await moves(session, () => pause(500))), `still moving: ${what}`);
}

const pressed = (page, name) => page.locator('.dock').getByRole('button', { name }).getAttribute('aria-pressed');

async function buttons(checks, session) {
  const { page } = session;
  await checks.check('after a click on a button the keys fly, and Space and Enter press nothing', async () => {
    const before = await pressed(page, 'Stats');
    await page.locator('.dock').getByRole('button', { name: 'Stats' }).click();
    const after = await pressed(page, 'Stats');
    expect(before !== after, 'the click did nothing');
    await page.keyboard.down('w');
    await page.keyboard.press('Space');
    expect((await pressed(page, 'Stats')) === after, 'Space pressed the button again');
    await page.keyboard.press('Enter');
    expect((await pressed(page, 'Stats')) === after, 'Enter pressed the button again');
    await page.keyboard.up('w');
    await page.locator('.dock').getByRole('button', { name: 'Stats' }).click();
  });
  await checks.check('while flying, Space and Enter do not press the button that has the focus', async () => {
    const button = page.locator('.dock').getByRole('button', { name: 'Stats' });
    const before = await pressed(page, 'Stats');
    await button.focus();
    await page.keyboard.down('w');
    await page.keyboard.press('Space');
    expect((await pressed(page, 'Stats')) === before, 'pressed by Space while flying');
    for (const key of ['Enter', 'NumpadEnter']) {
      await page.keyboard.press(key);
      expect((await pressed(page, 'Stats')) === before, `pressed by ${key} while flying`);
    }
    await page.keyboard.up('w');
    await page.keyboard.press('Space');
    expect((await pressed(page, 'Stats')) !== before, 'not pressed by Space alone');
    await page.keyboard.press('Enter');
    expect((await pressed(page, 'Stats')) === before, 'not pressed by Enter alone');
  });
  await checks.check('Enter in a number field sets the value, and W flies', async () => {
    await typeNumber(page, 'exposure', 1);
    await until('the echo', 5000, async () => (await session.state()).settings.exposure === 1);
    const flown = await moves(session, async () => {
      await page.keyboard.down('w');
      await pause(300);
      await page.keyboard.up('w');
    });
    expect(flown, 'W is dead');
  });
  await checks.check('a choice by mouse gives the keys back to the picture', async () => {
    const select = page.locator('#resolution-mode');
    await select.click();
    await select.selectOption('half');
    await page.keyboard.press('Escape'); // the list of a headless browser stays open
    const focused = await page.evaluate(() => document.activeElement.tagName);
    expect(focused === 'CANVAS', `${focused} has the focus`);
  });
}

async function lostKeys(checks, session) {
  const { page } = session;
  await checks.check('a key pressed when the window has lost the focus flies nowhere', async () => {
    await page.locator('body > canvas').click();
    await key(page, 'keydown', 'KeyW');
    await pause(150);
    await windowEvent(page, 'blur');
    await standsStill(session, 'W held, focus lost');
    await key(page, 'keydown', 'KeyW');
    await standsStill(session, 'W after the focus was lost');
    await windowEvent(page, 'focus');
    expect(await moves(session, () => key(page, 'keydown', 'KeyW').then(() => pause(300))), 'W is dead after the focus');
    await key(page, 'keyup', 'KeyW');
  });
  await checks.check('a keyup that Meta swallows leaves nothing held', async () => {
    await key(page, 'keydown', 'KeyW');
    await pause(150);
    await key(page, 'keydown', 'MetaLeft', { metaKey: true });
    await key(page, 'keyup', 'MetaLeft');
    await standsStill(session, 'W held, Meta pressed and let go');
    await key(page, 'keydown', 'MetaLeft', { metaKey: true });
    await key(page, 'keydown', 'KeyS', { metaKey: true });
    await key(page, 'keyup', 'MetaLeft');
    await standsStill(session, 'Meta, then S');
  });
}

async function frames(checks, session) {
  const { page } = session;
  const outline = () => page.locator('body > canvas').evaluate((canvas) => getComputedStyle(canvas).outlineStyle);
  await checks.check('the picture is framed when Tab reaches it, not when a drag does', async () => {
    await page.evaluate(() => document.activeElement?.blur?.());
    await page.mouse.move(720, 450);
    await page.mouse.down();
    await page.mouse.move(760, 460);
    await page.mouse.up();
    expect((await page.evaluate(() => document.activeElement.tagName)) === 'CANVAS', 'the drag did not focus it');
    await page.keyboard.press('w');
    expect((await outline()) === 'none', 'a frame after the drag');
    await page.keyboard.press('Tab');
    await page.keyboard.press('Shift+Tab');
    expect((await page.evaluate(() => document.activeElement.tagName)) === 'CANVAS', 'not reached by Shift and Tab');
    expect((await outline()) === 'solid', 'no frame by keyboard');
    await page.mouse.click(720, 450);
    expect((await outline()) === 'none', 'the frame stays after a click');
  });
}

async function pixelRatio(checks, session) {
  const { page } = session;
  await checks.check('another pixel ratio without a change of size asks for other pixels', async () => {
    await page.locator('#resolution-mode').selectOption('full');
    const devtools = await page.context().newCDPSession(page);
    await session.received('resolution');
    for (const ratio of [1.25, 2, 1]) {
      const size = { ...DESKTOP, deviceScaleFactor: ratio, mobile: false };
      await devtools.send('Emulation.setDeviceMetricsOverride', size);
      await until(`pixels for ratio ${ratio}`, 5000, async () =>
        (await session.received('resolution')).some(({ width }) => width === DESKTOP.width * ratio),
      );
    }
  });
}

/** Runs everything; failures and passes are counted in `checks`. */
export async function keyChecks(checks) {
  const session = new Session();
  try {
    if (!(await checks.check('the page is ready for keys', () => session.start(DESKTOP)))) return;
    await buttons(checks, session);
    await lostKeys(checks, session);
    await frames(checks, session);
    await pixelRatio(checks, session);
    await checks.check('nothing was wrong in the browser\u2019s console (keys)', async () => {
      expect(session.browser.problems.length === 0, session.browser.problems.join('\n'));
    });
  } finally {
    await session.stop();
  }
}

if (import.meta.url === pathToFileURL(process.argv[1]).href) {
  const checks = new Checks();
  await keyChecks(checks);
  checks.finish();
}
