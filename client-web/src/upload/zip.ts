// What lies in a zip archive: its directory, and one file of it. After APPNOTE.TXT 6.3.10 (PKWARE), without its 64-bit
// sizes, encryption and volumes. Knows no DOM but Blob and DecompressionStream.

import type { NamedFile } from './upload_files.js';

export interface ZipEntry extends NamedFile {
  readonly packed: number; // bytes in the archive
  readonly deflated: boolean; // else stored as it is
  readonly crc: number;
  readonly at: number; // of its own header in the archive
}

/** Says why in words for who brought the archive. */
export class ZipError extends Error {}

const END = 0x06054b50;
const IN_DIRECTORY = 0x02014b50;
const OF_FILE = 0x04034b50;
const END_BYTES = 22;
const COMMENT = 0xffff; // bytes at most after the end's record
const MOST_DIRECTORY = 8 * 2 ** 20; // bytes
const TOO_LARGE = 0xffffffff; // of a field whose value stands elsewhere, in 64 bits

/** Of the archive's last bytes: where its directory is. */
export function directoryPlace(tail: Uint8Array): { at: number; bytes: number; entries: number } {
  const view = viewOf(tail);
  for (let at = tail.length - END_BYTES; at >= 0; at--) {
    if (view.getUint32(at, true) !== END || at + END_BYTES + view.getUint16(at + 20, true) !== tail.length) continue;
    const place = { at: view.getUint32(at + 16, true), bytes: view.getUint32(at + 12, true), entries: view.getUint16(at + 10, true) };
    if (place.at === TOO_LARGE || place.bytes === TOO_LARGE) throw new ZipError('it has 64-bit sizes');
    if (view.getUint32(at + 4, true) !== 0) throw new ZipError('it is in several parts');
    return place;
  }
  throw new ZipError('it is no zip archive, or its end is missing');
}

/** The files of a directory; folders have no row. */
export function entriesOf(directory: Uint8Array, count: number): readonly ZipEntry[] {
  const view = viewOf(directory);
  const entries: ZipEntry[] = [];
  let at = 0;
  for (let i = 0; i < count; i++) {
    if (at + 46 > directory.length || view.getUint32(at, true) !== IN_DIRECTORY) throw new ZipError('its directory is damaged');
    const lengths = [28, 30, 32].map((field) => view.getUint16(at + field, true));
    const nameBytes = directory.subarray(at + 46, at + 46 + (lengths[0] ?? 0));
    if (nameBytes.length !== lengths[0]) throw new ZipError('its directory is damaged');
    const path = nameOf(nameBytes);
    if (!path.endsWith('/')) entries.push(entryAt(view, at, path));
    at += 46 + lengths.reduce((sum, length) => sum + length, 0);
  }
  return entries;
}

function entryAt(view: DataView, at: number, path: string): ZipEntry {
  const method = view.getUint16(at + 10, true);
  if ((view.getUint16(at + 8, true) & 1) !== 0) throw new ZipError(`${path} is encrypted`);
  if (method !== 0 && method !== 8) throw new ZipError(`${path} is packed by method ${method}; deflate and none are read`);
  const [packed = 0, bytes = 0, own = 0] = [20, 24, 42].map((field) => view.getUint32(at + field, true));
  if ([packed, bytes, own].includes(TOO_LARGE)) throw new ZipError('it has 64-bit sizes');
  return { path, bytes, packed, deflated: method === 8, crc: view.getUint32(at + 16, true), at: own };
}

/** Some programs write the separators of their system. */
function nameOf(bytes: Uint8Array): string {
  let name: string;
  try {
    name = new TextDecoder('utf-8', { fatal: true }).decode(bytes);
  } catch {
    name = new TextDecoder('latin1').decode(bytes);
  }
  return name.replace(/\\/g, '/').replace(/^\/+/, '');
}

/** The archive's files. Reads its end and its directory alone. */
export async function openZip(archive: Blob): Promise<readonly ZipEntry[]> {
  const tail = await bytesOf(archive.slice(Math.max(0, archive.size - END_BYTES - COMMENT)));
  const place = directoryPlace(tail);
  if (place.bytes > MOST_DIRECTORY || place.at + place.bytes > archive.size) throw new ZipError('its directory is damaged');
  return entriesOf(await bytesOf(archive.slice(place.at, place.at + place.bytes)), place.entries);
}

/** One file; no more bytes are unpacked than its row says. */
export async function unpacked(archive: Blob, entry: ZipEntry): Promise<Blob> {
  const damaged = new ZipError(`${entry.path} is damaged`);
  const head = viewOf(await bytesOf(archive.slice(entry.at, entry.at + 30)));
  if (head.byteLength < 30 || head.getUint32(0, true) !== OF_FILE) throw damaged;
  const from = entry.at + 30 + head.getUint16(26, true) + head.getUint16(28, true);
  const packed = archive.slice(from, from + entry.packed);
  if (packed.size !== entry.packed) throw damaged;
  const parts = entry.deflated ? await inflated(packed, entry.bytes, damaged) : [await bytesOf(packed)];
  const bytes = parts.reduce((sum, part) => sum + part.length, 0);
  if (bytes !== entry.bytes || crc32(parts) !== entry.crc) throw damaged;
  return new Blob(parts.map((part) => part as BlobPart));
}

async function inflated(packed: Blob, most: number, damaged: ZipError): Promise<readonly Uint8Array[]> {
  const parts: Uint8Array[] = [];
  const reader = packed.stream().pipeThrough(new DecompressionStream('deflate-raw')).getReader();
  let bytes = 0;
  for (;;) {
    const { done, value } = await reader.read().catch(() => Promise.reject(damaged));
    if (done) return parts;
    bytes += value.length;
    if (bytes > most) {
      void reader.cancel().catch(() => undefined);
      throw damaged;
    }
    parts.push(value);
  }
}

/** The archive's check sum: polynomial 0x04c11db7, reflected (APPNOTE.TXT 4.4.7). */
export function crc32(parts: readonly Uint8Array[]): number {
  let crc = -1;
  for (const part of parts) for (const byte of part) crc = (crc >>> 8) ^ (CRC_TABLE[(crc ^ byte) & 255] ?? 0);
  return ~crc >>> 0;
}

const CRC_TABLE = Uint32Array.from({ length: 256 }, (_, i) => {
  let value = i;
  for (let bit = 0; bit < 8; bit++) value = (value & 1) !== 0 ? (value >>> 1) ^ 0xedb88320 : value >>> 1;
  return value;
});

const viewOf = (bytes: Uint8Array): DataView => new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
const bytesOf = async (blob: Blob): Promise<Uint8Array> => new Uint8Array(await blob.arrayBuffer());
