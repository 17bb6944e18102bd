import assert from 'node:assert/strict';
import { test } from 'node:test';
import { crc32, directoryPlace, entriesOf, openZip, unpacked, ZipError } from '../src/upload/zip.js';

interface Packed {
  readonly name: string | Uint8Array;
  readonly bytes: string;
  readonly method?: number;
  readonly flags?: number;
  readonly says?: number; // bytes, where that is not the truth
}

const text = new TextEncoder();

/** Little-endian fields of these widths. */
function fields(...pairs: readonly (readonly [number, number])[]): Uint8Array {
  const view = new DataView(new ArrayBuffer(pairs.reduce((sum, [width]) => sum + width, 0)));
  let at = 0;
  for (const [width, value] of pairs) {
    if (width === 2) view.setUint16(at, value, true);
    else view.setUint32(at, value, true);
    at += width;
  }
  return new Uint8Array(view.buffer);
}

/** An archive whose files are stored as they are. */
function archive(files: readonly Packed[], comment = ''): Blob {
  const parts: Uint8Array[] = [];
  const rows: Uint8Array[] = [];
  const length = (list: readonly Uint8Array[]): number => list.reduce((sum, part) => sum + part.length, 0);
  for (const { name, bytes, method = 0, flags = 0, says } of files) {
    const path = typeof name === 'string' ? text.encode(name) : name;
    const content = text.encode(bytes);
    const at = length(parts);
    const sizes = [[4, crc32([content])], [4, content.length], [4, says ?? content.length], [2, path.length]] as const;
    parts.push(fields([4, 0x04034b50], [2, 20], [2, flags], [2, method], [4, 0], ...sizes, [2, 3]), path, text.encode('xyz'), content);
    rows.push(fields([4, 0x02014b50], [2, 20], [2, 20], [2, flags], [2, method], [4, 0], ...sizes, [2, 0], [2, 0], [2, 0], [2, 0], [4, 0], [4, at]), path);
  }
  const end = fields([4, 0x06054b50], [4, 0], [2, files.length], [2, files.length], [4, length(rows)], [4, length(parts)], [2, comment.length]);
  return new Blob([...parts, ...rows, end, text.encode(comment)].map((part) => part as BlobPart));
}

const MODEL: readonly Packed[] = [{ name: 'car/', bytes: '' }, { name: 'car/car.obj', bytes: 'v 0 0 0' }, { name: 'car/ä.png', bytes: 'png' }];

test('the files of an archive, without its folders', async () => {
  const entries = await openZip(archive(MODEL, 'a comment, in which PK\u0005\u0006 may stand'));
  assert.deepEqual(entries.map(({ path, bytes }) => [path, bytes]), [['car/car.obj', 7], ['car/ä.png', 3]]);
});

test('names of other systems become paths', async () => {
  const entries = await openZip(archive([{ name: '\\car\\car.obj', bytes: '' }, { name: Uint8Array.of(0xe4, 0x2e, 0x6d), bytes: '' }]));
  assert.deepEqual(entries.map(({ path }) => path), ['car/car.obj', 'ä.m']);
});

test('a stored file comes out as it went in', async () => {
  const zip = archive(MODEL);
  const [first] = await openZip(zip);
  assert.ok(first !== undefined);
  assert.equal(await (await unpacked(zip, first)).text(), 'v 0 0 0');
});

test('what is damaged or says more than it has is refused by name', async () => {
  const zip = archive([{ name: 'a.obj', bytes: 'v 0 0 0', says: 8 }]);
  const [entry] = await openZip(zip);
  assert.ok(entry !== undefined);
  await assert.rejects(unpacked(zip, entry), /a\.obj is damaged/);
  await assert.rejects(unpacked(zip, { ...entry, bytes: 7, crc: 1 }), /a\.obj is damaged/);
  await assert.rejects(unpacked(zip, { ...entry, at: 3 }), /a\.obj is damaged/);
  await assert.rejects(unpacked(zip, { ...entry, packed: 10_000 }), /a\.obj is damaged/);
});

test('what is not read is told', async () => {
  await assert.rejects(openZip(archive([{ name: 'a.obj', bytes: '', flags: 1 }])), /a\.obj is encrypted/);
  await assert.rejects(openZip(archive([{ name: 'a.obj', bytes: '', method: 14 }])), /packed by method 14/);
  await assert.rejects(openZip(archive([{ name: 'a.obj', bytes: '', says: 0xffffffff }])), /64-bit sizes/);
  await assert.rejects(openZip(new Blob(['PK'])), /no zip archive/);
  await assert.rejects(openZip(new Blob([])), /no zip archive/);
});

test('no damage to a byte does anything but end in words', async () => {
  const whole = new Uint8Array(await archive(MODEL).arrayBuffer());
  for (let at = 0; at < whole.length; at++) {
    const bytes = whole.slice();
    bytes[at] = (bytes[at] ?? 0) ^ 0xff;
    const zip = new Blob([bytes]);
    try {
      for (const entry of await openZip(zip)) if (!entry.deflated) await unpacked(zip, entry);
    } catch (error) {
      assert.ok(error instanceof ZipError, String(error));
    }
  }
});

test('a directory that ends early is damaged', () => {
  assert.throws(() => entriesOf(new Uint8Array(45), 1), ZipError);
  assert.throws(() => directoryPlace(new Uint8Array(100)), ZipError);
});
