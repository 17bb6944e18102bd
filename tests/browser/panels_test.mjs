// What the page's panels and dialogs do by keyboard, in small windows and in colours of the viewer's own, against the fake
// server. Part of client_test.mjs; run alone: node tests/browser/panels_test.mjs.

import { pathToFileURL } from 'node:url';
import { Session } from './fake_session.mjs';
import { badControls, lowContrast, overlaps } from './look.mjs';
import { Checks, expect, pause, unfoldFor, until } from './page.mjs';

const DESKTOP = { width: 1440, height: 900 };
const focused = (page) => page.evaluate(() => document.activeElement.tagName);

async function forecast(checks, session) {
  await checks.check('the statistics foretell the error, and what more samples would bring', async () => {
    const text = () => session.page.locator('#statistics-panel .forecast').textContent();
    await until('a forecast', 8000, async () => /^1 % would take [\d\u202f]+ samples$/.test(await text()));
    const { samples } = (await session.state()).settings;
    const told = Number((await text()).replace(/\u202f/g, '').match(/(\d+) samples/)[1]);
    expect(Math.abs(told / (4 * samples) - 1) < 0.05, `${told} samples, not four times ${samples}`);
  });
}

async function errorTarget(checks, session) {
  await checks.check('at the error target the picture ends, and the statistics say so', async () => {
    const field = session.field('errorTarget').locator('.number-field');
    await field.fill('4');
    await field.press('Enter');
    await session.page.locator('canvas').first().focus();
    await session.page.keyboard.press('KeyW'); // moves a little: another picture
    const line = () => session.page.locator('#statistics-panel .line', { hasText: 'Relative error' }).textContent();
    await until('reached', 8000, async () => /Relative error3\.0 % · target reached$/.test(await line()));
    const { lastFrame } = await session.state();
    expect(lastFrame.final && lastFrame.samples === 16, `${lastFrame.samples} samples, final ${lastFrame.final}`);
    await field.fill('0');
    await field.press('Enter');
    await until('all samples', 8000, async () => !(await line()).includes('reached'));
  });
}

async function timeBudget(checks, session) {
  await checks.check('what is left out for a time budget is listed with what it saves', async () => {
    const field = session.field('timeBudget').locator('.number-field');
    const list = session.page.locator('#statistics-panel .hurry');
    expect(!(await list.isVisible()), 'a list without a budget');
    await field.fill('50');
    await field.press('Enter');
    await until('the list', 8000, () => list.isVisible());
    const text = await list.innerText();
    expect(/Time budget 50 ms: 40 ms a picture/i.test(text), text);
    expect(/AO samples 25 → 9/.test(text) && /100 ms without/.test(text), text);
    await session.page.screenshot({ path: new URL('../../out/browser/time_budget.png', import.meta.url).pathname });
    await field.fill('0');
    await field.press('Enter');
    await until('no list', 8000, async () => !(await list.isVisible()));
    await until('all samples', 8000, async () => (await session.state()).lastFrame.final);
  });
}

async function errorMap(checks, session) {
  const { page } = session;
  const card = page.getByRole('region', { name: 'Error of each part of the picture' });
  await checks.check('N shows where the error is, with a legend, and hides it', async () => {
    await page.locator('body > canvas').focus();
    await page.keyboard.press('KeyN');
    await until('the card', 5000, () => card.isVisible());
    expect((await session.state()).settings.showError === true, 'the setting is on');
    expect((await session.field('showError').getByRole('switch').getAttribute('aria-checked')) !== 'false', 'so is its switch');
    const rows = await card.locator('li').allTextContents();
    const shares = rows.map((row) => Number(row.match(/([\d.]+) %$/)[1]));
    expect(rows.length === 6 && rows[1].startsWith('0.5 % to 1 %'), rows.join(', '));
    expect(Math.abs(shares.reduce((sum, share) => sum + share, 0) - 100) < 2, `shares: ${shares.join(', ')}`);
    const tinted = await page.locator('.error-overlay:not([hidden])').evaluate((canvas) => {
      const pixels = canvas.getContext('2d').getImageData(0, canvas.height / 2, canvas.width, 1).data;
      return pixels.filter((value, i) => i % 4 === 3 && value > 100).length / canvas.width;
    });
    expect(tinted > 0.9, `${tinted} of the middle row is tinted`);
    await session.screenshot('error-map');
    await page.keyboard.press('KeyN');
    await until('no card', 5000, async () => !(await card.isVisible()));
  });
}

