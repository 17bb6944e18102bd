// The accuracy panel against the fake server: it measures, shows what came, sets what is chosen, and says what went wrong.
// Part of client_test.mjs; run alone: node tests/browser/accuracy_test.mjs.

import { pathToFileURL } from 'node:url';
import { Session } from './fake_session.mjs';
import { badControls, lowContrast, overlaps } from './look.mjs';
import { Checks, expect, pause, until } from './page.mjs';

const DESKTOP = { width: 1280, height: 800 };
const PHONE = { width: 390, height: 844 };

const parts = ({ page }) => {
  const panel = page.locator('#accuracy-panel');
  return {
    panel,
    button: panel.locator('.measure'),
    words: panel.locator('.accuracy-words'),
    dots: panel.locator('.accuracy-drawing .dot'),
    row: (name) => panel.getByRole('button', { name }),
    changed: panel.locator('.accuracy-changed'),
  };
};
const settingIs = (session, name, value) =>
  until(`${name} ${value}`, 5000, async () => (await session.state()).settings[name] === value);

async function measuring(checks, session) {
  const { page } = session;
  const { panel, button } = parts(session);
  await checks.check('accuracy: its code is loaded when the panel is first opened', async () => {
    const scripts = () => page.evaluate(() => performance.getEntriesByType('resource').filter(({ name }) => name.includes('accuracy')).length);
    expect((await scripts()) === 0, 'loaded before');
    await page.locator('.dock').getByRole('button', { name: 'Accuracy' }).click();
    await button.waitFor();
    expect((await scripts()) === 1, `${await scripts()} scripts`);
    expect((await button.textContent()) === 'Measure this view', await button.textContent());
  });
  await checks.check('accuracy: measuring shows what and how long, and is given up', async () => {
    await session.ask('/received');
    await session.ask('/control?accuracy=hold');
    await panel.getByRole('combobox').selectOption('10');
    await button.focus();
    await page.keyboard.press('Enter');
    await panel.getByText('AO samples 9, about 7 s left').waitFor({ timeout: 20_000 });
    expect((await panel.locator('progress').evaluate(({ value }) => value)) === 0.4, 'the progress is not told');
    expect(await panel.getByRole('combobox').isDisabled(), 'how long can be chosen meanwhile');
    await session.screenshot('accuracy-measuring');
    expect((await button.textContent()) === 'Give up', await button.textContent());
    await page.keyboard.press('Enter'); // the focus has stayed
    await panel.getByText('Given up.').waitFor({ timeout: 20_000 });
    const seconds = (await session.received('accuracy')).map((message) => message.seconds);
    expect(seconds.join() === '10,0', `asked: ${seconds}`);
    expect(await panel.locator('progress').isHidden(), 'the progress stays');
    expect((await button.textContent()) === 'Measure this view', await button.textContent());
  });
}

async function refusals(checks, session) {
  const { panel, button } = parts(session);
  for (const [how, text] of [
    ['refuse', 'only who drives a view may have it measured'],
    ['broken', 'cannot read (accuracy.size: [0,0], allowed: two numbers above 0)'],
    ['failed', 'It could not be measured: the device was lost'],
  ]) {
    await checks.check(`accuracy: ${how} is said in the panel alone`, async () => {
      await session.ask(`/control?accuracy=${how}`);
      await button.click();
      await panel.getByRole('alert').getByText(text).waitFor({ timeout: 20_000 });
      expect((await session.page.locator('.toast.error').count()) === 0, 'it is told twice');
      expect((await button.getAttribute('aria-disabled')) === 'false', 'the button stays off');
    });
  }
}

