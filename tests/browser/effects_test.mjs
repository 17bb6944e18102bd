// The effects panel against the fake server: what a scene calls for and why, every setting of an effect in one place, what
// leads there, and what each effect costs. Part of client_test.mjs; run alone: node tests/browser/effects_test.mjs.

import { pathToFileURL } from 'node:url';
import { schema } from './fake_data.mjs';
import { Session } from './fake_session.mjs';
import { badControls, lowContrast, overlaps } from './look.mjs';
import { Checks, expect, unfoldFor, until } from './page.mjs';

const DESKTOP = { width: 1440, height: 900 };
const OF_EFFECTS = schema([]).filter(({ effect }) => effect !== '' && !['sun', 'ground'].includes(effect));

const parts = (session) => {
  const panel = session.page.locator('#effects-panel');
  return { panel, effect: (name) => panel.locator(`[data-effect="${name}"]`) };
};
const dock = (session, label) => session.page.locator('.dock').getByRole('button', { name: label });
const focusedSetting = (page) => page.evaluate(() => document.activeElement.closest('[data-setting]')?.dataset.setting);
const folded = (session, name) => parts(session).effect(name).locator('.effect-settings > summary').textContent();

async function reasons(checks, session) {
  const { page } = session;
  const { panel, effect } = parts(session);
  await checks.check('effects: what the scene calls for comes first, with reasons and rays', async () => {
    await dock(session, 'Effects').click();
    await until('effects in the panel', 5000, async () => (await panel.locator('.effect').count()) > 0);
    const names = await panel.locator('.effect').evaluateAll((rows) => rows.map((row) => row.dataset.effect));
    const at = (name) => names.indexOf(name);
    expect(at('shadows') === 0 && at('fog') > at('emission') && at('refractions') > at('fog'), names.join(', '));
    const idle = await panel.locator('.idle-effects [data-effect]').evaluateAll((rows) => rows.map((row) => row.dataset.effect));
    expect(idle.includes('refractions') && !idle.includes('fog') && !idle.includes('shadows'), `folded away: ${idle}`);
    expect(!(await effect('refractions').isVisible()), 'what is of no use is not folded');
    const state = await effect('refractions').locator('.effect-state').textContent();
    expect(state === 'off: no transmissive material', state);
    const figures = () => effect('shadows').locator('.effect-figures').textContent();
    await until('rays beside the effects', 20_000, async () => (await figures()) !== ''); // the first statistics
    expect((await figures()) === '2.31 M rays', await figures());
    expect(await effect('textures').locator('.effect-figures').isHidden(), 'a figure at textures');
    expect((await effect('textures').locator('input').count()) === 0, 'a switch at textures');
    const moving = await effect('animation').locator('.effect-state').textContent();
    expect(moving.startsWith('not simulated: 2 animations'), `animation: ${moving}`);
    const covered = [...(await badControls(page)), ...(await overlaps(page))];
    expect(covered.length === 0, covered.join('\n'));
  });
}

async function onePlace(checks, session) {
  const { page } = session;
  const { panel, effect } = parts(session);
  await checks.check('every setting of an effect stands once, under its effect, and Settings has none of them', async () => {
    const wrong = [];
    for (const { name, effect: owner } of OF_EFFECTS) {
      const all = await session.field(name).count();
      const here = await effect(owner).locator(`[data-setting="${name}"]`).count();
      if (all !== 1 || here !== 1) wrong.push(`${name}: ${all} times, ${here} under ${owner}`);
      else if ((await session.field(name).locator('.reset').count()) !== 1) wrong.push(`${name}: no reset`);
    }
    expect(wrong.length === 0 && OF_EFFECTS.length > 30, wrong.join('\n'));
    const titles = await page.locator('#settings-panel summary').allTextContents();
    expect(!titles.includes('Effects'), `groups of Settings: ${titles}`);
  });
  await checks.check('a switch that several effects share stands at its own, the others say with which', async () => {
    const switches = await panel.locator('[role=switch]').count();
    const own = OF_EFFECTS.filter(({ type }) => type === 'bool').length;
    expect(switches === own, `${switches} switches of ${own} settings`);
    const shared = effect('transparentShadows');
    expect((await shared.locator('input').count()) === 0, 'a second switch of the shadows');
    expect((await shared.evaluate((row) => row.textContent)).includes('with Shadows'), 'it does not say with which');
  });
  await checks.check('sun and ground are led to, where they stand in the panel Light', async () => {
    for (const [name, label] of [['sun', 'Sun'], ['ground', 'Ground']]) {
      await effect(name).getByRole('button', { name: `${label}: in the panel Light` }).click();
      expect((await focusedSetting(page)) === name, `the focus is at ${await focusedSetting(page)}`);
      expect((await session.field(name).count()) === 1, `${name} stands twice`);
      await dock(session, 'Light').click();
    }
  });
}

