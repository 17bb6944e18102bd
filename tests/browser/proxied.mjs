// The page at an address that leads through a proxy: proxied.mjs URL. Certificates are not asked for who signed them. The last
// line is `N passed, N failed`.

import { Browser, Checks, expect, until } from './page.mjs';

const url = process.argv[2];
const checks = new Checks();
const browser = new Browser();
const sockets = [];
let page;

/** Brightest minus darkest pixel of the canvas, of a grid over it. */
const contrast = () =>
  page.locator('body > canvas').evaluate((canvas) => {
    const small = document.createElement('canvas');
    small.width = small.height = 16;
    const context = small.getContext('2d');
    context.drawImage(canvas, 0, 0, 16, 16);
    const values = context.getImageData(0, 0, 16, 16).data.filter((_, i) => i % 4 === 1);
    return Math.max(...values) - Math.min(...values);
  });

try {
  await checks.check('the page loads', async () => {
    page = await browser.start({ width: 640, height: 360 }, { ignoreHTTPSErrors: true });
    page.on('websocket', (socket) => sockets.push(socket));
    const answer = await page.goto(url);
    expect(answer.status() === 200, `HTTP ${answer.status()}`);
  });
  await checks.check('its WebSocket goes the same way', async () => {
    await until('a WebSocket with messages', 20_000, () => sockets.length > 0);
    const wanted = new URL('ws', url.replace(/^http/, 'ws')).href;
    expect(sockets[0].url() === wanted, `${sockets[0].url()} instead of ${wanted}`);
  });
  await checks.check('a frame is drawn', () => until('a picture', 30_000, async () => (await contrast()) > 20));
  await checks.check('without a complaint of the browser', () => {
    expect(browser.problems.length === 0, browser.problems.join('\n'));
  });
} finally {
  await browser.stop();
}
checks.finish();
