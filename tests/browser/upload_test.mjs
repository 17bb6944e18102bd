// Own files, dropped on the page of a real server: a model, surroundings, and what is refused. Part of client_test.mjs; run
// alone: node tests/browser/upload_test.mjs. Writes screenshots to out/browser.

import { mkdirSync, mkdtempSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { deflateRawSync } from 'node:zlib';
import { Browser, Checks, expect, freePort, outFolder, Server, until } from './page.mjs';

const DESKTOP = { width: 1100, height: 700 };
const MODEL = {
  'model/red.obj': 'mtllib red.mtl\no triangle\nv -1 -1 0\nv 1 -1 0\nv 0 1 0\nusemtl red\nf 1 2 3\n',
  'model/red.mtl': 'newmtl red\nKd 0.9 0.1 0.1\n',
};

/** A picture of 2 x 1 pixels in the format of Radiance. */
const SKY = '#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n\x80\x80\x80\x80\x40\x40\x80\x80';

/** A zip archive of these, deflated, as a string of bytes. `says`: the bytes of a file that its row tells, if not the truth. */
function zipped(files, says) {
  const parts = [];
  const rows = [];
  for (const [path, text] of Object.entries(files)) {
    const content = Buffer.from(text, 'latin1');
    const packed = deflateRawSync(content);
    const row = Buffer.alloc(46);
    row.writeUInt32LE(0x02014b50, 0);
    row.writeUInt16LE(8, 10);
    row.writeUInt32LE(crc32(content), 16);
    row.writeUInt32LE(packed.length, 20);
    row.writeUInt32LE(says ?? content.length, 24);
    row.writeUInt16LE(path.length, 28);
    row.writeUInt32LE(Buffer.concat(parts).length, 42);
    const head = Buffer.alloc(30);
    head.writeUInt32LE(0x04034b50, 0);
    head.writeUInt16LE(path.length, 26);
    parts.push(head, Buffer.from(path), packed);
    rows.push(row, Buffer.from(path));
  }
  const end = Buffer.alloc(22);
  end.writeUInt32LE(0x06054b50, 0);
  end.writeUInt16LE(rows.length / 2, 10);
  end.writeUInt32LE(Buffer.concat(rows).length, 12);
  end.writeUInt32LE(Buffer.concat(parts).length, 16);
  return Buffer.concat([...parts, ...rows, end]).toString('latin1');
}

/** Bit by bit, apart from the page's own. */
function crc32(bytes) {
  let crc = 0xffffffff;
  for (const byte of bytes) {
    crc ^= byte;
    for (let bit = 0; bit < 8; bit++) crc = crc & 1 ? (crc >>> 1) ^ 0xedb88320 : crc >>> 1;
  }
  return ~crc >>> 0;
}

const state = (page) => page.evaluate(() => window.heliograph.state);

/** Drops files, by name and content, as a person would. */
const drop = (page, files) =>
  page.evaluate((list) => {
    const transfer = new DataTransfer();
    for (const [path, text] of Object.entries(list)) {
      const bytes = Uint8Array.from(text, (letter) => letter.charCodeAt(0));
      transfer.items.add(new File([bytes], path.split('/').pop()));
    }
    window.dispatchEvent(new DragEvent('dragover', { dataTransfer: transfer, cancelable: true }));
    window.dispatchEvent(new DragEvent('drop', { dataTransfer: transfer, cancelable: true }));
  }, files);

const ready = (page, pattern) =>
  until(`a scene like ${pattern}`, 60_000, async () => {
    const { scene, lastFrame, lastInputId } = await state(page);
    return scene?.state === 'ready' && pattern.test(scene.name) && lastFrame?.inputId === lastInputId;
  });

async function brings(checks, page, folder, address) {
  await checks.check('a dropped model is uploaded and shown, with what belongs to it', async () => {
    await drop(page, MODEL);
    await ready(page, /^upload\/[0-9a-f]{32}\/red\.obj$/);
    expect((await page.locator('.picker-label').textContent()) === 'Red.obj', await page.locator('.picker-label').textContent());
    expect((await page.locator('.toast.error').count()) === 0, await page.locator('.toasts').innerText());
    expect(readdirSync(folder).length === 1, readdirSync(folder).join());
    await page.screenshot({ path: join(outFolder, 'own-model.png') });
  });
  await checks.check('who has its link sees it, too; nobody else is told of it', async () => {
    const name = (await state(page)).scene.name;
    const other = new Browser();
    try {
      const there = await other.start(DESKTOP);
      await there.goto(`${address}#scene=${name}`);
      await ready(there, /red\.obj$/);
      await there.locator('.picker').click();
      const offered = await there.locator('.menu-item').allTextContents();
      expect(!offered.some((text) => text.includes('Red.obj')), offered.join());
    } finally {
      await other.stop();
    }
  });
  await checks.check('a dropped HDR goes around the scene that is shown', async () => {
    await page.locator('.picker').click();
    await page.getByRole('menuitemradio', { name: /^Cornell/ }).click();
    await ready(page, /^cornell$/);
    await drop(page, { 'sky.hdr': SKY });
    await ready(page, /^cornell\+upload\/[0-9a-f]{32}\/sky\.hdr$/);
    const label = await page.locator('.picker-label').textContent();
    expect(label === 'Cornell with sky.hdr', label);
  });
}

async function unpacks(checks, page, folder) {
  await checks.check('the files of a dropped zip are uploaded and shown', async () => {
    const before = readdirSync(folder).length;
    await drop(page, { 'model.zip': zipped(MODEL) });
    await ready(page, /^upload\/[0-9a-f]{32}\/red\.obj$/);
    expect((await page.locator('.toast.error').count()) === 0, await page.locator('.toasts').innerText());
    expect(readdirSync(folder).length === before + 1, readdirSync(folder).join());
  });
}

async function refuses(checks, page, folder) {
  const told = async (words) => {
    await page.locator('.toast.error', { hasText: words }).waitFor({ timeout: 20_000 });
    await page.locator('.toast.error').getByRole('button', { name: 'Close message' }).first().click();
  };
  await checks.check('what is no scene is refused in words, and nothing of it stays', async () => {
    const before = readdirSync(folder).sort().join();
    await drop(page, { 'notes.txt': 'hello' });
    await told('None of these is a scene');
    await drop(page, { 'model.zip': 'PK' });
    await told('This archive cannot be read: it is no zip archive');
    const bomb = zipped({ 'bomb.obj': 'v 0 0 0\n'.repeat(4096) }, 10); // more than it says
    await drop(page, { 'bomb.zip': bomb });
    await told('bomb.obj is damaged');
    await drop(page, { 'broken.glb': 'glTF, it says, and is none' });
    await told('could not be opened');
    await until('nothing of it', 5000, () => readdirSync(folder).sort().join() === before);
  });
}

/** A line so slow that there is time to look, and one that breaks. */
async function slowly(checks, browser, page, folder) {
  const large = { 'slow.obj': `${MODEL['model/red.obj'].replace('mtllib red.mtl\n', '').replace('usemtl red\n', '')}${'# nothing\n'.repeat(60_000)}` };
  const card = page.locator('.upload-card');
  const problems = [...browser.problems];
  const devtools = await page.context().newCDPSession(page);
  await devtools.send('Network.enable');
  const line = (more) =>
    devtools.send('Network.emulateNetworkConditions', { offline: false, latency: 20, downloadThroughput: -1, uploadThroughput: -1, ...more });
  await checks.check('over a slow line the way and the time left are told, and it can be stopped', async () => {
    const before = readdirSync(folder).sort().join();
    await line({ uploadThroughput: 60_000 });
    await drop(page, large);
    const text = () => card.locator('.upload-text').textContent();
    await until('the time left', 20_000, async () => /^Uploading slow.obj: \d[\d.]* %, \d+ kB of 600 kB, \d+ s left$/.test(await text()));
    await page.screenshot({ path: join(outFolder, 'upload-slow.png') });
    await card.getByRole('button', { name: 'Stop the upload' }).click();
    await page.locator('.toast', { hasText: 'The upload was stopped' }).waitFor({ timeout: 20_000 });
    expect(await card.isHidden(), 'the card stays');
    await until('nothing of it', 10_000, () => readdirSync(folder).sort().join() === before);
    await line({});
    browser.problems = [...problems]; // it was to be stopped
  });
  await checks.check('where the line breaks it is said how far it came, and it is sent again', async () => {
    await page.route('**/uploads', (route) => (route.request().method() === 'POST' ? route.abort('connectionreset') : route.continue()));
    await drop(page, large);
    await until('the words', 10_000, async () => /^The line broke after .* of slow.obj/.test(await card.innerText()));
    await page.screenshot({ path: join(outFolder, 'upload-broken.png') });
    await page.unroute('**/uploads');
    browser.problems = [...problems]; // the broken line was meant
    await card.getByRole('button', { name: 'Send again' }).click();
    await ready(page, /slow\.obj$/);
    expect(await card.isHidden(), 'the card stays');
  });
}

/** A server that takes no files says so. */
async function closedDoor(checks) {
  const server = new Server(await freePort(), 'cornell');
  const browser = new Browser();
  try {
    await checks.check('a server without a folder for files says so', async () => {
      await server.start();
      const page = await browser.start(DESKTOP);
      await page.goto(`http://127.0.0.1:${server.port}/`);
      await ready(page, /^cornell$/);
      await drop(page, MODEL);
      await page.locator('.toast.error', { hasText: 'takes no files' }).waitFor({ timeout: 10_000 });
    });
  } finally {
    await browser.stop();
    await server.kill();
  }
}

/** A folder of the operator's, listed with pictures that the renderer made. */
async function pictures(checks) {
  const folder = mkdtempSync(join(tmpdir(), 'heliograph-scenes-'));
  const files = { ...MODEL, 'model/broken.glb': 'none' };
  mkdirSync(join(folder, 'model'));
  for (const [path, text] of Object.entries(files)) writeFileSync(join(folder, path), text);
  const server = new Server(await freePort(), 'cornell', undefined, { HELIOGRAPH_SCENES: folder });
  const browser = new Browser();
  try {
    await server.start();
    const page = await browser.start(DESKTOP);
    await page.goto(`http://127.0.0.1:${server.port}/`);
    await ready(page, /^cornell$/);
    const rowOf = (name) => page.getByRole('menuitemradio', { name });
    await checks.check('the menu of scenes has pictures, also of the files in the folder', async () => {
      await page.locator('.picker').click();
      for (const name of [/^Cornell/, /^Courtyard/])
        await until(`a picture of ${name}`, 20_000, async () => (await pictureOf(rowOf(name))).width === 160);
      await page.screenshot({ path: join(outFolder, 'scene-pictures.png') });
      const broken = page.waitForResponse((r) => r.url().endsWith('broken.glb') && r.status() === 200, { timeout: 60_000 });
      broken.catch(() => undefined); // said below
      const red = rowOf(/Red\.obj/i);
      await red.scrollIntoViewIfNeeded();
      await until('the file\u2019s picture', 60_000, async () => (await pictureOf(red)).width === 160);
      await page.screenshot({ path: join(outFolder, 'scene-pictures-folder.png') });
      const { colour } = await pictureOf(red);
      expect(colour[0] > colour[1] + 5, `red ${colour[0]}, green ${colour[1]}`);
      await rowOf(/Broken\.glb/i).scrollIntoViewIfNeeded();
      expect((await (await broken).body()).length === 0, 'a picture of what cannot be read');
      expect((await pictureOf(rowOf(/Broken\.glb/i))).width === 1, 'a picture of what cannot be read is shown');
    });
    await checks.check('a scene is opened while others are loaded for their pictures', async () => {
      await rowOf(/^Glass/).click();
      await ready(page, /^glass$/);
      expect(browser.problems.length === 0, browser.problems.join('\n'));
    });
  } finally {
    await browser.stop();
    await server.kill();
    rmSync(folder, { recursive: true, force: true });
  }
}

/** Width and mean colour of the picture in a row. */
const pictureOf = (row) =>
  row.locator('img').evaluate((image) => {
    const canvas = document.createElement('canvas');
    [canvas.width, canvas.height] = [1, 1];
    const context = canvas.getContext('2d');
    context.drawImage(image, 0, 0, 1, 1);
    return { width: image.naturalWidth, colour: [...context.getImageData(0, 0, 1, 1).data] };
  });

/** Runs everything; failures and passes are counted in `checks`. */
export async function uploadChecks(checks) {
  const folder = mkdtempSync(join(tmpdir(), 'heliograph-uploads-'));
  const server = new Server(await freePort(), 'cornell', undefined, { HELIOGRAPH_UPLOADS: folder });
  const browser = new Browser();
  try {
    if (!(await checks.check('the server starts (uploads)', () => server.start()))) return;
    const address = `http://127.0.0.1:${server.port}/`;
    const page = await browser.start(DESKTOP);
    await page.goto(address);
    await ready(page, /^cornell$/);
    await brings(checks, page, folder, address);
    await unpacks(checks, page, folder);
    await slowly(checks, browser, page, folder);
    await refuses(checks, page, folder);
    await checks.check('nothing was wrong in the browser\u2019s console (uploads)', async () => {
      expect(browser.problems.length === 0, browser.problems.join('\n'));
    });
  } finally {
    await browser.stop();
    await server.kill();
    rmSync(folder, { recursive: true, force: true });
  }
  await closedDoor(checks);
  await pictures(checks);
}

if (import.meta.url === pathToFileURL(process.argv[1]).href) {
  const checks = new Checks();
  await uploadChecks(checks);
  checks.finish();
}