async function switching(checks, session) {
  const { page } = session;
  const { effect } = parts(session);
  await checks.check('an effect is switched in its line, and says that the scene calls for it', async () => {
    const input = session.field('reflections').locator('input[role=switch]');
    await input.focus();
    await page.keyboard.press('Space');
    await until('the echo', 5000, async () => (await session.state()).settings.reflections === false);
    const state = await effect('reflections').locator('.effect-state').textContent();
    expect(state.startsWith('switched off, the scene calls for it'), state);
    const described = (await input.getAttribute('aria-describedby')).split(' ');
    const id = await effect('reflections').locator('.effect-state').getAttribute('id');
    expect(described.includes(id), 'the switch is not described by the reason');
    await session.set('reflections', true);
    expect(await input.isChecked(), 'the switch does not follow');
  });
  await checks.check('what allows an effect by a choice is chosen in its line', async () => {
    await session.set('integrator', 'path');
    const state = await effect('path').locator('.effect-state').textContent();
    expect(state === 'on: you chose it', state);
    await session.set('integrator', 'interactive');
  });
  await checks.check('settings are folded under their effect, are set there, and stay unfolded', async () => {
    const field = session.field('shadowSamples').locator('.number-field');
    expect(!(await field.isVisible()), 'not folded');
    expect((await folded(session, 'softShadows')) === '1 setting of Soft shadows', await folded(session, 'softShadows'));
    await effect('softShadows').locator('.effect-settings > summary').focus();
    await page.keyboard.press('Enter');
    await field.fill('9');
    await field.press('Enter');
    await until('the echo', 5000, async () => (await session.state()).settings.shadowSamples === 9);
    expect((await folded(session, 'softShadows')).startsWith('1 setting, 1 changed'), await folded(session, 'softShadows'));
    expect(await field.isVisible(), 'folded again');
    await session.field('shadowSamples').locator('.reset').click();
    await until('the default', 5000, async () => (await session.state()).settings.shadowSamples === 4);
    expect((await folded(session, 'softShadows')).startsWith('1 setting of'), await folded(session, 'softShadows'));
  });
}

async function leading(checks, session) {
  const { page } = session;
  const panel = page.locator('#settings-panel');
  const search = panel.getByRole('searchbox');
  for (const [words, label, name] of [
    ['fog density', 'Fog density', 'fogDensity'], // folded under its effect
    ['max refractions', 'Max refractions', 'maxRefractions'], // and that one among what is of no use
    ['texture filter', 'Texture filter', 'textureFilter'], // a line of its own
  ]) {
    await checks.check(`a search for ${words} leads to its place in the effects panel`, async () => {
      if (await parts(session).panel.evaluate((element) => !element.classList.contains('folded'))) await dock(session, 'Effects').click();
      await search.fill(words);
      await panel.getByRole('button', { name: `${label}: in the panel Effects` }).click();
      expect((await focusedSetting(page)) === name, `the focus is at ${await focusedSetting(page)}`);
      expect(await session.field(name).isVisible(), 'it is not seen');
      await search.fill('');
    });
  }
  await checks.check('what a preset changed of the effects is told, led to, reset and taken back', async () => {
    const glossy = async (value) => until(`glossy ${value}`, 5000, async () => (await session.state()).settings.glossyReflections === value);
    await panel.getByLabel('Preset').selectOption('exact');
    await glossy(true);
    await panel.locator('.differing').click();
    await panel.getByRole('button', { name: 'Glossy reflections: in the panel Effects' }).click();
    expect((await focusedSetting(page)) === 'glossyReflections', `the focus is at ${await focusedSetting(page)}`);
    await panel.locator('.differing').click();
    await panel.getByRole('button', { name: 'Reset to defaults' }).click();
    await glossy(false);
    await page.keyboard.press('Control+z');
    await glossy(true);
    await panel.getByLabel('Preset').selectOption('balanced');
    await glossy(false);
  });
}

