// The page in Chromium against the fake server: hybrid settings, partition, timeline. Part
// of client_test.mjs; run alone: node tests/browser/fake_test.mjs. Writes screenshots to out/browser.

import { pathToFileURL } from 'node:url';
import { Session } from './fake_session.mjs';
import { badControls, overlaps } from './look.mjs';
import { Checks, expect, pause, until } from './page.mjs';

const DESKTOP = { width: 1440, height: 900 };
const PHONE = { width: 390, height: 844 };

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

async function deviceStatistics(checks, session) {
  const panel = session.page.locator('#statistics-panel');
  await checks.check(
    'statistics: share of each device, why one is parked, and the scheduler, in hybrid only',
    async () => {
      await session.set('device', 'hybrid');
      await panel.getByText('it would gain 1.2 % of the frame, less than 3 %').waitFor({ timeout: 20_000 });
      const rows = await panel.locator('.stats-section', { hasText: 'Tiles by device' }).locator('.bar-row').all();
      const seen = await Promise.all(
        rows.map(async (row) => {
          const color = await row.locator('.fill').evaluate((bar) => getComputedStyle(bar).backgroundColor);
          return `${await row.locator('.bar-label').textContent()} ${await row.locator('.figure').textContent()} ${color}`;
        }),
      );
      const [embree, first, second] = seen;
      expect(embree === 'embree 34 % rgb(79, 156, 255)', embree);
      expect(first === 'vulkan:0 66 % rgb(255, 106, 61)', first);
      expect(second.startsWith('vulkan:1 parked'), second);
      const facts = await panel.locator('.facts').innerText();
      for (const text of ['Lost at the end', '0.31 ms', 'Deciding', '42 \u00b5s', 'Batches', '37', 'Given out again'])
        expect(facts.includes(text), `${text} is missing in ${facts}`);
      await panel.locator('.panel-body').evaluate((body) => (body.scrollTop = body.scrollHeight));
      await session.screenshot('hybrid-statistics');
      await session.set('device', 'embree');
      await until(
        'the plain figures',
        5000,
        async () => !(await panel.locator('.facts').innerText()).includes('Deciding'),
      );
      await until('one device', 5000, async () => (await panel.getByText('vulkan:1').count()) === 0);
      expect((await panel.getByText('parked').count()) === 0, 'a remark stays');
    },
  );
}

/** Share of pixels (0..1) of the overlay in the colour of Embree, of Vulkan, and untinted; null while it is hidden. */
const tints = (page) =>
  page.evaluate(() => {
    const overlay = document.querySelector('.partition-overlay');
    if (overlay.hidden) return null;
    const copy = document.createElement('canvas');
    [copy.width, copy.height] = [overlay.width, overlay.height];
    const context = copy.getContext('2d', { willReadFrequently: true });
    context.drawImage(overlay, 0, 0);
    const { data } = context.getImageData(0, 0, copy.width, copy.height);
    const found = { embree: 0, vulkan: 0, none: 0, alpha: 0 };
    for (let i = 0; i < data.length; i += 4) {
      if (data[i + 3] === 0) found.none += 4 / data.length;
      else if (Math.abs(data[i + 3] - 89) < 3) {
        found[data[i + 2] > data[i] ? 'embree' : 'vulkan'] += 4 / data.length;
        found.alpha = data[i + 3] / 255;
      }
    }
    return found;
  });

/** What the partition's card says: legend and words of the timeline. */
const card = (page) => page.locator('.partition-card');

async function shownPartition(session) {
  return until('the partition of the picture', 5000, async () => {
    const { partition, lastFrame } = await session.state();
    return partition !== null && partition.frameId === lastFrame?.frameId ? partition : null;
  });
}

