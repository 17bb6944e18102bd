// The page at a head with render nodes: the panel lists them, and one that dies while the view moves costs no picture. Part of
// client_test.mjs; run alone: node tests/browser/pool_test.mjs. Needs nats-server. Writes screenshots to out/browser.

import { spawn } from 'node:child_process';
import { connect } from 'node:net';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { overlaps } from './look.mjs';
import { Browser, Checks, expect, freePort, outFolder, pause, Server, until } from './page.mjs';

const SIZE = { width: 1280, height: 900 };
const LONGEST_GAP = 5_000; // ms between pictures; the figure itself is printed, as it depends on the machine's other work
const SWINGS = 80;

const listens = (port) =>
  new Promise((done) => {
    const line = connect({ port, host: '127.0.0.1' }, () => {
      line.destroy();
      done(true);
    });
    line.on('error', () => done(false));
  });

/** Processes that end with the test. */
class Crew {
  processes = new Map();

  start(name, program, ...words) {
    const process = spawn(program, words, { stdio: 'ignore' });
    process.on('error', (error) => console.log(`        ${name}: ${error.message}`));
    this.processes.set(name, process);
  }

  async end(name) {
    const process = this.processes.get(name);
    if (process === undefined || process.exitCode !== null || process.signalCode !== null) return;
    const gone = new Promise((done) => process.once('exit', done));
    process.kill('SIGKILL');
    await gone;
  }

  signal(name, kind) {
    this.processes.get(name).kill(kind);
  }

  async endAll() {
    for (const name of this.processes.keys()) await this.end(name);
  }
}

/** Moves the view for some seconds and returns the longest time between two pictures. `during` is called in the middle. */
async function longestGap(page, during) {
  const shown = page.evaluate(async (ms) => {
    let last = window.heliograph.state.lastFrame;
    let before = performance.now();
    let longest = 0;
    for (const end = before + ms; performance.now() < end; ) {
      await new Promise((done) => setTimeout(done, 4));
      if (window.heliograph.state.lastFrame === last) continue;
      last = window.heliograph.state.lastFrame;
      longest = Math.max(longest, performance.now() - before);
      before = performance.now();
    }
    return Math.max(longest, performance.now() - before);
  }, SWINGS * 40);
  await page.mouse.move(640, 400);
  await page.mouse.down();
  for (let i = 0; i < SWINGS + 15; i += 1) {
    await page.mouse.move(640 + 200 * Math.sin(i / 12), 400);
    if (i === SWINGS / 2) await during();
    await pause(40);
  }
  await page.mouse.up();
  return shown;
}

const section = (page) => page.locator('#statistics-panel .pool');
const title = (page) => section(page).locator('h3').textContent();
const titled = (page, start, ms) => until(start, ms, async () => (await title(page)).startsWith(start));

async function nodesWork(checks, page) {
  await checks.check('the pool: both nodes are listed', () => titled(page, 'Pool: 2 nodes', 20_000));
  await checks.check('the pool: their rate and round trip are told once they have worked', async () => {
    const gap = await longestGap(page, async () => undefined);
    console.log(`        longest time between pictures while nothing happens: ${gap.toFixed(0)} ms`);
    await until('a rate of both', 20_000, async () => {
      const notes = await section(page).locator('.bar-note').allTextContents();
      return notes.length === 2 && notes.every((note) => /Mrays\/s · .* ms there and back/.test(note));
    });
    await section(page).scrollIntoViewIfNeeded();
    await page.screenshot({ path: join(outFolder, 'pool.png') });
    expect((await overlaps(page)).length === 0, 'panels overlap');
  });
}

async function nodeDies(checks, page, crew) {
  await checks.check('the pool: a node that is killed while the view moves does not end the pictures', async () => {
    const gap = await longestGap(page, () => crew.end('node 2'));
    console.log(`        longest time between pictures: ${gap.toFixed(0)} ms`);
    expect(gap <= LONGEST_GAP, `${gap.toFixed(0)} ms without a picture`);
    await titled(page, 'Pool: 1 node', 5_000);
    await page.screenshot({ path: join(outFolder, 'pool-node-died.png') });
  });
  await checks.check('the pool: a node that hangs does not end the pictures, and comes back', async () => {
    const gap = await longestGap(page, async () => crew.signal('node 1', 'SIGSTOP'));
    console.log(`        longest time between pictures: ${gap.toFixed(0)} ms`);
    expect(gap <= LONGEST_GAP, `${gap.toFixed(0)} ms without a picture`);
    await titled(page, 'Pool: no nodes', 5_000);
    crew.signal('node 1', 'SIGCONT');
    await titled(page, 'Pool: 1 node', 5_000);
  });
  await checks.check('the pool: without a broker the page says so, and pictures go on', async () => {
    await crew.end('broker');
    await titled(page, 'Pool: no line', 5_000);
    const gap = await longestGap(page, async () => undefined);
    expect(gap <= LONGEST_GAP, `${gap.toFixed(0)} ms without a picture`);
  });
}

export async function poolChecks(checks) {
  const port = await freePort();
  const url = `nats://127.0.0.1:${port}`;
  const server = new Server(await freePort(), 'cornell', undefined, { HELIOGRAPH_POOL: url, HELIOGRAPH_SET: 'samples=4096' });
  const browser = new Browser();
  const crew = new Crew();
  try {
    crew.start('broker', 'nats-server', '--addr', '127.0.0.1', '--port', String(port));
    await until('nats-server', 5_000, () => listens(port));
    for (const name of ['node 1', 'node 2']) crew.start(name, server.binary, 'node', '--pool', url, '--name', name, '--scene-cache', 'none');
    if (!(await checks.check('the server starts (pool)', () => server.start()))) return;
    const page = await browser.start(SIZE);
    await page.goto(`http://127.0.0.1:${server.port}/`);
    await until('a picture', 60_000, () => page.evaluate(() => window.heliograph.state.lastFrame !== null));
    const panel = page.locator('#statistics-panel');
    if (await panel.locator('.panel-body').isHidden()) await panel.locator('.panel-head').click();
    await nodesWork(checks, page);
    await nodeDies(checks, page, crew);
    await checks.check('nothing was wrong in the browser\u2019s console (pool)', async () => {
      expect(browser.problems.length === 0, browser.problems.join('\n'));
    });
  } finally {
    await browser.stop();
    await server.kill();
    await crew.endAll();
  }
}

if (import.meta.url === pathToFileURL(process.argv[1]).href) {
  const checks = new Checks();
  await poolChecks(checks);
  checks.finish();
}
