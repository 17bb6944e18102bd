// The panel Light against the fake server: by mouse, keyboard and finger, in small windows and in colours of the viewer's
// own. Part of client_test.mjs; run alone: node tests/browser/light_test.mjs.

import { pathToFileURL } from 'node:url';
import { Session } from './fake_session.mjs';
import { badControls, overlaps } from './look.mjs';
import { Checks, expect, pause, unfoldFor, until } from './page.mjs';

const DESKTOP = { width: 1440, height: 900 };
const SUN_ROWS = ['sunAzimuth', 'sunElevation', 'sunSize', 'sunStrength'];
const ROWS = [
  ...['surroundings', 'environmentRotation', 'environmentStrength', 'sun', ...SUN_ROWS],
  ...['ground', 'background', 'exposure', 'autoExposure', 'toneCurve'],
];

const setting = async (session, name) => (await session.state()).settings[name];
const becomes = (session, name, value) =>
  until(`${name} ${value}`, 5000, async () => (await setting(session, name)) === value);
const dial = (session) => session.field('environmentRotation').getByRole('slider');

async function rows(checks, session) {
  const { page } = session;
  await checks.check('Light has every control of the light, each with its reset, and Settings has none of them', async () => {
    await unfoldFor(page, 'exposure');
    const shown = await page
      .locator('#light-panel [data-setting]')
      .evaluateAll((fields) => fields.map((field) => field.dataset.setting));
    expect(shown.join() === ROWS.join(), `shown: ${shown}`);
    for (const name of ROWS) expect((await session.field(name).count()) === 1, `${name} stands twice`);
    for (const name of ROWS) expect((await session.field(name).locator('.reset').count()) === 1, `no reset of ${name}`);
    await session.screenshot('light');
  });
  await checks.check('a search in the settings leads to the light', async () => {
    const panel = page.locator('#settings-panel');
    await panel.getByRole('searchbox').fill('tone curve');
    await panel.getByRole('button', { name: 'Tone curve: in the panel Light' }).click();
    const at = await page.evaluate(() => document.activeElement.closest('[data-setting]')?.dataset.setting);
    expect(at === 'toneCurve', `the focus is at ${at}`);
    await panel.getByRole('searchbox').fill('');
  });
}

async function searchOfFolded(checks, session) {
  const { page } = session;
  await checks.check('a search for what belongs to the sun leads to its switch while it is off', async () => {
    const panel = page.locator('#settings-panel');
    await panel.getByRole('searchbox').fill('sun height');
    await panel.getByRole('button', { name: 'Sun height: in the panel Light' }).click();
    const at = () => page.evaluate(() => document.activeElement.closest('[data-setting]')?.dataset.setting);
    expect((await at()) === 'sun', `the focus is at ${await at()}`);
    await panel.getByRole('searchbox').fill('');
  });
}

async function choices(checks, session) {
  const { page } = session;
  await checks.check('surroundings are chosen by a click on their picture, and the keys fly again', async () => {
    await session.field('surroundings').locator('.tile', { hasText: 'sky' }).click();
    await becomes(session, 'surroundings', 'sky');
    const focused = await page.evaluate(() => document.activeElement.tagName);
    expect(focused === 'CANVAS', `${focused} has the focus`);
  });
  await checks.check('arrows choose a tone curve, the reset brings the default back', async () => {
    await session.field('toneCurve').getByRole('radio', { checked: true }).focus();
    await page.keyboard.press('ArrowRight');
    await becomes(session, 'toneCurve', 'neutral');
    await page.keyboard.press('w'); // flies; the choice stays
    await session.field('toneCurve').locator('.reset').focus();
    await page.keyboard.press('Enter');
    await becomes(session, 'toneCurve', 'automatic');
    const value = await page.evaluate(() => document.activeElement.value);
    expect(value === 'automatic', `the focus is at ${value}`);
  });
  await checks.check('the automatic exposure says what it has chosen', async () => {
    const note = session.field('autoExposure').locator('.field-note');
    expect((await note.textContent()) === 'Not used in this view.', await note.textContent());
    await session.field('autoExposure').locator('.tile', { hasText: 'on' }).first().click();
    await until('its value', 5000, async () => (await note.textContent()).startsWith('Now +1.3 EV'));
    await session.field('autoExposure').locator('.tile', { hasText: 'off' }).click();
    await until('no word', 5000, () => note.isHidden());
  });
  await checks.check('where nothing stands around there is nothing to turn, and it is said', async () => {
    const note = session.field('environmentRotation').locator('.field-note');
    expect(await note.isHidden(), 'a note under the sky');
    await session.field('surroundings').locator('.tile', { hasText: 'none' }).click();
    await note.waitFor({ timeout: 20_000 });
    await session.field('surroundings').locator('.reset').click();
    await becomes(session, 'surroundings', 'automatic');
  });
}