async function costs(checks, session) {
  const { page } = session;
  const { panel, effect } = parts(session);
  await checks.check('effects: costs are measured on demand', async () => {
    const button = panel.locator('.measure');
    await session.ask('/received');
    await session.ask('/control?costs=hold');
    await button.click();
    await panel.getByText('Measuring … 50 %').waitFor({ timeout: 20_000 });
    expect((await session.received('effectCosts')).length === 1, 'the server was not asked once');
    expect(await button.isDisabled(), 'the button can be pressed again');
    await session.ask('/control?costs=ready');
    await panel.getByText('Measured on embree at 320 × 180 pixels').waitFor({ timeout: 20_000 });
    const figures = await effect('shadows').locator('.effect-figures').textContent();
    expect(figures === '2.31 M rays · costs 4 to 7 ms', figures);
    await panel.locator('.panel-body').evaluate((body) => (body.scrollTop = 0));
    await session.screenshot('effects');
    await session.ask('/control?costs=error');
    await button.click();
    await panel.getByText('effectCosts: the device is busy, try again').waitFor({ timeout: 20_000 });
    expect(await button.isEnabled(), 'the button stays disabled');
    expect((await page.locator('.toast.error').count()) === 0, 'the refusal is told twice');
    await session.ask('/control?costs=ready');
  });
  await checks.check('effects: another scene has its own costs', async () => {
    await panel.locator('.measure').click();
    await panel.getByText('Measured on embree').waitFor({ timeout: 20_000 });
    await page.locator('.picker').click();
    await page.getByRole('menuitemradio', { name: /^Courtyard/ }).click();
    await session.shown('courtyard');
    const figures = await effect('shadows').locator('.effect-figures').textContent();
    expect(!figures.includes('costs'), figures);
  });
}

async function anotherScene(checks, session) {
  const { page } = session;
  const { effect } = parts(session);
  await checks.check('a scene that calls for other effects keeps what is unfolded, and the focus', async () => {
    await unfoldFor(page, 'shadowSamples');
    await session.field('shadowSamples').locator('.number-field').focus();
    await session.ask('/control?idle=reflections');
    await page.evaluate(() => (location.hash = '#scene=courtyard'));
    await session.shown('courtyard');
    await until('reflections of no use', 5000, () => effect('reflections').evaluate((row) => row.closest('.idle-effects') !== null));
    expect((await focusedSetting(page)) === 'shadowSamples', `the focus is at ${await focusedSetting(page)}`);
    expect(await session.field('shadowSamples').isVisible(), 'it is folded again');
    expect(!(await effect('reflections').isVisible()), 'what is of no use is unfolded');
    await session.ask('/control?idle=');
    await page.evaluate(() => (location.hash = '#scene=cornell'));
    await session.shown('cornell');
    await until('reflections of use', 5000, () => effect('reflections').isVisible());
    expect((await focusedSetting(page)) === 'shadowSamples', `the focus is at ${await focusedSetting(page)}`);
  });
}

async function unfolded(checks, session) {
  const { page } = session;
  for (const [width, height] of [[1440, 900], [390, 844]]) {
    await checks.check(`${width} x ${height}: with all of it unfolded every control is named, inside and to be read`, async () => {
      await page.setViewportSize({ width, height });
      await unfoldFor(page, 'fogDensity');
      await page.evaluate(() => document.querySelectorAll('#effects-panel details').forEach((fold) => (fold.open = true)));
      await until('sheet or panel', 5000, () => session.field('maxRefractions').isVisible());
      await session.screenshot(`effects-unfolded-${width}`);
      const bad = [...(await badControls(page)), ...(await overlaps(page)), ...(await lowContrast(page))];
      expect(bad.length === 0, bad.join('\n'));
    });
  }
}

/** Runs everything; failures and passes are counted in `checks`. */
export async function effectChecks(checks) {
  const session = new Session();
  try {
    if (!(await checks.check('the page is ready for effects', () => session.start(DESKTOP)))) return;
    await reasons(checks, session);
    await onePlace(checks, session);
    await switching(checks, session);
    await anotherScene(checks, session);
    await leading(checks, session);
    await costs(checks, session);
    await unfolded(checks, session);
    await checks.check('nothing was wrong in the browser\u2019s console (effects)', async () => {
      expect(session.browser.problems.length === 0, session.browser.problems.join('\n'));
    });
  } finally {
    await session.stop();
  }
}

if (import.meta.url === pathToFileURL(process.argv[1]).href) {
  const checks = new Checks();
  await effectChecks(checks);
  checks.finish();
}