async function numbers(checks, session) {
  const { page } = session;
  const field = session.field('exposure').locator('.number-field');
  await unfoldFor(page, 'exposure');
  const is = (value) =>
    until(`exposure ${value}`, 5000, async () => (await session.state()).settings.exposure === value);
  await checks.check('a decimal comma is one, and arrows step by the range', async () => {
    await field.fill('0,5');
    await field.press('Enter');
    await is(0.5);
    await field.focus();
    await page.keyboard.press('ArrowUp');
    await until('a step', 5000, async () => (await session.state()).settings.exposure > 0.5);
    const { exposure } = (await session.state()).settings;
    expect(exposure < 0.9, `from 0.5 to ${exposure} in one step`);
  });
  await checks.check('reset goes to what the server was started with, field of view and size too', async () => {
    await page.locator('#resolution-mode').selectOption('half');
    await session.field('fieldOfView').locator('.number-field').fill('90');
    await session.field('fieldOfView').locator('.number-field').press('Enter');
    await page.getByRole('button', { name: 'Reset to defaults' }).click();
    await is(0.25);
    const { fieldOfView } = (await session.state()).camera;
    expect(Math.abs(fieldOfView - 50) < 0.01, `field of view ${fieldOfView}`);
    expect((await page.locator('#resolution-mode').inputValue()) === 'capped', 'the size stays');
  });
  await checks.check('Control Z and the button take changes back', async () => {
    await field.fill('2');
    await field.press('Enter');
    await is(2);
    await page.keyboard.press('Control+z');
    await is(0.25);
    await page.getByRole('button', { name: 'Undo' }).click(); // the reset of before
    await until('the value of before', 5000, async () => (await session.state()).settings.exposure > 0.5);
    await page.getByRole('button', { name: 'Reset to defaults' }).click();
  });
  await checks.check('what is being typed stays when settings come from the server', async () => {
    const shown = (await session.state()).settings.showPartition;
    const toggle = () => page.evaluate(() => document.querySelector('[data-setting="showPartition"] input').click());
    await field.fill('0,7');
    await toggle();
    await until('the other setting', 5000, async () => (await session.state()).settings.showPartition === !shown);
    expect((await field.inputValue()) === '0,7', `the field holds ${await field.inputValue()}`);
    await field.press('Enter');
    await is(0.7);
    await toggle();
    await until('it as before', 5000, async () => (await session.state()).settings.showPartition === shown);
  });
  await checks.check('the reset of one field keeps the focus', async () => {
    await field.fill('1');
    await field.press('Enter');
    await is(1);
    await session.field('exposure').locator('.reset').focus();
    await page.keyboard.press('Enter');
    await is(0.25);
    const name = await page.evaluate(() => document.activeElement.closest('[data-setting]')?.dataset.setting);
    expect(name === 'exposure', `the focus is at ${name}`);
  });
}

async function keyboard(checks, session) {
  const { page } = session;
  await checks.check('Escape in a panel goes back to the picture', async () => {
    await session.field('automaticScale').locator('input').focus();
    await page.keyboard.press('Escape');
    expect((await focused(page)) === 'CANVAS', `${await focused(page)} has the focus`);
  });
  await checks.check('H closes the help that it opened; F1 and F2 do nothing behind it', async () => {
    await page.keyboard.press('h');
    await page.keyboard.press('F1');
    await page.keyboard.press('F2');
    await pause(200);
    expect(await page.locator('dialog.help').isVisible(), 'no help');
    expect(await page.evaluate(() => !document.querySelector('#page').classList.contains('bare')), 'F1 hid the panels');
    expect(!(await session.state()).pathPlaying, 'F2 started the path');
    await page.keyboard.press('h');
    expect(await page.locator('dialog.help').isHidden(), 'the help stays');
  });
  await checks.check('at most 25 tab stops from the picture to the dock', async () => {
    await page.locator('body > canvas').focus();
    let stops = 0;
    for (; stops < 100; stops += 1) {
      await page.keyboard.press('Tab');
      if (await page.evaluate(() => document.activeElement.closest('.dock') !== null)) break;
    }
    expect(stops < 25, `${stops + 1} tab stops`);
  });
}

