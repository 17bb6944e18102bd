// Pages at one real server that lose their line and come back, and that hand the driving of a view to each other. Part of
// client_test.mjs; run alone: node tests/browser/resume_test.mjs. Writes screenshots to out/browser.

import { connect, createServer } from 'node:net';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { badControls, overlaps } from './look.mjs';
import { Browser, Checks, expect, freePort, outFolder, pause, Server, typeNumber, until } from './page.mjs';

const SIZE = { width: 1100, height: 700 };
const WATCHING = 'You watch a view of somebody else';

/** A relay to the server that can be cut. */
class Cable {
  lines = new Set();
  up = true;

  async open(port) {
    this.relay = createServer((page) => {
      if (!this.up) return void page.destroy();
      const server = connect({ port, host: '127.0.0.1' });
      const line = { page, server };
      this.lines.add(line);
      for (const [one, other] of [[page, server], [server, page]]) {
        one.on('data', (bytes) => other.destroyed || other.write(bytes));
        one.on('error', () => undefined);
        one.on('close', () => line.unnoticed || other.destroy());
      }
    });
    await new Promise((done) => this.relay.listen(0, '127.0.0.1', done));
    this.port = this.relay.address().port;
  }

  /** `unnoticed`: the server goes on believing in its connections. */
  cut(unnoticed = false) {
    this.up = false;
    for (const line of this.lines) {
      line.unnoticed = unnoticed;
      line.page.destroy();
      if (!unnoticed) this.lines.delete(line);
    }
  }

  mend() {
    this.up = true;
  }

  close() {
    this.relay?.close();
    for (const { page, server } of this.lines) for (const end of [page, server]) end.destroy();
  }
}

class Tab {
  constructor(page) {
    this.page = page;
  }
  state = () => this.page.evaluate(() => window.heliograph.state);
  banner = (text) => this.page.locator('.banner:visible').getByText(text);
  press = (name) => this.page.locator('.banner:visible').getByRole('button', { name }).click();
  toast = (text) => this.page.locator('.toast').getByText(text).waitFor({ timeout: 10_000 });

