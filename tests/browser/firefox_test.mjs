// The page in Firefox against a real server, by WebDriver BiDi: what a visitor does, in short. Left out where no Firefox is
// installed (on PATH, or HELIOGRAPH_FIREFOX). Part of client_test.mjs; run alone: node tests/browser/firefox_test.mjs.

import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { badControls, compared, difference, overlaps, picture } from './look.mjs';
import { Browser, Checks, expect, firefoxPath, freePort, outFolder, Server, typeNumber, until } from './page.mjs';

const DESKTOP = { width: 1280, height: 720 };
const SCENE = 'cornell';

const stateOf = (page) => page.evaluate(() => window.heliograph.state);

/** Waits until the scene is shown by a picture of the newest input that fulfils `more`. */
const shown = (page, what, more = () => true) =>
  until(what, 60_000, async () => {
    const state = await stateOf(page);
    const { scene, lastFrame, lastInputId } = state;
    return scene?.name === SCENE && scene.state === 'ready' && lastFrame?.inputId === lastInputId && more(state);
  });

const exact = (page) => shown(page, 'an exact picture', ({ lastFrame }) => lastFrame.exact);
const away = (a, b) => Math.hypot(...a.map((value, i) => value - b[i]));

/** The picture that F3 saves, caught in the page: Playwright does not tell of what a link downloads in Firefox. */
async function savedPicture(page) {
  await page.evaluate(() => {
    const make = URL.createObjectURL;
    window.saved = new Promise((done) => {
      URL.createObjectURL = (file) => {
        URL.createObjectURL = make;
        done(file);
        return make.call(URL, file);
      };
    });
  });
  await page.keyboard.press('F3');
  const bytes = await page.evaluate(async () => [...new Uint8Array(await (await window.saved).arrayBuffer())]);
  return Buffer.from(bytes);
}

async function looking(checks, page, address) {
  const opened = await checks.check('Firefox: the page shows a picture', async () => {
    const response = await page.goto(address);
    expect(response.status() === 200, `status ${response.status()}`);
    await shown(page, 'a picture');
    const { spread, width, height } = await picture(page);
    expect(spread > 5, `the canvas is uniform: spread ${spread}`);
    expect(width > 600 && height > 300, `${width} x ${height} pixels`);
    const agent = await page.evaluate(() => navigator.userAgent);
    expect(agent.includes('Firefox/'), agent);
  });
  if (!opened) return false;
  await checks.check('Firefox: a still is the server\u2019s picture, byte for byte', async () => {
    await exact(page);
    const { different, pixels, same } = await compared(page, await savedPicture(page));
    expect(same && pixels > 100_000, `${pixels} pixels`);
    expect(different === 0, `${different} of ${pixels} pixels differ`);
  });
  await checks.check('Firefox: a drag turns the camera, and the picture follows', async () => {
    const [before, { camera, lastInputId }] = [await picture(page), await stateOf(page)];
    await page.mouse.move(640, 360);
    await page.mouse.down();
    for (let i = 1; i <= 12; i += 1) await page.mouse.move(640 + 15 * i, 360 + 3 * i);
    await page.mouse.up();
    await exact(page);
    const after = await stateOf(page);
    expect(after.lastInputId > lastInputId, 'no input was sent');
    expect(away(after.camera.forward, camera.forward) > 0.05, `looks to ${after.camera.forward}`);
    expect(difference(before, await picture(page)) > 2, 'the picture stays');
  });
  await checks.check('Firefox: W flies while it is held', async () => {
    const { camera } = await stateOf(page);
    await page.keyboard.down('w');
    await until('a flight', 10_000, async () => away((await stateOf(page)).camera.position, camera.position) > 0);
    await page.keyboard.up('w');
    await exact(page);
  });
  return true;
}

