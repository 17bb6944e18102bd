// The page in Chromium against a real server: what a visitor does, from the first picture to a server that dies and
// comes back. HELIOGRAPH_BINARY names the server (default build/release/heliograph), HELIOGRAPH_CHROMIUM the browser.
// Then the same in short in Firefox (firefox_test.mjs), the stream (stream_test.mjs), two pages at one view (watch_test.mjs), and what a real server seldom does, against the fake one (fake_test.mjs). Writes screenshots to out/browser.

import { readFile } from 'node:fs/promises';
import { join } from 'node:path';
import { accuracyChecks } from './accuracy_test.mjs';
import { effectChecks } from './effects_test.mjs';
import { fakeChecks } from './fake_test.mjs';
import { doorChecks } from './door_test.mjs';
import { firefoxChecks } from './firefox_test.mjs';
import { keyChecks } from './keys_test.mjs';
import { lightChecks } from './light_test.mjs';
import { linkChecks } from './link_test.mjs';
import { poolChecks } from './pool_test.mjs';
import { panelChecks } from './panels_test.mjs';
import { pickChecks } from './pick_test.mjs';
import { badControls, difference, overlaps, picture, pngSize } from './look.mjs';
import { Browser, Checks, expect, freePort, outFolder, pause, Server, typeNumber, until } from './page.mjs';
import { steeringChecks } from './steering_test.mjs';
import { streamChecks } from './stream_test.mjs';
import { resumeChecks } from './resume_test.mjs';
import { uploadChecks } from './upload_test.mjs';
import { viewsChecks } from './views_test.mjs';
import { watchChecks } from './watch_test.mjs';

const DESKTOP = { width: 1440, height: 900 };
const PHONE = { width: 390, height: 844 };
const SMALL_PHONE = { width: 360, height: 640 };
const SCENE = 'cornell';
const OTHER_SCENE = 'courtyard';

const checks = new Checks();
const server = new Server(await freePort(), SCENE);
const address = `http://127.0.0.1:${server.port}/`;
let browser = new Browser();
let page;

const state = () => page.evaluate(() => window.heliograph.state);
const screenshot = (name) => page.screenshot({ path: join(outFolder, `${name}.png`) });
const field = (name) => page.locator(`[data-setting="${name}"]`);

/** Waits until the picture shows the newest input. */
const settled = (ms = 30_000) =>
  until('a picture of the last input', ms, async () => {
    const { lastFrame, lastInputId } = await state();
    return lastFrame !== null && lastFrame.inputId === lastInputId;
  });

async function open(viewport, options) {
  browser = new Browser();
  page = await browser.start(viewport, options);
  const response = await page.goto(address);
  expect(response.status() === 200, `status ${response.status()}`);
}

async function sceneShown(name) {
  await until(`scene ${name}`, 60_000, async () => {
    const { scene } = await state();
    return scene?.name === name && scene.state === 'ready';
  });
  await settled(60_000);
}

async function drag(from, to, steps = 8) {
  await page.mouse.move(...from);
  await page.mouse.down();
  for (let i = 1; i <= steps; i += 1) {
    await page.mouse.move(from[0] + ((to[0] - from[0]) * i) / steps, from[1] + ((to[1] - from[1]) * i) / steps);
    await pause(16);
  }
  await page.mouse.up();
}

const setNumber = (name, value) => typeNumber(page, name, value);

function noProblems() {
  expect(browser.problems.length === 0, browser.problems.join('\n'));
}

const pageLoads = () =>
  checks.check('the page loads and shows a picture', async () => {
    await open(DESKTOP);
    await sceneShown(SCENE);
    const shown = await picture(page);
    expect(shown.spread > 5, `the canvas is uniform: mean ${shown.mean}, spread ${shown.spread}`);
    await until("a canvas of the frame's size", 10_000, async () => {
      const [{ width, height }, { lastFrame }] = [await picture(page), await state()];
      return width === lastFrame.width && height === lastFrame.height;
    });
    const box = await page.locator('body > canvas').boundingBox();
    expect(
      box.width === DESKTOP.width && box.height === DESKTOP.height,
      `the canvas does not fill the window: ${JSON.stringify(box)}`,
    );
  });

