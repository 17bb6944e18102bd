// Two pages at one real server: one drives a view, the other watches it by its address, and drives when the first has gone. Part of
// client_test.mjs; run alone: node tests/browser/watch_test.mjs. Writes screenshots to out/browser.

import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { badControls, overlaps } from './look.mjs';
import { Browser, Checks, expect, freePort, outFolder, pause, Server, until } from './page.mjs';

const SIZE = { width: 1100, height: 700 };
const BANNER = 'You watch a view of somebody else';
const ADMIN = 'the-secret-of-admins';

/** One page of a browser. */
class Tab {
  constructor(page) {
    this.page = page;
  }
  state = () => this.page.evaluate(() => window.heliograph.state);
  banner = () => this.page.locator('.banner:visible').getByText(BANNER);
  toast = (text) => this.page.locator('.toast').getByText(text).waitFor({ timeout: 20_000 });

  /** Waits until the last picture of the scene, which shows the newest input, is on the screen. */
  settled = () =>
    until('the last picture', 180_000, async () => {
      const { scene, lastFrame, lastInputId } = await this.state();
      return scene?.state === 'ready' && lastFrame?.inputId === lastInputId && lastFrame.exact;
    });

  async drag() {
    await this.page.mouse.move(440, 300);
    await this.page.mouse.down();
    for (let x = 440; x <= 560; x += 20) {
      await this.page.mouse.move(x, 310);
      await pause(20);
    }
    await this.page.mouse.up();
  }

  async set(name, value) {
    const input = this.page.locator(`[data-setting="${name}"]`).locator('.number-field');
    await input.fill(String(value));
    await input.press('Enter');
    await until(`the echo of ${name}`, 5000, async () => (await this.state()).settings[name] === value);
  }
}

/** The link that the page gives, wherever it puts it. */
async function linkOf({ page, toast, state }) {
  await page.evaluate(() => {
    navigator.clipboard.writeText = () => Promise.reject(new Error('not allowed here'));
  });
  await page.getByRole('button', { name: 'Save', exact: false }).first().click();
  await page.getByText('Link to this view').click();
  await toast((await state()).view);
  return /http\S+/.exec(await page.locator('.toast', { hasText: 'view=' }).textContent())[0];
}

async function watchesFrames(checks, address, driver, watcher) {
  await checks.check('a second page watches the first one\u2019s view', async () => {
    await driver.page.goto(address);
    await driver.page.evaluate(() => document.querySelectorAll('details').forEach((group) => (group.open = true)));
    await driver.settled();
    await driver.set('samples', 4);
    await driver.settled();
    const link = await linkOf(driver);
    expect(link === `${address}?view=${(await driver.state()).view}`, link);
    await watcher.page.goto(link);
    await watcher.settled();
    expect((await watcher.state()).watching && !(await driver.state()).watching, 'who watches?');
    await watcher.banner().waitFor({ timeout: 20_000 });
    expect((await driver.banner().count()) === 0, 'the driver is told that it watches');
    const [a, b] = [(await driver.state()).lastFrame, (await watcher.state()).lastFrame];
    expect(a.width === b.width && a.height === b.height, `${b.width} x ${b.height} instead of ${a.width} x ${a.height}`);
    expect((await watcher.state()).settings.samples === 4, 'the driver\u2019s settings are not told');
    await driver.page.locator('.dock').getByRole('button', { name: 'Stats' }).click(); // folded at first in so small a window
    await until('the number of watchers', 5000, () => driver.page.getByText('2 (1 watches this view)').count());
  });
  await checks.check('who watches sees what the driver does', async () => {
    const before = (await watcher.state()).framesPresented;
    await driver.drag();
    await driver.settled();
    await until('frames of the motion', 20_000, async () => (await watcher.state()).framesPresented > before + 1);
    await watcher.settled();
  });
}

async function drivesNothing(checks, driver, watcher) {
  await checks.check('who watches drives nothing, and is told so', async () => {
    const before = await driver.state();
    await watcher.drag();
    await watcher.page.keyboard.press('r');
    await watcher.toast('You watch a view of somebody else: camera and settings are theirs.');
    await pause(300);
    const after = await driver.state();
    expect(after.framesPresented === before.framesPresented, 'the driver\u2019s picture changed');
    expect((await watcher.page.locator('.toast.error').count()) === 0, 'the page sent what it may not');
    const controls = watcher.page.locator('[data-setting] input, [data-setting] select');
    const enabled = await controls.evaluateAll((all) =>
      all.filter((c) => !c.disabled).map((c) => c.closest('[data-setting]').dataset.setting),
    );
    expect(new Set(enabled).size === 1 && enabled[0] === 'jpegQuality', `enabled: ${enabled}`);
    await watcher.page.screenshot({ path: join(outFolder, 'watching.png') });
    const bad = [...(await badControls(watcher.page)), ...(await overlaps(watcher.page))];
    expect(bad.length === 0, bad.join('\n'));
  });
  await checks.check('its JPEG quality is its own', async () => {
    await watcher.page.evaluate(() => document.querySelectorAll('details').forEach((group) => (group.open = true)));
    await watcher.set('jpegQuality', 30);
    await watcher.settled();
    expect((await driver.state()).settings.jpegQuality === 80, 'the driver\u2019s changed too');
  });
}

