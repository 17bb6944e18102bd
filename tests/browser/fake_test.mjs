// The page in Chromium against the fake server: hybrid settings, partition, timeline, effects panel, click to focus. Part
// of client_test.mjs; run alone: node tests/browser/fake_test.mjs. Writes screenshots to out/browser.

import { get } from 'node:http';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { Browser, Checks, expect, freePort, outFolder, pause, root, Server, until } from './page.mjs';

const DESKTOP = { width: 1440, height: 900 };
const FAKE = join(root, 'tests/browser/fake_server.mjs');

/** A page at a fake server, with what the checks ask of both. */
class Session {
  browser = new Browser();

  async start(viewport, options = {}, environment = {}) {
    this.server = new Server(await freePort(), 'cornell', FAKE, environment);
    await this.server.start();
    this.page = await this.browser.start(viewport, options);
    await this.page.goto(`http://127.0.0.1:${this.server.port}/`);
    await this.shown('cornell');
  }

  async stop() {
    await this.browser.stop();
    await this.server?.kill();
  }

  state = () => this.page.evaluate(() => window.heliograph.state);
  screenshot = (name) => this.page.screenshot({ path: join(outFolder, `${name}.png`) });
  field = (name) => this.page.locator(`[data-setting="${name}"]`);

  /** Waits until the scene and a picture of the newest input are on the screen. */
  async shown(name) {
    await until(`scene ${name}`, 20_000, async () => {
      const { scene, lastFrame, lastInputId } = await this.state();
      return scene?.name === name && scene.state === 'ready' && lastFrame?.inputId === lastInputId;
    });
  }

  async set(name, value) {
    await this.page.evaluate(() => document.querySelectorAll('details').forEach((group) => (group.open = true)));
    const field = this.field(name);
    if ((await field.locator('select').count()) > 0) await field.locator('select').selectOption(value);
    else await field.locator('input[role=switch]').setChecked(value);
    await until(`the echo of ${name}`, 5000, async () => (await this.state()).settings[name] === value);
  }

  ask = (path) =>
    new Promise((done, failed) => {
      get({ host: '127.0.0.1', port: this.server.port, path }, (response) => {
        let text = '';
        response.on('data', (data) => (text += data));
        response.on('end', () => done(text));
      }).on('error', failed);
    });

  /** Messages of this type that the server got since it was last asked. */
  received = async (type) => JSON.parse(await this.ask('/received')).filter((message) => message.type === type);
}

async function hybridSettings(checks, session) {
  await checks.check('hybrid settings say when they count', async () => {
    const share = session.field('hybridShare');
    const expectShare = async (disabled, note) => {
      const text = await share.locator('.field-note').textContent();
      expect(text === note, `note "${text}", expected "${note}"`);
      for (const input of await share.locator('input').all())
        expect((await input.isDisabled()) === disabled, `disabled is not ${disabled} with note "${text}"`);
    };
    await expectShare(true, 'Only with device hybrid.');
    expect(await session.field('enableVulkan').locator('.field-note').textContent(), 'no note at enableVulkan');
    await session.set('device', 'hybrid');
    await expectShare(true, 'Only with a manual balance.');
    expect(!(await session.field('enableVulkan').locator('.field-note').textContent()), 'a note at enableVulkan');
    await session.set('hybridBalance', 'manual');
    await expectShare(false, '');
    const group = await share.evaluate((element) => element.closest('details').querySelector('summary').textContent);
    expect(group === 'Hybrid', `in group ${group}`);
  });
}

/** Runs everything; failures and passes are counted in `checks`. */
export async function fakeChecks(checks) {
  const session = new Session();
  try {
    if (!(await checks.check('the page shows the fake server\u2019s picture', () => session.start(DESKTOP)))) return;
    await hybridSettings(checks, session);
    await checks.check('nothing was wrong in the browser\u2019s console (fake server)', async () => {
      expect(session.browser.problems.length === 0, session.browser.problems.join('\n'));
    });
  } finally {
    await session.stop();
  }
}

if (import.meta.url === pathToFileURL(process.argv[1]).href) {
  const checks = new Checks();
  await fakeChecks(checks);
  checks.finish();
}