async function pictureChecks() {
  await checks.check('samples add up while the camera rests', async () => {
    await until('more than one sample', 30_000, async () => (await state()).lastFrame.samples > 1);
  });
  await checks.check('dragging changes the picture, and the last input comes back', async () => {
    const before = await picture(page);
    const { lastInputId } = await state();
    await drag([720, 400], [900, 440]);
    await settled();
    const after = await state();
    expect(after.lastInputId > lastInputId, 'no input was sent');
    const changed = difference(before, await picture(page));
    expect(changed > 2, `mean difference ${changed}`);
    expect(after.motionToPhotonMs.median > 0, 'motion to photon was not measured');
  });
  await checks.check('W moves while it is held, and rests afterwards', async () => {
    const before = await state();
    await page.keyboard.down('w');
    await pause(400);
    await page.keyboard.up('w');
    await settled();
    const after = await state();
    const moved = Math.hypot(...after.camera.position.map((value, i) => value - before.camera.position[i]));
    expect(moved > 0, 'the camera did not move');
    await pause(300);
    expect((await state()).lastInputId === after.lastInputId, 'input goes on after the key was let go');
  });
  await checks.check('R brings the first view back', async () => {
    await page.keyboard.press('r');
    await settled();
  });
}

async function settingChecks() {
  await checks.check('a setting changes in the panel, the server confirms it, the picture follows', async () => {
    const before = await picture(page);
    await setNumber('exposure', 1.5);
    await until('the echo', 10_000, async () => (await state()).settings.exposure === 1.5);
    await settled();
    const after = await picture(page);
    expect(after.mean > before.mean + 5, `mean ${before.mean} before, ${after.mean} after +1.5 stops`);
  });
  await checks.check('a refused value shows the server\u2019s words and falls back', async () => {
    await setNumber('maxReflections', 999);
    const error = field('maxReflections').locator('.field-error');
    await error.waitFor({ state: 'visible', timeout: 10_000 });
    const text = await error.textContent();
    expect(text.includes('maxReflections') && text.includes('999') && text.includes('31'), `message: ${text}`);
    const { settings } = await state();
    const shown = await field('maxReflections').locator('.number-field').inputValue();
    expect(Number(shown) === settings.maxReflections, `shown ${shown}, server ${settings.maxReflections}`);
    await error.scrollIntoViewIfNeeded();
    await screenshot('refused');
  });
  await checks.check('every device that is offered makes the picture', async () => {
    const group = page.locator('summary', { hasText: 'Renderer' });
    const select = field('device').locator('select');
    await group.click();
    const offered = await select.locator('option').allTextContents();
    expect(offered.includes('embree'), `offered: ${offered.join(' ')}`);
    const before = await picture(page);
    for (const device of [...offered.filter((name) => name.includes(':') || name === 'raster'), 'embree', 'auto']) {
      await select.selectOption(device);
      await until(`a picture by ${device}`, 60_000, async () => {
        const { lastFrame, lastInputId, settings } = await state();
        const made =
          device === 'auto' ? lastFrame.devices.length === 1 : lastFrame.devices.join() === device.split(':')[0];
        return settings.device === device && lastFrame.inputId === lastInputId && made;
      });
      if (device === 'raster') await screenshot('raster');
      else expect(difference(before, await picture(page)) < 6, `the picture by ${device} is another one`);
    }
    await group.click();
  });
  await checks.check('a switch works by keyboard', async () => {
    const { settings } = await state();
    await field('shadows').locator('input').focus();
    await page.keyboard.press('Space');
    await until('the echo', 10_000, async () => (await state()).settings.shadows === !settings.shadows);
    await settled();
  });
  await checks.check('reset brings the defaults back and clears the error', async () => {
    await page.getByRole('button', { name: 'Reset to defaults' }).click();
    await until('the echo', 10_000, async () => {
      const { settings } = await state();
      return settings.exposure === 0 && settings.shadows === true;
    });
    expect(await field('maxReflections').locator('.field-error').isHidden(), 'the error is still shown');
    await page.locator('.dock').getByRole('button', { name: 'Effects' }).click(); // as it was at first
    await settled();
  });
}