async function words(checks, session) {
  const { page } = session;
  await checks.check('before any motion no delay is told, and no target of zero', async () => {
    const text = await page.locator('#statistics-panel').innerText();
    expect(text.includes('move to measure'), text);
    expect(!/\/ 0\b/.test(text), text);
  });
}

async function searching(checks, session) {
  const { page } = session;
  const panel = page.locator('#settings-panel');
  const shown = () => panel.locator('.field:not([hidden])').evaluateAll((rows) => rows.map((row) => row.dataset.setting));
  await checks.check('a search leaves the rows that it means, and what is changed stands alone', async () => {
    const all = (await shown()).length;
    await panel.getByRole('searchbox').fill('jpeg quality');
    expect((await shown()).includes('jpegQuality') && (await shown()).length < 4, `shown: ${await shown()}`);
    await page.keyboard.press('Escape');
    expect((await shown()).length === all, 'Escape does not clear the search');
    await panel.locator('.differing').click();
    expect((await shown()).length === 0, `changed: ${await shown()}`);
    await page.evaluate(() => document.querySelector('#settings-panel select').focus());
    await panel.getByLabel('Preset').selectOption('exact');
    await until('the preset', 5000, async () => (await session.state()).settings.samples === 1024);
    const rows = await shown();
    expect(rows.includes('samples') && !rows.includes('exposure'), `changed: ${rows}`);
    await panel.getByLabel('Preset').selectOption('balanced');
    await until('the start', 5000, async () => (await session.state()).settings.samples === 64);
    expect((await shown()).length === 0, `changed after balanced: ${await shown()}`);
    await panel.locator('.differing').click();
  });
}

async function copying(checks, session) {
  const { page } = session;
  await checks.check('the picture is copied to the clipboard as it is shown', async () => {
    await page.context().grantPermissions(['clipboard-read', 'clipboard-write']);
    const sizeShown = () => page.evaluate(() => {
      const canvas = document.querySelector('body > canvas');
      return `${canvas.width} x ${canvas.height}`;
    });
    // While the view comes to rest its pictures grow: then once more.
    let before, copied, shown;
    await until('a picture that stays', 20000, async () => {
      before = await sizeShown();
      await page.evaluate(() => navigator.clipboard.writeText('nothing yet'));
      await page.locator('.dock').getByRole('button', { name: 'Save' }).click();
      await page.getByRole('menuitem', { name: 'Copy' }).click();
      // Not by the line that says so: that of the time before may still stand there.
      await until('a picture in the clipboard', 20000, () => page.evaluate(async () =>
        (await navigator.clipboard.read())[0].types.includes('image/png')));
      await page.getByText('The picture is in the clipboard.').first().waitFor({ timeout: 20_000 });
      copied = await page.evaluate(async () => {
        const [item] = await navigator.clipboard.read();
        const picture = await createImageBitmap(await item.getType('image/png'));
        return `${picture.width} x ${picture.height}`;
      });
      shown = await sizeShown();
      return before === shown;
    });
    expect(copied === shown, `${copied} copied of ${shown}`);
  });
}

async function firstSight(checks) {
  const session = new Session();
  try {
    await checks.check('at 1280 x 720 panels cover at most 30 % at first sight', async () => {
      await session.start({ width: 1280, height: 720 });
      const covered = await session.page.evaluate(() =>
        [...document.querySelectorAll('.panel')]
          .map((panel) => panel.getBoundingClientRect())
          .reduce((sum, { width, height }) => sum + width * height, 0) / (innerWidth * innerHeight));
      expect(covered > 0.05 && covered <= 0.3, `${covered}`);
    });
  } finally {
    await session.stop();
  }
}

