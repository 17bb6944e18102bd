// Starts a server and a browser for the tests, and reports checks one a line.

import { spawn } from 'node:child_process';
import { accessSync, constants, mkdirSync, mkdtempSync, rmSync } from 'node:fs';
import { get } from 'node:http';
import { createRequire } from 'node:module';
import { createServer } from 'node:net';
import { tmpdir } from 'node:os';
import { delimiter, dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';

export const root = join(dirname(fileURLToPath(import.meta.url)), '../..');
const { chromium, firefox } = createRequire(join(root, 'client-web/package.json'))('playwright-core');

export const outFolder = join(root, 'out/browser');
mkdirSync(outFolder, { recursive: true });

const CHROMIUM_ARGUMENTS = [
  '--no-sandbox',
  '--disable-gpu',
  '--disable-quic',
  '--no-first-run',
  '--disable-background-networking',
  '--disable-component-update',
  '--disable-sync',
];

const runnable = (path) => {
  try {
    accessSync(path, constants.X_OK);
    return true;
  } catch {
    return false;
  }
};

/** A program in the folders of PATH, or undefined. */
const onPath = (name) =>
  (process.env.PATH ?? '').split(delimiter).filter(Boolean).map((folder) => join(folder, name)).find(runnable);

/** How each browser is started. Firefox is the system's own, driven by WebDriver BiDi; it may be missing. */
const ENGINES = {
  chromium: {
    type: chromium,
    path: () => process.env.HELIOGRAPH_CHROMIUM ?? '/usr/bin/chromium',
    options: { args: CHROMIUM_ARGUMENTS },
  },
  firefox: {
    type: firefox,
    path: () => process.env.HELIOGRAPH_FIREFOX ?? onPath('firefox') ?? onPath('firefox-esr'),
    // Its list of downloads would take the focus from the page.
    options: { channel: 'moz-firefox', firefoxUserPrefs: { 'browser.download.alwaysOpenPanel': false } },
  },
};

/** Where Firefox is installed, or undefined. */
export const firefoxPath = () => ENGINES.firefox.path();

/** Playwright's own empty style for a screenshot in Firefox, by its hash: the page's policy forbids it. */
const SCREENSHOT_STYLE = 'sha256-YjaKGiklmzC6wjXA513HAMmzus8VE61XCOT+SmwNZWA=';

export const pause = (ms) => new Promise((done) => setTimeout(done, ms));

const PATIENCE = 4; // a machine that builds something else meanwhile is so many times slower

/** Asks `check` every 50 ms until it is true; throws with what was waited for, where `ms` are not enough on any machine. */
export async function until(what, ms, check) {
  const end = Date.now() + PATIENCE * ms;
  for (;;) {
    const value = await check();
    if (value) return value;
    if (Date.now() > end) throw new Error(`waited ${PATIENCE * ms} ms for ${what}`);
    await pause(50);
  }
}

/** Unfolds the panel in which the setting stands, and what it is folded in there. */
export async function unfoldFor(page, name) {
  const field = page.locator(`[data-setting="${name}"]`);
  const panel = page.locator('.panel', { has: field });
  const id = await panel.getAttribute('id');
  const folded = await panel.evaluate((element) => element.classList.contains('folded'));
  const label = { 'light-panel': 'Light', 'settings-panel': 'Settings', 'effects-panel': 'Effects' }[id];
  if (folded) await page.locator('.dock').getByRole('button', { name: label }).click();
  await field.evaluate((element) => {
    for (let fold = element.closest('details'); fold !== null; fold = fold.parentElement.closest('details')) fold.open = true;
  });
}

/** Types a number into the field of a setting, as a person would. */
export async function typeNumber(page, name, value) {
  await unfoldFor(page, name);
  const field = page.locator(`[data-setting="${name}"] .number-field`);
  await field.fill(String(value));
  await field.press('Enter');
}

export function freePort() {
  return new Promise((done, failed) => {
    const probe = createServer();
    probe.on('error', failed);
    probe.listen(0, '127.0.0.1', () => {
      const { port } = probe.address();
      probe.close(() => done(port));
    });
  });
}

const healthy = (port) =>
  new Promise((done) => {
    get({ host: '127.0.0.1', port, path: '/healthz', timeout: 1000 }, (response) => {
      response.resume();
      done(response.statusCode === 200);
    }).on('error', () => done(false));
  });

/** The server program: HELIOGRAPH_BINARY unless `binary` is given; a .mjs file is run by node. */
export class Server {
  constructor(port, scene, binary = process.env.HELIOGRAPH_BINARY, environment = {}) {
    this.port = port;
    this.scene = scene;
    this.binary = resolve(binary ?? join(root, 'build/release/heliograph'));
    this.environment = environment;
    this.log = '';
  }

  async start() {
    const command = this.binary.endsWith('.mjs') ? [process.execPath, this.binary] : [this.binary];
    const words = [...command.slice(1), 'serve', this.scene, '--listen', `127.0.0.1:${this.port}`];
    const env = { ...process.env, ...this.environment };
    this.process = spawn(command[0], words, { cwd: root, env, stdio: ['ignore', 'pipe', 'pipe'] });
    let ended = null;
    for (const stream of [this.process.stdout, this.process.stderr]) stream.on('data', (data) => (this.log += data));
    this.process.on('error', (error) => (ended = error.message));
    this.process.on('exit', (code, signal) => (ended = `ended with ${code ?? signal}`));
    await until('/healthz', 60_000, async () => {
      if (ended !== null) throw new Error(`${this.binary}: ${ended}\n${this.log}`);
      return healthy(this.port);
    });
  }

  /** Ends the server as a crash would. */
  async kill() {
    const process = this.process;
    if (process === undefined || process.exitCode !== null || process.signalCode !== null) return;
    const gone = new Promise((done) => process.once('exit', done));
    process.kill('SIGKILL');
    await gone;
  }
}

/** A page in a fresh profile. `problems` collects console errors, exceptions and failed requests. */
export class Browser {
  problems = [];
  expectDisconnect = false; // while true, failing to reach the server is no problem

  constructor(engine = 'chromium') {
    this.engine = ENGINES[engine];
  }

  async start(viewport, options = {}) {
    this.profile = mkdtempSync(join(tmpdir(), 'heliograph-browser-'));
    this.context = await this.engine.type.launchPersistentContext(this.profile, {
      ...this.engine.options,
      colorScheme: 'dark', // as the pictures of the documentation; the contrast checks look at both
      executablePath: this.engine.path(),
      headless: true,
      viewport,
      acceptDownloads: true,
      ...options,
    });
    this.page = this.context.pages()[0] ?? (await this.context.newPage());
    this.page.on('console', (message) => {
      if (message.type() === 'error' || message.type() === 'warning')
        this.problem(`console ${message.type()}: ${message.text()}`);
    });
    this.page.on('pageerror', (error) => this.problem(`exception: ${error.message}`));
    this.page.on('requestfailed', (request) => {
      // The browser asks for the icon on its own, and a reload ends that.
      const reloaded = request.failure()?.errorText === 'net::ERR_ABORTED' && request.url().endsWith('/favicon.svg');
      if (!reloaded) this.problem(`request failed: ${request.url()}`);
    });
    return this.page;
  }

  problem(text) {
    const disconnect = /ERR_CONNECTION_REFUSED|WebSocket connection to .* failed|ERR_CONNECTION_RESET|\/ws$|status of \d+/.test(text);
    if ((this.expectDisconnect && disconnect) || text.includes(SCREENSHOT_STYLE)) return;
    if (this.problems.length < 20 && !this.problems.includes(text)) this.problems.push(text);
  }

  async stop() {
    await this.context?.close();
    if (this.profile !== undefined) rmSync(this.profile, { recursive: true, force: true });
  }
}

/** Runs checks in order; each prints one line and answers whether it passed. The last line is the count. */
export class Checks {
  passed = 0;
  failed = 0;

  async check(name, body) {
    const begin = Date.now();
    try {
      await body();
      this.passed += 1;
      console.log(`ok      ${name} (${Date.now() - begin} ms)`);
    } catch (error) {
      this.failed += 1;
      console.log(
        `FAILED  ${name}: ${String(error.message ?? error)
          .split('\n')
          .join('\n        ')}`,
      );
      return false;
    }
    return true;
  }

  finish() {
    console.log(`${this.passed} passed, ${this.failed} failed`);
    process.exitCode = this.failed === 0 && this.passed > 0 ? 0 : 1;
  }
}

export function expect(condition, message) {
  if (!condition) throw new Error(message);
}