async function pageChecks() {
  await checks.check('F3 saves a PNG of the full-resolution film', async () => {
    const download = page.waitForEvent('download', { timeout: 60_000 });
    await page.keyboard.press('F3');
    const file = await download;
    const size = pngSize(await readFile(await file.path()));
    const { width, height } = DESKTOP;
    expect(
      size.width === width && size.height === height,
      `${size.width} x ${size.height}, allowed: ${width} x ${height}`,
    );
    expect(file.suggestedFilename().endsWith('.png'), file.suggestedFilename());
  });
  await checks.check('the menu saves an EXR', async () => {
    const download = page.waitForEvent('download', { timeout: 60_000 });
    await page.locator('.dock').getByRole('button', { name: 'Save' }).click();
    await page.getByRole('menuitem', { name: 'EXR' }).click();
    const bytes = await readFile(await (await download).path());
    expect(bytes.readUInt32LE(0) === 20000630, 'no OpenEXR magic number');
  });
  await checks.check('F1 hides the panels and shows them again', async () => {
    await page.keyboard.press('F1');
    expect(await page.locator('#settings-panel').isHidden(), 'the settings are still shown');
    await screenshot('bare');
    await page.keyboard.press('F1');
    expect(await page.locator('#settings-panel').isVisible(), 'the settings did not come back');
  });
  await checks.check('H opens the help, Escape closes it', async () => {
    await page.keyboard.press('h');
    expect(await page.locator('dialog.help').isVisible(), 'no help');
    await screenshot('help');
    await page.keyboard.press('Escape');
    expect(await page.locator('dialog.help').isHidden(), 'the help stays');
  });
  await checks.check('every control is reached by Tab, in a visible focus', async () => {
    const effects = page.locator('.dock').getByRole('button', { name: 'Effects' });
    await effects.click();
    await page.evaluate(() => document.activeElement?.blur?.());
    const reached = new Set();
    const most = 20 + (await page.locator('a[href], button, input, select, summary, textarea, [tabindex]').count());
    for (let i = 0; i < most; i += 1) {
      await page.keyboard.press('Tab');
      reached.add(
        await page.evaluate(() => {
          const element = document.activeElement;
          if (element === null || element === document.body) return '';
          const outline = getComputedStyle(element).outlineStyle;
          const name = element.getAttribute('aria-label') ?? element.labels?.[0]?.textContent ?? element.textContent;
          return `${outline === 'none' ? 'INVISIBLE ' : ''}${name?.trim()}`;
        }),
      );
    }
    const invisible = [...reached].filter((name) => name.startsWith('INVISIBLE'));
    expect(invisible.length === 0, invisible.join(', '));
    const some = ['Viewpoint', 'About the scene', 'Exposure', 'Shadows', 'setting of Reflections', 'Save', 'Help', 'Reset to defaults'];
    for (const name of some) {
      expect(
        [...reached].some((entry) => entry.includes(name)),
        `${name} is not reached; reached: ${[...reached].join(' | ')}`,
      );
    }
    await effects.click();
  });
  await checks.check('controls are named and nothing overlaps (desktop)', async () => {
    const bad = [...(await badControls(page)), ...(await overlaps(page))];
    expect(bad.length === 0, bad.join('\n'));
  });
  await checks.check('folded panels stay folded', async () => {
    await page.locator('#statistics-panel .panel-head').click();
    await page.reload();
    await sceneShown(SCENE);
    expect(await page.locator('#statistics-panel .panel-body').isHidden(), 'the statistics opened again');
    await page.locator('#statistics-panel .panel-head').click();
  });
}

async function sceneChecks() {
  await checks.check('another scene opens without a new connection', async () => {
    const before = await picture(page);
    await page.locator('.picker').click();
    await page.getByRole('menuitemradio', { name: new RegExp(`^${OTHER_SCENE}`, 'i') }).click();
    await sceneShown(OTHER_SCENE);
    const changed = difference(before, await picture(page));
    expect(changed > 2, `mean difference ${changed}`);
    expect((await state()).connected, 'not connected');
    await until(
      'some samples',
      30_000,
      async () => (await state()).lastFrame.samples >= 8 || (await state()).lastFrame.final,
    );
    await pause(600);
    await screenshot('desktop');
  });
  await checks.check('the picture follows the window\u2019s size', async () => {
    await page.setViewportSize({ width: 1000, height: 700 });
    await until('a picture of the new shape', 30_000, async () => {
      const { lastFrame } = await state();
      return Math.abs(lastFrame.width / lastFrame.height - 1000 / 700) < 0.02;
    });
    await page.setViewportSize(DESKTOP);
    await settled();
  });
  await checks.check('the benchmark path plays, moves the picture and stops', async () => {
    await page.keyboard.press('F2');
    await until('the path', 10_000, async () => (await state()).pathPlaying);
    const before = await picture(page);
    await until('another picture', 30_000, async () => difference(before, await picture(page)) > 1);
    await page.keyboard.press('F2');
    await until('the end of the path', 10_000, async () => !(await state()).pathPlaying);
    await settled();
  });
}