  shown = (samples = 1) =>
    until(`${samples} samples of the newest input`, 120_000, async () => {
      const { scene, lastFrame, lastInputId } = await this.state();
      return scene?.state === 'ready' && lastFrame?.inputId === lastInputId && lastFrame.samples >= samples;
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
    await this.page.evaluate(() => document.querySelectorAll('details').forEach((group) => (group.open = true)));
    await typeNumber(this.page, name, value);
    await until(`the echo of ${name}`, 5000, async () => (await this.state()).settings[name] === value);
  }

  /** Notes the samples of each frame from now on. */
  record = () =>
    this.page.evaluate(() => {
      const seen = (window.samplesSeen = []);
      let last = window.heliograph.state.framesPresented;
      const look = () => {
        const { framesPresented, lastFrame } = window.heliograph.state;
        if (framesPresented !== last && lastFrame !== null) seen.push(lastFrame.samples);
        last = framesPresented;
        requestAnimationFrame(look);
      };
      requestAnimationFrame(look);
    });
}

const camera = async (tab) => JSON.stringify((await tab.state()).camera);

/** The line is cut and mended; the page has its view again. Answers the samples of the frames that it showed then. */
async function cutAndMend(cable, tab, unnoticed) {
  const before = await tab.state();
  await tab.record();
  cable.cut(unnoticed);
  await tab.banner(/Connection lost/).waitFor({ timeout: 10_000 });
  await tab.page.evaluate(() => (window.samplesSeen.length = 0));
  cable.mend();
  await until('the connection', 20_000, async () => (await tab.state()).connected);
  await until('a frame', 60_000, () => tab.page.evaluate(() => window.samplesSeen.length > 0));
  const after = await tab.state();
  expect(after.view === before.view, `view ${after.view} instead of ${before.view}`);
  expect(!after.watching, 'it watches its own view');
  return tab.page.evaluate(() => window.samplesSeen);
}

async function resumes(checks, browser, cable, tab) {
  browser.expectDisconnect = true;
  for (const [what, unnoticed] of [
    ['a line that breaks', false],
    ['a line that breaks unnoticed by the server', true],
  ]) {
    await checks.check(`${what}: the page has its view again, with camera, settings and the film that it had`, async () => {
      await tab.set('exposure', unnoticed ? 0.25 : 0.5);
      await tab.drag();
      await tab.shown(24);
      const [place, { samples }] = [await camera(tab), (await tab.state()).lastFrame];
      const seen = await cutAndMend(cable, tab, unnoticed);
      expect(seen[0] >= samples, `the film begins again: ${seen} samples after ${samples}`);
      expect((await camera(tab)) === place, 'the camera is another one');
      expect((await tab.state()).settings.exposure === (unnoticed ? 0.25 : 0.5), 'the settings are others');
      expect((await tab.page.locator('.banner:visible, .toast.error').count()) === 0, 'something is said to be wrong');
    });
  }
  await checks.check('what the viewer changed while the line was broken counts', async () => {
    const place = await camera(tab);
    cable.cut();
    await tab.banner(/Connection lost/).waitFor({ timeout: 10_000 });
    await tab.page.keyboard.press('r');
    cable.mend();
    await until('the connection', 20_000, async () => (await tab.state()).connected);
    await tab.shown();
    expect((await camera(tab)) !== place, 'the camera went back to where it was before');
  });
  browser.expectDisconnect = false;
}

async function handsOver(checks, driver, watcher, address) {
  await checks.check('who watches asks to drive; who drives may refuse', async () => {
    await driver.drag();
    await driver.shown(2);
    await watcher.page.goto(`${address}?view=${(await driver.state()).view}`);
    await watcher.banner(WATCHING).waitFor({ timeout: 20_000 });
    await watcher.shown();
    await watcher.press('Ask to drive');
    await driver.banner(/Viewer \d+ wants to drive/).waitFor({ timeout: 10_000 });
    await driver.page.screenshot({ path: join(outFolder, 'asked-to-hand-over.png') });
    await watcher.page.screenshot({ path: join(outFolder, 'asks-to-drive.png') });
    for (const { page } of [driver, watcher]) {
      const bad = [...(await badControls(page)), ...(await overlaps(page))];
      expect(bad.length === 0, bad.join('\n'));
    }
    await driver.press('Keep driving');
    await watcher.toast('Who drives this view goes on driving it.');
    expect((await watcher.state()).watching && !(await driver.state()).watching, 'the driver changed');
    expect((await driver.page.locator('.banner:visible').count()) === 0, 'the driver is still asked');
  });
  await checks.check('handed over, the other one drives from the same place, and who drove watches', async () => {
    const place = await camera(driver);
    await watcher.press('Ask to drive');
    await driver.banner(/wants to drive/).waitFor({ timeout: 10_000 });
    await driver.press('Hand over');
    await until('the hand-over', 10_000, async () => !(await watcher.state()).watching && (await driver.state()).watching);
    await watcher.toast('This view was handed to you. You drive it now.');
    await driver.banner(WATCHING).waitFor({ timeout: 20_000 });
    const near = (a, b) => JSON.parse(a).forward.every((v, i) => Math.abs(v - JSON.parse(b).forward[i]) < 1e-5);
    expect(near(await camera(watcher), place), 'it does not look where the driver looked');
    const before = (await driver.state()).framesPresented;
    await watcher.drag();
    await watcher.shown();
    await until('frames of the motion', 20_000, async () => (await driver.state()).framesPresented > before + 1);
  });
  await checks.check('who handed over may have it back', async () => {
    await driver.press('Ask to drive');
    await watcher.banner(/wants to drive/).waitFor({ timeout: 10_000 });
    await watcher.press('Hand over');
    await until('the hand-over', 10_000, async () => (await watcher.state()).watching && !(await driver.state()).watching);
    await driver.drag();
    await driver.shown();
    expect((await driver.page.locator('.toast.error').count()) === 0, 'the server refused something');
  });
}

export async function resumeChecks(checks) {
  const server = new Server(await freePort(), 'cornell', undefined, { HELIOGRAPH_SET: 'samples=4096' });
  const cable = new Cable();
  const browsers = [new Browser(), new Browser()];
  try {
    if (!(await checks.check('the server starts (resuming)', () => server.start()))) return;
    await cable.open(server.port);
    const [driver, watcher] = [new Tab(await browsers[0].start(SIZE)), new Tab(await browsers[1].start(SIZE))];
    await driver.page.goto(`http://127.0.0.1:${cable.port}/`);
    await driver.shown();
    await resumes(checks, browsers[0], cable, driver);
    await handsOver(checks, driver, watcher, `http://127.0.0.1:${server.port}/`);
    await checks.check('nothing was wrong in the browser\u2019s console (resuming)', async () => {
      const problems = browsers.flatMap((browser) => browser.problems);
      expect(problems.length === 0, problems.join('\n'));
    });
  } finally {
    for (const browser of browsers) await browser.stop();
    cable.close();
    await server.kill();
  }
}

if (import.meta.url === pathToFileURL(process.argv[1]).href) {
  const checks = new Checks();
  await resumeChecks(checks);
  checks.finish();
}
