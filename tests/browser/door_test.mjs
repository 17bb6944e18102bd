// How the page gets in: tokens, and what it says where the server refuses it. Part of client_test.mjs; run alone:
// node tests/browser/door_test.mjs.

import { pathToFileURL } from 'node:url';
import { Session } from './fake_session.mjs';
import { Checks, expect, pause, until } from './page.mjs';

const DESKTOP = { width: 1440, height: 900 };
const TOKEN = 'a+b 1';

const bannerSays = (page, words) =>
  until(`"${words}" in the banner`, 8000, async () => (await page.locator('.banner').textContent()).includes(words));

async function tokens(checks) {
  const session = new Session();
  try {
    await checks.check('a token is asked for by a field, a wrong one is said to be wrong', async () => {
      await session.start(DESKTOP, {}, { HELIOGRAPH_FAKE_TOKEN: TOKEN }, '', false);
      const { page } = session;
      await bannerSays(page, 'asks for a token');
      await page.getByLabel('Token').fill('guess');
      await page.getByLabel('Token').press('Enter');
      await bannerSays(page, 'refused the token');
      await session.screenshot('token');
      await page.getByLabel('Token').fill(TOKEN);
      await page.getByRole('button', { name: 'Connect' }).click();
      await session.shown('cornell');
      expect(await page.locator('.banner').isHidden(), 'the banner stays');
    });
    await checks.check('the token is known after a reload', async () => {
      await session.page.reload();
      await session.shown('cornell');
    });
    await checks.check('a token added to the address in the same tab is taken, and does not stay there', async () => {
      const { page } = session;
      await page.evaluate(() => sessionStorage.clear());
      await page.reload();
      await bannerSays(page, 'asks for a token');
      await page.evaluate((token) => (location.hash = `#token=${encodeURIComponent(token)}`), TOKEN);
      await session.shown('cornell');
      expect(!page.url().includes('token'), page.url());
    });
    await checks.check('a page opened with the token in its address takes it away from there', async () => {
      const { page } = session;
      await page.evaluate(() => sessionStorage.clear());
      await page.goto('about:blank');
      await page.goto(`http://127.0.0.1:${session.server.port}/#token=${encodeURIComponent(TOKEN)}`);
      await session.shown('cornell');
      expect(!page.url().includes('token'), page.url());
    });
  } finally {
    await session.stop();
  }
}

async function refusals(checks) {
  const session = new Session();
  const refuse = (status, why) => session.ask(`/control?refuse=${status}&why=${encodeURIComponent(why)}`);
  try {
    await checks.check('a server that is full, another origin, a proxy without WebSockets: each is said', async () => {
      await session.start(DESKTOP);
      const { page } = session;
      session.browser.expectDisconnect = true;
      await refuse(503, 'no room for another viewer\n');
      await page.reload();
      await bannerSays(page, 'The server has no room (no room for another viewer)');
      await bannerSays(page, 'trying again in');
      await refuse(403, 'pages of another origin may not connect\n');
      await bannerSays(page, `The server takes no pages from http://127.0.0.1:${session.server.port}`);
      await bannerSays(page, '--allow-origin http://127.0.0.1');
      await session.screenshot('refused-origin');
      await refuse(426, 'WebSocket is spoken here\n');
      await bannerSays(page, 'no WebSocket reaches it');
    });
    await checks.check('the page gets in by itself when the server has room again', async () => {
      await refuse('', '');
      await session.shown('cornell');
      expect(await session.page.locator('.banner').isHidden(), 'the banner stays');
    });
    await checks.check('a server that is gone is no refusal', async () => {
      await session.server.kill();
      await bannerSays(session.page, 'Connection lost');
      await pause(1500);
      await bannerSays(session.page, 'Connection lost');
    });
  } finally {
    await session.stop();
  }
}

/** Runs everything; failures and passes are counted in `checks`. */
export async function doorChecks(checks) {
  await tokens(checks);
  await refusals(checks);
}

if (import.meta.url === pathToFileURL(process.argv[1]).href) {
  const checks = new Checks();
  await doorChecks(checks);
  checks.finish();
}
