// Gamepad, the mouse without a button, and the stick for a thumb, against the fake server. Part of client_test.mjs; run
// alone: node tests/browser/steering_test.mjs.

import { pathToFileURL } from 'node:url';
import { Session } from './fake_session.mjs';
import { badControls, overlaps } from './look.mjs';
import { Checks, expect, pause, until } from './page.mjs';

const DESKTOP = { width: 1440, height: 900 };
const PHONE = { width: 390, height: 844 };

const camera = async (session) => (await session.state()).camera;
const far = (a, b) => Math.hypot(...a.map((value, i) => value - b[i]));

/** How far the camera comes in this time. */
async function way(session, ms) {
  const before = (await camera(session)).position;
  await pause(ms);
  return far((await camera(session)).position, before);
}

async function stands(session, what) {
  await pause(250);
  expect((await way(session, 300)) === 0, `still moving: ${what}`);
}

/** A gamepad that the test holds. */
const plug = (page) =>
  page.evaluate(() => {
    const button = () => ({ pressed: false, touched: false, value: 0 });
    window.pad = { connected: true, index: 0, axes: [0, 0, 0, 0], buttons: Array.from({ length: 17 }, button) };
    navigator.getGamepads = () => [null, window.pad];
    document.hasFocus = () => window.focused ?? true;
    window.dispatchEvent(new Event('gamepadconnected'));
  });
const sticks = (page, axes) => page.evaluate((values) => void (window.pad.axes = values), axes);
const button = (page, index, pressed) =>
  page.evaluate(([at, down]) => void Object.assign(window.pad.buttons[at], { pressed: down, value: Number(down) }), [index, pressed]);

async function gamepad(checks, session) {
  const { page } = session;
  await checks.check('gamepad: the left stick flies, the right one looks, and let go nothing moves', async () => {
    await plug(page);
    await stands(session, 'sticks at rest');
    await sticks(page, [0, -1, 0, 0]);
    const before = await camera(session);
    await until('a flight', 5000, async () => far((await camera(session)).position, before.position) > 0.2);
    const { position } = await camera(session);
    const ahead = position.reduce((sum, value, i) => sum + (value - before.position[i]) * before.forward[i], 0);
    expect(Math.abs(ahead - far(position, before.position)) < 1e-3, 'not straight ahead');
    await sticks(page, [0, 0, 1, 0]);
    await until('a turn', 5000, async () => far((await camera(session)).forward, before.forward) > 0.1);
    await sticks(page, [0.1, 0, 0, -0.1]);
    await stands(session, 'within the dead zone');
    await until('a picture at rest', 5000, async () => (await session.state()).lastFrame.samples > 1);
  });
  await checks.check('gamepad: its buttons reset the view and change the mode, once for each press', async () => {
    await button(page, 3, true);
    await until('the first view', 5000, async () => far((await camera(session)).position, [0.6, 2.2, 7.5]) < 1e-3);
    await button(page, 3, false);
    const mode = () => page.locator('.dock .tool').first().getAttribute('aria-label');
    expect((await mode()) === 'Navigation: fly', await mode());
    await button(page, 1, true);
    await pause(300); // held
    expect((await mode()) === 'Navigation: orbit', await mode());
    await button(page, 1, false);
    await pause(100);
    await button(page, 1, true);
    await until('flying', 5000, async () => (await mode()) === 'Navigation: fly');
    await button(page, 1, false);
  });
  await checks.check('gamepad: a window without the focus hears nothing of it, nor of one that is unplugged', async () => {
    await sticks(page, [1, 0, 0, 0]);
    await page.evaluate(() => void (window.focused = false));
    await stands(session, 'without the focus');
    await page.evaluate(() => void (window.focused = true));
    expect((await way(session, 500)) > 0, 'the stick is dead');
    await page.evaluate(() => void (window.pad.connected = false));
    await stands(session, 'unplugged');
  });
}

