// What is under the pointer: the card that says it, measuring, orbiting and focusing, against the fake server. Part of
// client_test.mjs; run alone: node tests/browser/pick_test.mjs.

import { pathToFileURL } from 'node:url';
import { Session } from './fake_session.mjs';
import { badControls } from './look.mjs';
import { Checks, expect, pause, until } from './page.mjs';

const DESKTOP = { width: 1440, height: 900 };
const far = (a, b) => Math.hypot(...a.map((value, i) => value - b[i]));
const card = (session) => session.page.locator('.pick-card');

/** Where the newest mark is; marks are made anew with each frame. */
const mark = (page) =>
  page.evaluate(() => {
    const ring = [...document.querySelectorAll('.pick-marks circle.pick-picked')].at(-1);
    return ['cx', 'cy'].map((name) => Number(ring.getAttribute(name)));
  });

async function says(session, words) {
  await until(`"${words}" in the card`, 5000, async () => {
    return (await card(session).isVisible()) && (await card(session).innerText()).includes(words);
  });
}

async function points(checks, session) {
  const { page } = session;
  await checks.check('a double click says what is there, with a mark at the place, and changes nothing', async () => {
    await session.ask('/received');
    await page.mouse.dblclick(720, 600);
    for (const words of ['chair', 'oak', '4.05 m', 'front (+z)']) await says(session, words);
    const messages = JSON.parse(await session.ask('/received'));
    const [pick, ...others] = messages.filter(({ type }) => type === 'pick' || type === 'settings' || type === 'focus');
    expect(others.length === 0, JSON.stringify(others));
    expect(Math.abs(pick.x - 0.5) < 1e-3 && Math.abs(pick.y - 2 / 3) < 1e-3, `${pick.x} ${pick.y}`);
    const at = await mark(page);
    expect(far(at, [720, 600]) < 2, at.join());
    await session.screenshot('pick');
    const bad = await badControls(page);
    expect(bad.length === 0, bad.join('\n'));
  });
  await checks.check('two points are measured', async () => {
    await page.getByRole('button', { name: 'Measure from here' }).click();
    await says(session, 'second point');
    await page.mouse.dblclick(1060, 560);
    await says(session, 'Between both points');
    const [a, b] = await page.evaluate(() => [...document.querySelectorAll('.pick-marks circle')].map((c) => c.getAttribute('cx')));
    expect(a !== undefined && b !== undefined, 'no two marks');
    expect((await page.locator('.pick-line').count()) === 1, 'no line between them');
    await says(session, 'plaster');
    await session.screenshot('measured');
  });
  await checks.check('a place in the sky says that nothing is there', async () => {
    await page.mouse.dblclick(720, 40);
    await says(session, 'Nothing is there');
    expect((await page.locator('.toast.error').count()) === 0, 'an error is shown');
    expect((await page.getByRole('button', { name: 'Orbit here' }).count()) === 0, 'what is nowhere is orbited');
  });
  await checks.check('Escape closes the card and gives the keys back to the picture', async () => {
    await card(session).getByRole('button', { name: 'Close' }).focus();
    await page.keyboard.press('Escape');
    expect(await card(session).isHidden(), 'the card stays');
    expect((await page.evaluate(() => document.activeElement.tagName)) === 'CANVAS', 'the focus is elsewhere');
    expect((await page.locator('.pick-marks circle').count()) === 0, 'marks stay');
  });
}

async function acts(checks, session) {
  const { page } = session;
  await checks.check('I asks for the middle of the picture, and the card has the focus', async () => {
    await page.locator('body > canvas').focus();
    await page.keyboard.press('i');
    await says(session, 'chair');
    const name = await page.evaluate(() => document.activeElement.textContent);
    expect(name === 'Orbit here', `the focus is at ${name}`);
  });
  await checks.check('focusing is an act of its own, marked, and taken back by Control Z', async () => {
    const before = (await session.state()).settings.focusDistance;
    await page.getByRole('button', { name: 'Focus here' }).click();
    await until('the focus', 5000, async () => Math.abs((await session.state()).settings.focusDistance - 4) < 1e-3);
    await says(session, 'is here');
    expect((await page.locator('.pick-marks path').count()) === 1, 'the focus has no mark');
    await page.keyboard.press('Control+z');
    await until('the focus of before', 5000, async () => (await session.state()).settings.focusDistance === before);
  });
  await checks.check('orbiting turns about the picked point, which stays in the middle', async () => {
    await page.mouse.dblclick(1060, 300);
    await says(session, 'plaster');
    await page.getByRole('button', { name: 'Orbit here' }).click();
    await pause(300);
    const middle = async () => far(await mark(page), [720, 450]);
    expect((await middle()) < 2, `${await middle()} px from the middle`);
    const before = (await session.state()).camera.position;
    await page.mouse.move(500, 700);
    await page.mouse.down();
    await page.mouse.move(620, 730, { steps: 6 });
    await page.mouse.up();
    expect(far((await session.state()).camera.position, before) > 0.1, 'the camera did not move');
    expect((await middle()) < 2, `${await middle()} px from the middle after a drag`);
  });
  await checks.check('another scene forgets what was picked', async () => {
    await page.locator('.picker').click();
    await page.getByRole('menuitemradio', { name: /^Courtyard/ }).click();
    await session.shown('courtyard');
    expect(await card(session).isHidden(), 'the card stays');
  });
}

/** A server without a lens offers no focus. */
async function withoutLens(checks) {
  const session = new Session();
  try {
    await checks.check('without a setting for it, no focus is offered', async () => {
      await session.start(DESKTOP, {}, { HELIOGRAPH_FAKE_OMIT: 'focusDistance,aperture' });
      await session.page.mouse.dblclick(720, 450);
      await says(session, 'chair');
      expect((await session.page.getByRole('button', { name: 'Focus here' }).count()) === 0, 'it is offered');
    });
  } finally {
    await session.stop();
  }
}

/** Runs everything; failures and passes are counted in `checks`. */
export async function pickChecks(checks) {
  const session = new Session();
  try {
    if (!(await checks.check('the page is ready for picking', () => session.start(DESKTOP)))) return;
    await points(checks, session);
    await acts(checks, session);
    await checks.check('nothing was wrong in the browser\u2019s console (picking)', async () => {
      expect(session.browser.problems.length === 0, session.browser.problems.join('\n'));
    });
  } finally {
    await session.stop();
  }
  await withoutLens(checks);
}

if (import.meta.url === pathToFileURL(process.argv[1]).href) {
  const checks = new Checks();
  await pickChecks(checks);
  checks.finish();
}