async function partitionChecks(checks, session) {
  const { page } = session;
  await checks.check('P shows who made what, exactly over the picture and with its frame', async () => {
    await page.locator('body > canvas').focus();
    await page.keyboard.press('p');
    await shownPartition(session);
    await until('the last picture', 5000, async () => (await session.state()).lastFrame.final);
    expect((await session.state()).settings.showPartition === true, 'the server was not told');
    const found = await tints(page);
    // A disc of radius 0.32 in a unit square, stretched to the picture.
    expect(Math.abs(found.vulkan - Math.PI * 0.32 ** 2) < 0.03, `vulkan covers ${found.vulkan}`);
    expect(found.embree > 0.6 && found.none < 0.01 && found.none > 0, `tints: ${JSON.stringify(found)}`);
    expect(Math.abs(found.alpha - 0.35) < 0.01, `opacity ${found.alpha}`);
    const boxes = await page.evaluate(() =>
      ['body > canvas', '.partition-overlay'].map((name) =>
        JSON.stringify(document.querySelector(name).getBoundingClientRect()),
      ),
    );
    expect(boxes[0] === boxes[1], `picture ${boxes[0]}, overlay ${boxes[1]}`);
  });
  await checks.check('legend, timeline and words for screen readers agree', async () => {
    const legend = await card(page).locator('.legend li').allTextContents();
    expect(/^embree6\d %$/.test(legend[0]) && /^vulkan:03\d %$/.test(legend[1]), legend.join(' | '));
    const rows = page.locator('.timeline-rows');
    const box = await rows.boundingBox();
    await page.mouse.move(box.x + box.width * (1.2 / 12.4), box.y + (box.height * 2.5) / 7);
    const words = await page.locator('.timeline-words').textContent();
    expect(/^embree worker 2: 14 cells, 0\.5\u20132\.5 ms$/.test(words), words);
    await page.mouse.move(box.x + box.width * (12.3 / 12.4), box.y + (box.height * 2.5) / 7);
    const idle = await page.locator('.timeline-words').textContent();
    expect(idle.startsWith('embree worker 2: idle'), idle);
    const label = await rows.getAttribute('aria-label');
    expect(label.includes('12.4 ms') && label.includes('embree: 6') && label.includes('6 workers'), label);
    await page.mouse.move(720, 300);
    await session.screenshot('partition');
  });
  await checks.check('no tint stays over a picture that came without a partition', async () => {
    await session.ask('/control?partition=off');
    await page.keyboard.press('r');
    await until('a picture without', 5000, async () => (await session.state()).partition === null);
    expect((await tints(page)) === null && (await card(page).isHidden()), 'tint or card are still shown');
    await session.ask('/control?partition=on');
    await page.keyboard.press('r');
    await shownPartition(session);
  });
  await checks.check('another scene hides it until its own comes; many workers become one row a device', async () => {
    await page.locator('.picker').click();
    await page.getByRole('menuitemradio', { name: /^Courtyard/ }).click();
    await session.shown('courtyard');
    await shownPartition(session);
    const rows = page.locator('.timeline-rows');
    const box = await rows.boundingBox();
    expect(box.height < 40, `${box.height} px for two devices`);
    await page.mouse.move(box.x + box.width / 2, box.y + 2);
    const words = await page.locator('.timeline-words').textContent();
    expect(/^embree, 48 workers: 134\u202f400 cells, busy \d\d %$/.test(words), words);
    await session.screenshot('partition-many');
  });
  await checks.check('it follows the window, and P hides it', async () => {
    await page.setViewportSize({ width: 1000, height: 700 });
    await until('the tints of the new size', 5000, async () => {
      await shownPartition(session);
      return Math.abs((await tints(page)).vulkan - Math.PI * 0.32 ** 2) < 0.04;
    });
    const covered = await overlaps(page);
    expect(covered.length === 0, covered.join('\n'));
    await session.screenshot('partition-small');
    await page.setViewportSize(DESKTOP);
    await page.locator('body > canvas').focus();
    await page.keyboard.press('p');
    expect((await tints(page)) === null, 'the tint is still shown');
    await until('the echo', 5000, async () => (await session.state()).settings.showPartition === false);
  });
}