async function panels(checks, page) {
  await checks.check('Firefox: a setting changes, the server confirms it, the picture follows', async () => {
    const before = await picture(page);
    await typeNumber(page, 'exposure', '1,5');
    await until('the echo', 10_000, async () => (await stateOf(page)).settings.exposure === 1.5);
    await exact(page);
    const after = await picture(page);
    expect(after.mean > before.mean + 5, `mean ${before.mean} before, ${after.mean} after +1.5 stops`);
  });
  await checks.check('Firefox: panels open, controls are named, inside and not covered, and flying presses none', async () => {
    const dock = (label) => page.locator('.dock').getByRole('button', { name: label });
    await dock('Effects').click();
    const input = page.locator('#effects-panel [data-setting="shadows"] input');
    await input.focus();
    await page.keyboard.press('Space');
    await until('the echo', 10_000, async () => (await stateOf(page)).settings.shadows === false);
    await page.screenshot({ path: join(outFolder, 'firefox.png'), caret: 'initial' }); // hiding it takes a style that the page forbids
    const bad = [...(await badControls(page)), ...(await overlaps(page))];
    expect(bad.length === 0, bad.join('\n'));
    await page.keyboard.press('Escape');
    expect((await page.evaluate(() => document.activeElement.tagName)) === 'CANVAS', 'Escape does not lead to the picture');
    await dock('Stats').focus();
    const pressed = () => dock('Stats').getAttribute('aria-pressed');
    const before = await pressed();
    await page.keyboard.down('w');
    for (const key of ['Space', 'Enter']) {
      await page.keyboard.press(key);
      expect((await pressed()) === before, `pressed by ${key} while flying`);
    }
    await page.keyboard.up('w');
    await page.keyboard.press('Enter');
    expect((await pressed()) !== before, 'Enter alone does not press');
    await page.locator('body > canvas').focus();
    await page.keyboard.press('h');
    expect(await page.locator('dialog.help').isVisible(), 'no help');
    await page.keyboard.press('h');
    expect(await page.locator('dialog.help').isHidden(), 'the help stays');
  });
}

async function reloading(checks, page) {
  await checks.check('Firefox: a reload keeps the view', async () => {
    const before = await stateOf(page);
    await until('the address', 10_000, () => page.url().includes('set.exposure=1.5') && page.url().includes('set.shadows'));
    const picturedBefore = await picture(page);
    await page.reload();
    await exact(page);
    const { camera, settings } = await stateOf(page);
    expect(away(camera.position, before.camera.position) < 1e-4, `at ${camera.position}, before at ${before.camera.position}`);
    expect(away(camera.forward, before.camera.forward) < 1e-4, `looks to ${camera.forward}`);
    expect(settings.exposure === 1.5 && settings.shadows === false, `exposure ${settings.exposure}, shadows ${settings.shadows}`);
    const changed = difference(picturedBefore, await picture(page));
    expect(changed < 1, `mean difference ${changed}`);
  });
}

/** Runs everything; failures and passes are counted in `checks`. */
export async function firefoxChecks(checks) {
  if (firefoxPath() === undefined) {
    console.log('left out: Firefox is not installed (neither firefox nor firefox-esr is on PATH)');
    return;
  }
  const server = new Server(await freePort(), SCENE);
  const browser = new Browser('firefox');
  try {
    if (!(await checks.check('Firefox: the server starts', () => server.start()))) return;
    let page;
    if (!(await checks.check('Firefox: it starts', async () => void (page = await browser.start(DESKTOP))))) return;
    if (!(await looking(checks, page, `http://127.0.0.1:${server.port}/#set.samples=8`))) return;
    await panels(checks, page);
    await reloading(checks, page);
    await checks.check('Firefox: nothing was wrong in its console', async () => {
      expect(browser.problems.length === 0, browser.problems.join('\n'));
    });
  } finally {
    await browser.stop();
    await server.kill();
  }
}

if (import.meta.url === pathToFileURL(process.argv[1]).href) {
  const checks = new Checks();
  await firefoxChecks(checks);
  checks.finish();
}