async function numbers(checks, session) {
  const { page } = session;
  await checks.check('the dial is dragged around, and turned by the keys', async () => {
    await dial(session).scrollIntoViewIfNeeded();
    const box = await dial(session).boundingBox();
    const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
    await page.mouse.move(x, y - 24);
    await page.mouse.down();
    await page.mouse.move(x + 24, y, { steps: 4 });
    await becomes(session, 'environmentRotation', 90);
    await page.mouse.move(x - 1, y + 30, { steps: 6 }); // past the lowest point
    await until('the other side', 5000, async () => (await setting(session, 'environmentRotation')) < -170);
    await page.mouse.up();
    await dial(session).focus();
    const before = await setting(session, 'environmentRotation');
    await page.keyboard.press('ArrowRight');
    await becomes(session, 'environmentRotation', before + 1);
    await page.keyboard.press('PageUp');
    await becomes(session, 'environmentRotation', before + 16);
    const { forward } = (await session.state()).camera;
    expect(Math.abs(forward[0] + 0.0755) < 1e-3, 'the arrows turned the view');
    expect((await dial(session).getAttribute('aria-valuetext')) === `${before + 16} degrees`, 'not said');
  });
  await checks.check('the strength moves by equal factors: the default is in the middle', async () => {
    const slider = session.field('environmentStrength').locator('input[type=range]');
    expect(Math.abs(Number(await slider.inputValue()) - 500) < 1, `at ${await slider.inputValue()}`);
    await slider.scrollIntoViewIfNeeded();
    const box = await slider.boundingBox();
    await page.mouse.click(box.x + 8 + 0.75 * (box.width - 16), box.y + box.height / 2);
    await until('ten times as strong', 5000, async () => Math.abs((await setting(session, 'environmentStrength')) - 10) < 1.5);
  });
  await checks.check('one button takes the light back, and Control Z that', async () => {
    await page.getByRole('button', { name: 'Reset the light' }).click();
    await becomes(session, 'environmentStrength', 1);
    await becomes(session, 'environmentRotation', 0);
    await becomes(session, 'autoExposure', 'automatic');
    expect(await page.getByRole('button', { name: 'Reset the light' }).isDisabled(), 'still something to reset');
    await page.keyboard.press('Control+z');
    await until('as before', 5000, async () => (await setting(session, 'environmentStrength')) > 8);
    await page.getByRole('button', { name: 'Reset the light' }).click();
    await becomes(session, 'environmentStrength', 1);
  });
}

async function sun(checks, session) {
  const { page } = session;
  const folded = async () =>
    (await Promise.all(SUN_ROWS.map((name) => session.field(name).isHidden()))).every((hidden) => hidden);
  await checks.check('the rows of the sun stay folded until it shines, and it is turned by its dial and with the rest', async () => {
    expect(await folded(), 'rows of a sun that is off');
    await session.field('sun').getByRole('switch').focus();
    await page.keyboard.press('Space');
    await becomes(session, 'sun', true);
    await until('its rows', 5000, async () => !(await folded()));
    const hand = session.field('sunAzimuth').getByRole('slider');
    await hand.focus();
    await page.keyboard.press('PageUp');
    await becomes(session, 'sunAzimuth', 50);
    await hand.scrollIntoViewIfNeeded();
    const box = await hand.boundingBox();
    await page.mouse.click(box.x + box.width / 2 + 16, box.y + box.height / 2 + 16); // to the right and to the viewer
    await becomes(session, 'sunAzimuth', 45);
    await hand.focus();
    await page.keyboard.press('ArrowRight');
    await becomes(session, 'sunAzimuth', 46);
    await session.field('sunElevation').locator('input[type=range]').focus();
    await page.keyboard.press('PageDown');
    await becomes(session, 'sunElevation', 30);
    const bad = await badControls(page);
    expect(bad.length === 0, bad.join('\n'));
    await session.screenshot('light-sun');
    await page.locator('body > canvas').focus();
    await page.keyboard.press('BracketRight');
    await becomes(session, 'environmentRotation', 15);
    await becomes(session, 'sunAzimuth', 61);
    await page.getByRole('button', { name: 'Reset the light' }).click();
    await becomes(session, 'sun', false);
    await until('the rows to fold', 5000, folded);
  });
}