async function sizeChecks(checks, session) {
  await checks.check('a picture smaller than asked for is said where the size stands', async () => {
    const size = session.field('resolution').locator('.resolution');
    await session.ask('/control?given=640x400');
    await session.field('resolution').locator('select').selectOption('full');
    const words = 'given 640 \u00d7 400 of 1440 \u00d7 900 px: the server\u2019s memory for pictures is short';
    const read = async () => (await size.textContent()).replace("'", '\u2019');
    await until('the words', 5000, async () => (await read()) === words);
    await session.screenshot('size-given');
    const bad = [...(await badControls(session.page)), ...(await overlaps(session.page))];
    expect(bad.length === 0, bad.join('\n'));
    await session.ask('/control?given=');
    await session.field('resolution').locator('select').selectOption('capped');
    await until('the size alone', 5000, async () => /^\d+ \u00d7 \d+ px$/.test(await read()));
  });
}

async function phoneChecks(checks) {
  const session = new Session();
  try {
    await checks.check('phone: the partition lies above the sheets, a finger reads the timeline', async () => {
      await session.start(PHONE, { hasTouch: true, isMobile: true, deviceScaleFactor: 2 });
      const { page } = session;
      await page.keyboard.press('p');
      await shownPartition(session);
      const box = await page.locator('.timeline-rows').boundingBox();
      await page.touchscreen.tap(box.x + box.width * (1.2 / 12.4), box.y + (box.height * 2.5) / 7);
      const words = await page.locator('.timeline-words').textContent();
      expect(words.startsWith('embree worker 2: 14 cells'), words);
      for (const label of ['Stats', 'Light', 'Settings', 'Effects']) {
        await page.locator('.dock').getByRole('button', { name: label }).tap();
        await pause(300);
        const bad = [...(await badControls(page)), ...(await overlaps(page))];
        expect(bad.length === 0, bad.join('\n'));
        await session.screenshot(`fake-phone-${label.toLowerCase()}`);
      }
    });
    await checks.check('phone: a long press says what is there', async () => {
      await session.ask('/received');
      const canvas = session.page.locator('body > canvas');
      const fire = (type, x) =>
        canvas.evaluate(
          (element, [name, clientX]) => {
            element.setPointerCapture = () => undefined; // synthetic pointers cannot be captured
            const pointer = { pointerId: 1, pointerType: 'touch', isPrimary: true, bubbles: true };
            element.dispatchEvent(new PointerEvent(name, { ...pointer, clientX, clientY: 211 }));
          },
          [type, x],
        );
      await fire('pointerdown', 195);
      await until('the message', 5000, async () => {
        const [pick] = await session.received('pick');
        return pick !== undefined && Math.abs(pick.x - 0.5) < 2e-3 && Math.abs(pick.y - 0.25) < 2e-3;
      });
      await fire('pointerup', 195);
      await session.page.locator('.pick-card', { hasText: 'chair' }).waitFor({ timeout: 20_000 });
      await session.screenshot('phone-pick');
      const bad = await badControls(session.page);
      expect(bad.length === 0, bad.join('\n'));
    });
    await checks.check('nothing was wrong in the browser\u2019s console (phone)', async () => {
      expect(session.browser.problems.length === 0, session.browser.problems.join('\n'));
    });
  } finally {
    await session.stop();
  }
}

/** Runs everything; failures and passes are counted in `checks`. */
export async function fakeChecks(checks) {
  const session = new Session();
  try {
    if (!(await checks.check('the page shows the fake server\u2019s picture', () => session.start(DESKTOP)))) return;
    await hybridSettings(checks, session);
    await partitionChecks(checks, session);
    await deviceStatistics(checks, session);
    await sizeChecks(checks, session);
    await checks.check('nothing was wrong in the browser\u2019s console (fake server)', async () => {
      expect(session.browser.problems.length === 0, session.browser.problems.join('\n'));
    });
  } finally {
    await session.stop();
  }
  await phoneChecks(checks);
}

if (import.meta.url === pathToFileURL(process.argv[1]).href) {
  const checks = new Checks();
  await fakeChecks(checks);
  checks.finish();
}