async function reconnectChecks() {
  await checks.check(
    'a server that dies is said so, and the page comes back with scene, camera and settings',
    async () => {
      await setNumber('exposure', 0.5);
      await until('the echo', 10_000, async () => (await state()).settings.exposure === 0.5);
      await drag([720, 400], [640, 380]);
      await settled();
      const whole = async () => (await state()).lastFrame.width === DESKTOP.width;
      await until('a picture at full size', 60_000, whole);
      const before = await state();
      const shown = await picture(page);
      noProblems();
      browser.expectDisconnect = true;
      await server.kill();
      await page
        .locator('.banner')
        .getByText(/Connection lost/)
        .waitFor({ timeout: 20_000 });
      await screenshot('disconnected');
      await server.start();
      await until('the connection', 20_000, async () => (await state()).connected);
      await until('a frame after the reconnect', 60_000, async () => {
        const { framesPresented } = await state();
        return framesPresented > before.framesPresented;
      });
      const first = await state();
      expect(first.scene?.name === OTHER_SCENE, `the first frame shows ${first.scene?.name}`);
      await sceneShown(OTHER_SCENE);
      await until('a picture at full size again', 60_000, whole);
      expect(difference(shown, await picture(page)) < 6, 'the picture is another one than before');
      browser.expectDisconnect = false;
      const after = await state();
      expect(after.settings.exposure === 0.5, `exposure ${after.settings.exposure}`);
      expect(JSON.stringify(after.camera) === JSON.stringify(before.camera), 'the camera was not restored');
      expect(await page.locator('.banner').isHidden(), 'the banner stays');
    },
  );
  await checks.check('nothing was wrong in the browser\u2019s console (desktop)', noProblems);
}

async function phoneChecks(name, viewport) {
  await checks.check(`${name}: loads, a finger turns the view, panels are sheets`, async () => {
    await open(viewport, { hasTouch: true, isMobile: true, deviceScaleFactor: 2 });
    await sceneShown(SCENE);
    const before = await state();
    await page.locator('body > canvas').evaluate((canvas) => {
      const fire = (type, x) =>
        canvas.dispatchEvent(
          new PointerEvent(type, {
            pointerId: 1,
            pointerType: 'touch',
            clientX: x,
            clientY: 300,
            isPrimary: true,
            bubbles: true,
          }),
        );
      canvas.setPointerCapture = () => undefined; // synthetic pointers cannot be captured
      fire('pointerdown', 100);
      for (let x = 100; x <= 180; x += 10) fire('pointermove', x);
      fire('pointerup', 180);
    });
    await settled();
    expect(
      JSON.stringify((await state()).camera.forward) !== JSON.stringify(before.camera.forward),
      'the view did not turn',
    );
    await page
      .locator('.toast .ghost')
      .first()
      .click({ timeout: 500 })
      .catch(() => undefined);
    await screenshot(name);
    for (const label of ['Stats', 'Light', 'Settings']) {
      await page.locator('.dock').getByRole('button', { name: label }).tap();
      await pause(400);
      const bad = [...(await badControls(page)), ...(await overlaps(page))];
      expect(bad.length === 0, bad.join('\n'));
      await screenshot(`${name}-${label.toLowerCase()}`);
    }
    const sheets = await page.locator('.panel:visible').count();
    expect(sheets === 1, `${sheets} sheets are open, allowed: 1`);
    noProblems();
  });
  await browser.stop();
}

try {
  const started = await checks.check('the server starts', () => server.start());
  // Without a picture nothing else can be looked at.
  if (started && (await pageLoads())) {
    await pictureChecks();
    await settingChecks();
    await pageChecks();
    await sceneChecks();
    await reconnectChecks();
    await browser.stop();
    await phoneChecks('phone', PHONE);
    await phoneChecks('small-phone', SMALL_PHONE);
  }
} finally {
  await browser.stop();
  await server.kill();
  await firefoxChecks(checks);
  await streamChecks(checks);
  await watchChecks(checks);
  await resumeChecks(checks);
  await fakeChecks(checks);
  await effectChecks(checks);
  await accuracyChecks(checks);
  await keyChecks(checks);
  await doorChecks(checks);
  await panelChecks(checks);
  await lightChecks(checks);
  await steeringChecks(checks);
  await pickChecks(checks);
  await linkChecks(checks);
  await viewsChecks(checks);
  await uploadChecks(checks);
  await poolChecks(checks);
  checks.finish();
}