async function gesture(checks, session) {
  const { page } = session;
  const drag = async (key, button = 'left') => {
    if (key !== '') await page.keyboard.down(key);
    await page.mouse.move(600, 450);
    await page.mouse.down({ button });
    await page.mouse.move(700, 450, { steps: 5 });
    await page.mouse.up({ button });
    if (key !== '') await page.keyboard.up(key);
    await pause(100);
  };
  const look = async () => JSON.stringify((await session.state()).camera);
  await checks.check('Alt drag turns the surroundings and not the view', async () => {
    const before = await look();
    await drag('Alt');
    await becomes(session, 'environmentRotation', 20); // 100 of 900 pixels, half a turn for all
    expect((await look()) === before, 'the view moved');
    expect((await dial(session).getAttribute('aria-valuenow')) === '20', 'the dial stands still');
  });
  await checks.check('other drags turn and pan as before', async () => {
    for (const [key, button] of [['', 'left'], ['Shift', 'left'], ['', 'right'], ['Alt', 'right']]) {
      const before = await look();
      await drag(key, button);
      await until(`a view after ${key} ${button}`, 3000, async () => (await look()) !== before);
    }
    expect((await setting(session, 'environmentRotation')) === 20, 'the surroundings turned too');
  });
  await checks.check('[ and ] turn by 15 degrees', async () => {
    await page.keyboard.press('BracketRight');
    await becomes(session, 'environmentRotation', 35);
    await page.keyboard.press('BracketLeft');
    await page.keyboard.press('BracketLeft');
    await becomes(session, 'environmentRotation', 5);
  });
  await checks.check('where turning changes nothing it is said', async () => {
    await session.field('surroundings').locator('.tile', { hasText: 'grey' }).click();
    await becomes(session, 'surroundings', 'grey');
    await drag('Alt');
    await page.locator('.toast', { hasText: 'Even light is the same from all sides.' }).waitFor({ timeout: 20_000 });
    expect((await page.locator('.toast', { hasText: 'Even light' }).count()) === 1, 'said more than once');
    expect((await setting(session, 'environmentRotation')) === 5, 'it turned');
    await page.getByRole('button', { name: 'Reset the light' }).click();
    await becomes(session, 'surroundings', 'automatic');
  });
  await checks.check('the help names the gesture', async () => {
    await page.keyboard.press('h');
    const text = await page.locator('dialog.help').innerText();
    expect(/Alt drag\s+turn the surroundings/.test(text), text);
    await page.keyboard.press('h');
  });
}

async function looks(checks, session) {
  const { page } = session;
  await checks.check('in forced colours the choice that is made is seen', async () => {
    await page.emulateMedia({ forcedColors: 'active' });
    const outline = (selector) =>
      page.locator(selector).first().evaluate((tile) => getComputedStyle(tile).outlineStyle);
    expect((await outline('.tile:has(:checked)')) === 'solid', 'the choice is not seen');
    expect((await outline('.tile:not(:has(:checked))')) === 'none', 'every tile looks chosen');
    await session.screenshot('light-forced-colors');
    await page.emulateMedia({ forcedColors: 'none' });
  });
  for (const [width, height] of [
    [320, 256],
    [390, 844],
    [844, 390],
    [1280, 720],
  ]) {
    await checks.check(`${width} x ${height}: every control of the light is named, inside and not covered`, async () => {
      await page.setViewportSize({ width, height });
      await pause(300);
      const button = page.locator('.dock').getByRole('button', { name: 'Light' });
      if ((await button.getAttribute('aria-pressed')) !== 'true') await button.click();
      await pause(200);
      await session.screenshot(`light-${width}x${height}`);
      const bad = [...(await badControls(page)), ...(height > 300 ? await overlaps(page) : [])]; // lower, a sheet covers the top bar
      expect(bad.length === 0, bad.join('\n'));
      const wide = await page.evaluate(() =>
        [...document.querySelectorAll('#light-panel .tile-label, #light-panel .tile-word')]
          .filter((text) => text.scrollWidth > text.closest('.tile').clientWidth)
          .map((text) => text.textContent));
      expect(wide.length === 0, `wider than their tiles: ${wide}`);
    });
  }
  await checks.check('a finger turns the dial, and the panel does not scroll away under it', async () => {
    await page.setViewportSize({ width: 390, height: 844 });
    await pause(300);
    await dial(session).scrollIntoViewIfNeeded();
    const action = await dial(session).evaluate((element) => getComputedStyle(element).touchAction);
    expect(action === 'none', `touch-action ${action}`);
  });
}

/** A server that lacks some of them, and one without any. */
async function fewer(checks) {
  const session = new Session();
  try {
    await checks.check('what the server does not offer is not there', async () => {
      await session.start(DESKTOP, {}, { HELIOGRAPH_FAKE_OMIT: 'background,toneCurve' });
      const shown = await session.page
        .locator('#light-panel [data-setting]')
        .evaluateAll((fields) => fields.map((field) => field.dataset.setting));
      expect(shown.join() === ROWS.filter((name) => name !== 'background' && name !== 'toneCurve').join(), `${shown}`);
    });
  } finally {
    await session.stop();
  }
}

/** Runs everything; failures and passes are counted in `checks`. */
export async function lightChecks(checks) {
  const session = new Session();
  try {
    if (!(await checks.check('the page is ready for light', () => session.start(DESKTOP)))) return;
    await rows(checks, session);
    await searchOfFolded(checks, session);
    await choices(checks, session);
    await numbers(checks, session);
    await sun(checks, session);
    await gesture(checks, session);
    await looks(checks, session);
    await checks.check('nothing was wrong in the browser\u2019s console (light)', async () => {
      expect(session.browser.problems.length === 0, session.browser.problems.join('\n'));
    });
  } finally {
    await session.stop();
  }
  await fewer(checks);
}

if (import.meta.url === pathToFileURL(process.argv[1]).href) {
  const checks = new Checks();
  await lightChecks(checks);
  checks.finish();
}