async function result(checks, session) {
  const { page } = session;
  const { panel, button, words, dots } = parts(session);
  await checks.check('accuracy: the result is a plot with its front, and a list that begins with it', async () => {
    await session.ask('/control?accuracy=ready');
    await button.click();
    await dots.first().waitFor({ timeout: 20_000 });
    const [points, bests] = [await dots.count(), await panel.locator('.dot.best').count()];
    expect(points === 19 && bests === 11, `${points} points, ${bests} of the best`);
    const line = await panel.locator('polyline.front').getAttribute('points');
    expect(line.split(' ').length === 12, `front: ${line}`);
    const best = await panel.locator('.accuracy-list').first().locator('tbody button').allTextContents();
    expect(best.length === 12 && best.includes('As it was') && best[0] === 'Render scale 0.25', best.join(', '));
    const facts = await panel.innerText();
    for (const text of ['Measured on embree at 160 × 90 pixels in 29.8 s.', '4 times as many pixels', 'known to 0.40 %'])
      expect(facts.includes(text), facts);
    expect((await panel.locator('.accuracy-row.now').innerText()).startsWith('As it was'), 'as it was is not marked');
    await panel.locator('.accuracy-drawing').hover({ position: { x: 2, y: 2 } });
    await session.screenshot('accuracy');
  });
  await checks.check('accuracy: a point tells its row, and a press sets it', async () => {
    const box = await panel.locator('.dot.best').nth(7).boundingBox();
    const [x, y] = [box.x + box.width / 2 + 2, box.y + box.height / 2 - 2];
    await page.mouse.move(x, y);
    const told = 'AO samples from 9 to 25: error 3.1 % to 1.8 %, +38 ms';
    await until('the words', 5000, async () => (await words.textContent()) === told);
    await session.ask('/received');
    await page.mouse.click(x, y);
    await settingIs(session, 'aoSamples', 25);
    const [sent, ...more] = await session.received('settings');
    expect(more.length === 0 && JSON.stringify(sent.values) === '{"aoSamples":25}', JSON.stringify([sent, ...more]));
    expect((await panel.locator('.accuracy-row.now').innerText()).startsWith('AO samples 25'), 'it is not marked');
    expect((await parts(session).changed.textContent()) === '', 'a row is called a change');
  });
}

async function choosing(checks, session) {
  const { page } = session;
  const { panel, row, words, changed } = parts(session);
  await checks.check('accuracy: Enter on a row sets it alone, undo and "As it was" lead back', async () => {
    await row(/^Render scale 0.5, AO samples 4: error 3.1 % to 11 %/).focus();
    expect((await words.textContent()).startsWith("Render scale 0.5, AO samples 4: error"), await words.textContent());
    await page.keyboard.press('Enter');
    await settingIs(session, 'renderScale', 0.5);
    await settingIs(session, 'aoSamples', 4);
    await row(/^Samples at rest from 4 to 8/).focus();
    await page.keyboard.press('Enter');
    await settingIs(session, 'samples', 8);
    const { settings } = await session.state();
    expect(settings.renderScale === 1 && settings.aoSamples === 9, 'the row before is not taken back');
    await page.keyboard.press('Control+z');
    await settingIs(session, 'renderScale', 0.5);
    await page.keyboard.press('Control+z');
    await settingIs(session, 'renderScale', 1);
    await settingIs(session, 'aoSamples', 25);
    await panel.getByRole('button', { name: 'As it was', exact: true }).click();
    await settingIs(session, 'aoSamples', 9);
    expect((await panel.locator('.accuracy-row.now').innerText()).startsWith('As it was'), 'it is not marked');
  });
  await checks.check('accuracy: the others are folded, by setting, with what they are compared to', async () => {
    await panel.locator('summary').click();
    const titles = await panel.locator('[scope=rowgroup]').allTextContents();
    for (const title of ['Indirect light (off as it was, against all light)', 'JPEG quality (80 as it was, coding alone)', 'Combinations'])
      expect(titles.includes(title), titles.join(' | '));
    const all = await panel.locator('.accuracy-row').count();
    expect(all === 22, `${all} rows`);
    await session.screenshot('accuracy-list');
    await panel.locator('summary').click();
  });
  await checks.check('accuracy: a view that has changed since is said in a line', async () => {
    await session.set('fog', true);
    await until('the line of fog', 5000, async () => (await changed.textContent()).startsWith('Changed since: Fog.'));
    await session.set('fog', false);
    await until('no line', 5000, async () => (await changed.textContent()) === '');
    await page.locator('body > canvas').focus();
    await page.keyboard.press('KeyW', { delay: 300 });
    await until('the line of the camera', 5000, async () => (await changed.textContent()).startsWith('Changed since: camera.'));
    await page.locator('.dock').getByRole('button', { name: 'Effects' }).click();
  });
}

async function wiping(checks, session) {
  const { page } = session;
  const pictures = parts(session).panel.locator('.wipe-pictures');
  const slider = parts(session).panel.getByRole('slider', { name: 'Border between the exact picture' });
  const wipe = () => pictures.evaluate((element) => element.style.getPropertyValue('--wipe'));
  await checks.check('accuracy: two pictures, with a border that arrows and pointer move', async () => {
    const sizes = await pictures.locator('img').evaluateAll((images) => images.map((image) => image.naturalWidth));
    expect(sizes.join() === '160,160', `widths: ${sizes}`);
    expect((await wipe()) === '50%', await wipe());
    const camera = JSON.stringify((await session.state()).camera);
    await slider.focus();
    await page.keyboard.press('ArrowRight');
    await page.keyboard.press('ArrowRight');
    expect((await wipe()) === '52%', await wipe());
    await page.keyboard.press('Home');
    expect((await wipe()) === '0%' && (await slider.getAttribute('aria-valuetext')) === '0 % exact', await wipe());
    expect(JSON.stringify((await session.state()).camera) === camera, 'the camera moved too');
    await pictures.scrollIntoViewIfNeeded();
    const box = await pictures.boundingBox();
    await page.mouse.move(box.x + 10, box.y + 20);
    await page.mouse.down();
    await page.mouse.move(box.x + box.width * 0.25, box.y + 30);
    await page.mouse.up();
    expect((await wipe()) === '25%', await wipe());
    await session.screenshot('accuracy-wipe');
  });
}