async function comesAndGoes(checks, address, driver, watcher) {
  await checks.check('when the driver has gone, who watched drives', async () => {
    const camera = (await driver.state()).camera;
    await driver.page.close();
    await until('the watcher drives', 10_000, async () => !(await watcher.state()).watching);
    await watcher.toast('You drive it now.');
    expect((await watcher.banner().count()) === 0, 'it is still told that it watches');
    const near = (await watcher.state()).camera.forward.every((v, i) => Math.abs(v - camera.forward[i]) < 1e-5);
    expect(near, 'it does not look where the driver looked');
    const before = (await watcher.state()).lastInputId;
    await watcher.drag();
    await watcher.settled();
    expect((await watcher.state()).lastInputId > before, 'the drag did nothing');
  });
  await checks.check('a view that is not there is refused in words, and the page has its own', async () => {
    const late = new Tab(await watcher.page.context().newPage());
    await late.page.goto(`${address}?view=${'0'.repeat(32)}`);
    await late.toast('watch.view: no such view');
    await late.settled();
    expect(!(await late.state()).watching, 'it watches');
    await late.page.close();
    await watcher.page.bringToFront();
  });
  await checks.check('back to a view of one\u2019s own', async () => {
    const guest = new Tab(await watcher.page.context().newPage());
    // The watcher came by the driver's address; its own view is the one it drives now.
    await guest.page.goto(watcher.page.url());
    await guest.banner().waitFor({ timeout: 20_000 });
    await guest.page.getByRole('button', { name: 'View of my own' }).click();
    await until('a view of its own', 10_000, async () => !(await guest.state()).watching);
    await guest.settled();
    expect(!guest.page.url().includes('view='), guest.page.url());
    expect((await guest.banner().count()) === 0, 'it is still told that it watches');
    await guest.page.close();
  });
}

/** An admin closes the only connection left (4003): the page says so, and does not come again by itself. */
async function dismissed(checks, address, watcher) {
  await checks.check('who is disconnected by an admin is told, and stays away', async () => {
    const headers = { authorization: `Bearer ${ADMIN}` };
    const viewers = async () => (await (await fetch(`${address}admin/viewers`, { headers })).json()).viewers;
    await until('one viewer alone', 10_000, async () => (await viewers()).length === 1);
    const [{ viewer }] = await viewers();
    const { status } = await fetch(`${address}admin/viewers/${viewer}`, { method: 'DELETE', headers });
    expect(status === 200, `HTTP ${status}`);
    const banner = watcher.page.locator('.banner:visible');
    await banner.getByText('The operator of the server closed this connection.').waitFor({ timeout: 10_000 });
    await banner.getByText('Not connected').waitFor({ timeout: 1000 });
    await watcher.page.screenshot({ path: join(outFolder, 'dismissed.png') });
    await pause(6000); // longer than the longest wait between two attempts
    expect((await viewers()).length === 0, 'it came again');
    expect((await watcher.state()).connection === 'stopped', (await watcher.state()).connection);
  });
}

export async function watchChecks(checks) {
  const folder = mkdtempSync(join(tmpdir(), 'heliograph-admin-'));
  const tokenFile = join(folder, 'token');
  writeFileSync(tokenFile, `${ADMIN}\n`);
  const server = new Server(await freePort(), 'cornell', undefined, { HELIOGRAPH_ADMIN_TOKEN_FILE: tokenFile });
  // A browser each: what is not in front draws nothing.
  const browsers = [new Browser(), new Browser()];
  try {
    if (!(await checks.check('the server starts (watching)', () => server.start()))) return;
    const address = `http://127.0.0.1:${server.port}/`;
    const [driver, watcher] = [new Tab(await browsers[0].start(SIZE)), new Tab(await browsers[1].start(SIZE))];
    await watchesFrames(checks, address, driver, watcher);
    await drivesNothing(checks, driver, watcher);
    await comesAndGoes(checks, address, driver, watcher);
    await dismissed(checks, address, watcher);
    await checks.check('nothing was wrong in the browser\u2019s console (watching)', async () => {
      const problems = browsers.flatMap((browser) => browser.problems);
      expect(problems.length === 0, problems.join('\n'));
    });
  } finally {
    for (const browser of browsers) await browser.stop();
    await server.kill();
    rmSync(folder, { recursive: true, force: true });
  }
}

if (import.meta.url === pathToFileURL(process.argv[1]).href) {
  const checks = new Checks();
  await watchChecks(checks);
  checks.finish();
}