async function mouse(checks, session) {
  const { page } = session;
  const locked = () => page.evaluate(() => document.pointerLockElement !== null);
  await checks.check('L gives the mouse to the picture: it looks without a button, and L gives it back', async () => {
    await page.mouse.click(700, 450); // a headless window is none to lock to before it was pressed
    await page.keyboard.press('KeyL');
    await until('the mouse', 5000, locked);
    const before = await camera(session);
    await page.mouse.move(760, 450, { steps: 4 });
    await until('a turn', 5000, async () => far((await camera(session)).forward, before.forward) > 0.02);
    await page.mouse.down();
    await page.mouse.up();
    await page.keyboard.press('KeyL');
    await until('it back', 5000, async () => !(await locked()));
    const after = await camera(session);
    await page.mouse.move(500, 300, { steps: 4 });
    await pause(200);
    expect(far((await camera(session)).forward, after.forward) === 0, 'it still looks');
  });
  await checks.check('where the browser refuses, it is said', async () => {
    await page.evaluate(() => {
      HTMLCanvasElement.prototype.requestPointerLock = () => void document.dispatchEvent(new Event('pointerlockerror'));
    });
    await page.keyboard.press('KeyL');
    await page.locator('.toast', { hasText: 'does not give the mouse' }).waitFor({ timeout: 20_000 });
  });
}

async function thumb(checks) {
  const session = new Session();
  try {
    await checks.check('phone: a thumb on the stick flies while it is there', async () => {
      await session.start(PHONE, { hasTouch: true, isMobile: true, deviceScaleFactor: 2 });
      const { page } = session;
      const stick = page.locator('.thumb-stick');
      const box = await stick.boundingBox();
      const fire = (type, dx, dy) =>
        stick.evaluate(
          (element, [name, clientX, clientY]) => {
            element.setPointerCapture = () => undefined; // synthetic pointers cannot be captured
            const pointer = { pointerId: 1, pointerType: 'touch', isPrimary: true, bubbles: true };
            element.dispatchEvent(new PointerEvent(name, { ...pointer, clientX, clientY }));
          },
          [type, box.x + box.width / 2 + dx, box.y + box.height / 2 + dy],
        );
      const before = await camera(session);
      await fire('pointerdown', 0, -20);
      await fire('pointermove', 0, -200); // past its edge: no faster than all the way
      await until('a flight', 5000, async () => far((await camera(session)).position, before.position) > 0.1);
      await session.screenshot('phone-thumb-stick');
      await fire('pointerup', 0, -200);
      await stands(session, 'the thumb is gone');
      const bad = [...(await badControls(page)), ...(await overlaps(page))];
      expect(bad.length === 0, bad.join('\n'));
    });
    await checks.check('phone: an open sheet covers the stick', async () => {
      const { page } = session;
      const box = await page.locator('.thumb-stick').boundingBox();
      await page.locator('.dock').getByRole('button', { name: 'Light' }).tap();
      await pause(300);
      const at = [box.x + box.width / 2, box.y + box.height / 2];
      const covered = await page.evaluate(([x, y]) => document.elementFromPoint(x, y)?.closest('.panel') !== null, at);
      expect(covered, 'the stick lies on the sheet');
    });
    await checks.check('phone: the help begins with what fingers do', async () => {
      const title = await session.page.locator('dialog.help h3').first().textContent();
      expect(title === 'Touch', title);
    });
  } finally {
    await session.stop();
  }
}

/** Runs everything; failures and passes are counted in `checks`. */
export async function steeringChecks(checks) {
  const session = new Session();
  try {
    if (!(await checks.check('the page is ready for steering', () => session.start(DESKTOP)))) return;
    await checks.check('with a mouse there is no stick', async () => {
      expect(await session.page.locator('.thumb-stick').isHidden(), 'it is shown');
    });
    await gamepad(checks, session);
    await mouse(checks, session);
    await checks.check('nothing was wrong in the browser\u2019s console (steering)', async () => {
      expect(session.browser.problems.length === 0, session.browser.problems.join('\n'));
    });
  } finally {
    await session.stop();
  }
  await thumb(checks);
}

if (import.meta.url === pathToFileURL(process.argv[1]).href) {
  const checks = new Checks();
  await steeringChecks(checks);
  checks.finish();
}