async function looks(checks, session) {
  const { page } = session;
  const { panel } = parts(session);
  for (const [theme, { width, height }] of [
    ['dark', DESKTOP],
    ['light', DESKTOP],
    ['light', PHONE],
    ['dark', PHONE],
  ]) {
    await checks.check(`accuracy: ${width} x ${height}, ${theme}: all is named, inside and to be read`, async () => {
      await page.emulateMedia({ colorScheme: theme });
      await page.setViewportSize({ width, height });
      await pause(300);
      if (!(await panel.locator('.measure').isVisible())) {
        await page.locator('.top-bar').getByRole('button', { name: 'Viewpoint' }).click();
        await page.getByRole('menuitem', { name: 'Accuracy' }).click();
      }
      const body = panel.locator('.panel-body');
      const shots = Math.ceil(await body.evaluate((element) => element.scrollHeight / element.clientHeight));
      for (let i = 0; i < shots; i += 1) {
        await body.evaluate((element, at) => (element.scrollTop = at * element.clientHeight), i);
        await session.screenshot(`accuracy-${width}-${theme}-${i}`);
      }
      await body.evaluate((element) => (element.scrollTop = 0));
      const wide = await body.evaluate((element) => element.scrollWidth - element.clientWidth);
      expect(wide <= 0, `${wide} pixels wider than the panel`);
      const bad = [...(await badControls(page)), ...(await overlaps(page)), ...(await lowContrast(page))];
      expect(bad.length === 0, bad.join('\n'));
    });
  }
  await page.emulateMedia({ colorScheme: 'dark' });
}

async function endings(checks, session) {
  const { page } = session;
  const { panel, button } = parts(session);
  await checks.check('accuracy: another scene ends it and forgets what was measured', async () => {
    await page.setViewportSize(DESKTOP);
    await session.ask('/control?accuracy=hold');
    await panel.locator('.measure').waitFor();
    await button.click();
    await panel.getByText('AO samples 9').waitFor({ timeout: 20_000 });
    await page.evaluate(() => (location.hash = '#scene=courtyard'));
    await panel.getByText('Given up: another scene is shown.').waitFor({ timeout: 20_000 });
    expect(await panel.locator('.accuracy-result').isHidden(), 'the other scene\u2019s result stays');
  });
  await checks.check('accuracy: a lost connection is said, and the button waits for the next one', async () => {
    await session.shown('courtyard');
    await button.click();
    await panel.getByText('AO samples 9').waitFor({ timeout: 20_000 });
    session.browser.expectDisconnect = true;
    await session.server.kill();
    await panel.getByText('The connection was lost while it was measured.').waitFor({ timeout: 20_000 });
    expect((await button.getAttribute('aria-disabled')) === 'true', 'it can be pressed');
    await session.server.start();
    await until('the connection', 20_000, async () => (await button.getAttribute('aria-disabled')) === 'false');
    session.browser.expectDisconnect = false;
  });
}

/** Runs everything; failures and passes are counted in `checks`. */
export async function accuracyChecks(checks) {
  const session = new Session();
  const set = { HELIOGRAPH_FAKE_SET: '{"samples":4}' };
  try {
    if (!(await checks.check('the page is ready for accuracy', () => session.start(DESKTOP, {}, set)))) return;
    await measuring(checks, session);
    await refusals(checks, session);
    await result(checks, session);
    await choosing(checks, session);
    await wiping(checks, session);
    await looks(checks, session);
    await endings(checks, session);
    await checks.check('nothing was wrong in the browser\u2019s console (accuracy)', async () => {
      expect(session.browser.problems.length === 0, session.browser.problems.join('\n'));
    });
  } finally {
    await session.stop();
  }
}

if (import.meta.url === pathToFileURL(process.argv[1]).href) {
  const checks = new Checks();
  await accuracyChecks(checks);
  checks.finish();
}