async function looks(checks, session) {
  const { page } = session;
  const kinds = ['dark', 'light'].flatMap((theme) => ['no-preference', 'more'].map((contrast) => [theme, contrast]));
  for (const [theme, contrast] of kinds) {
    const name = contrast === 'more' ? 'more' : 'ordinary';
    await checks.check(`every text of ${name} contrast in the ${theme} theme holds 4.5:1, whatever the picture`, async () => {
      await page.emulateMedia({ contrast, colorScheme: theme });
      await page.locator('.dock').getByRole('button', { name: 'Effects' }).click();
      await page.locator('.top-bar').getByRole('button', { name: 'About the scene' }).click();
      await pause(250); // what fades in is there
      const low = await lowContrast(page);
      await page.keyboard.press('Escape');
      await page.locator('.dock').getByRole('button', { name: 'Effects' }).click();
      await page.keyboard.press('h');
      low.push(...(await lowContrast(page)));
      await page.keyboard.press('h');
      await session.screenshot(`${theme}-${name}`);
      await page.emulateMedia({ contrast: 'no-preference', colorScheme: 'dark' });
      expect(low.length === 0, low.join('\n'));
    });
  }
  await checks.check('in forced colours switches, sliders and pressed buttons are seen', async () => {
    await page.emulateMedia({ forcedColors: 'active' });
    const style = (selector, name) =>
      page.locator(selector).first().evaluate((element, key) => getComputedStyle(element)[key], name);
    expect((await style('.switch', 'borderTopStyle')) === 'solid', 'a switch without an edge');
    const on = await style('.switch:checked', 'backgroundColor');
    const off = await style('.switch:not(:checked)', 'backgroundColor');
    expect(on !== off, `on and off are both ${on}`);
    expect((await style('.dock .tool[aria-pressed=true]', 'outlineStyle')) === 'solid', 'pressed is not seen');
    await session.screenshot('forced-colors');
    await page.emulateMedia({ forcedColors: 'none', contrast: 'more' });
    await session.screenshot('more-contrast');
    await page.emulateMedia({ contrast: 'no-preference' });
  });
  for (const [width, height] of [
    [320, 256],
    [320, 180],
    [390, 844],
    [1280, 720],
    [1100, 700],
    [900, 600],
  ]) {
    await checks.check(`${width} x ${height}: every control is named, inside and not covered`, async () => {
      await page.setViewportSize({ width, height });
      await pause(400);
      await session.screenshot(`page-${width}x${height}`);
      expect(await page.locator('.dock').isVisible(), 'no dock');
      const bad = [...(await badControls(page)), ...(await overlaps(page))];
      expect(bad.length === 0, bad.join('\n'));
    });
  }
  await checks.check('the settings are usable at 400 % zoom', async () => {
    await page.setViewportSize({ width: 320, height: 180 });
    await until('sheets', 5000, () => page.locator('#settings-panel').evaluate((panel) => getComputedStyle(panel).left === '8px'));
    await pause(200);
    const dock = page.locator('.dock').getByRole('button', { name: 'Settings' });
    if ((await dock.getAttribute('aria-pressed')) !== 'true') await dock.click();
    await pause(300);
    await session.screenshot('zoom-settings');
    const box = await page.locator('#settings-panel .panel-body').boundingBox();
    expect(box !== null && box.height >= 60, `${box?.height} px of settings`);
    await page.keyboard.press('Escape');
  });
}

/** Runs everything; failures and passes are counted in `checks`. */
export async function panelChecks(checks) {
  const session = new Session();
  try {
    const set = { HELIOGRAPH_FAKE_SET: '{"exposure":0.25}' };
    if (!(await checks.check('the page is ready for panels', () => session.start(DESKTOP, {}, set)))) return;
    await words(checks, session);
    await forecast(checks, session);
    await errorTarget(checks, session);
    await timeBudget(checks, session);
    await errorMap(checks, session);
    await numbers(checks, session);
    await keyboard(checks, session);
    await searching(checks, session);
    await copying(checks, session);
    await looks(checks, session);
    await checks.check('nothing was wrong in the browser\u2019s console (panels)', async () => {
      expect(session.browser.problems.length === 0, session.browser.problems.join('\n'));
    });
  } finally {
    await session.stop();
  }
  await firstSight(checks);
}

if (import.meta.url === pathToFileURL(process.argv[1]).href) {
  const checks = new Checks();
  await panelChecks(checks);
  checks.finish();
}
