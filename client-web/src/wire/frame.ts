// The binary messages of docs/reference/protocol.md: a 64-byte header, little endian, and a picture.

import { HEADER_BYTES } from './limits.js';
import type { DeviceKind } from './protocol.js';

/** Something from the server that does not follow the protocol. */
export class ProtocolError extends Error {}

export type VideoCodec = 'vp9' | 'h264';
export type Codec = 'jpeg' | 'png' | 'exr' | VideoCodec;
const CODECS: readonly Codec[] = ['jpeg', 'png', 'exr', 'vp9', 'h264'];
export const MIME_TYPES: Readonly<Record<Codec, string>> = {
  jpeg: 'image/jpeg',
  png: 'image/png',
  exr: 'image/x-exr',
  vp9: 'video/vp9',
  h264: 'video/h264',
};
export const VIDEO_NAMES: Readonly<Record<VideoCodec, string>> = { vp9: 'VP9', h264: 'H.264' };
export const VIDEO_CODECS: readonly VideoCodec[] = ['vp9', 'h264'];
export const isVideo = (codec: unknown): codec is VideoCodec => VIDEO_CODECS.includes(codec as VideoCodec);

/** Which pixels of a picture a part holds. */
export interface Place {
  readonly x: number;
  readonly y: number;
  readonly width: number;
  readonly height: number;
}

export interface Frame {
  readonly kind: 'frame' | 'picture' | 'part';
  readonly place: Place | null; // of a part: `width` and `height` are the whole picture's
  readonly codec: Codec;
  readonly moving: boolean;
  readonly final: boolean; // the sample target or the error target is reached
  readonly errorReached: boolean; // the error target, with fewer samples
  readonly denoised: boolean; // its grain is taken away, and some of its detail may be
  readonly path: boolean; // a frame of the benchmark path
  readonly key: boolean; // of a video: needs no picture before it
  readonly exact: boolean; // no code of a pixel differs from the server's picture
  readonly quality: number; // jpeg, or of a video that looks as good
  readonly frameId: number;
  readonly inputId: number; // newest input that this picture shows
  readonly generation: number;
  readonly width: number;
  readonly height: number;
  readonly fullWidth: number; // display size asked for
  readonly fullHeight: number;
  readonly samples: number; // per pixel
  readonly relativeError: number; // 1 = unknown
  readonly renderMs: number;
  readonly developMs: number;
  readonly encodeMs: number;
  readonly queueMs: number; // input to render start
  readonly sendMs: number; // encoded to written
  readonly devices: readonly string[]; // kinds that took part
  readonly payload: Uint8Array<ArrayBuffer>;
}

/** Names of the kinds of devices whose bits are set; bits that no kind has are one `other`. */
export function deviceNames(bits: number, kinds: readonly DeviceKind[]): readonly string[] {
  const known = kinds.filter(({ bit }) => (bits & (1 << bit)) !== 0);
  const rest = known.reduce((left, { bit }) => left & ~(1 << bit), bits);
  return [...known.map(({ name }) => name), ...(rest === 0 ? [] : ['other'])];
}

const KINDS: Readonly<Record<number, Frame['kind']>> = { 1: 'frame', 2: 'picture', 3: 'part' };

function placeOf(view: DataView, headerBytes: number): Place {
  const bytes = HEADER_BYTES + 8;
  if (headerBytes < bytes) throw new ProtocolError(`part header: ${headerBytes} bytes, allowed: at least ${bytes}`);
  const [x, y, width, height] = [0, 2, 4, 6].map((offset) => view.getUint16(HEADER_BYTES + offset, true));
  return { x: x!, y: y!, width: width!, height: height! };
}

/**
 * Reads a binary message. `kinds`: the devices that `hello` named. Throws ProtocolError naming field, found value and what
 * is allowed.
 */
export function parseFrame(buffer: ArrayBuffer, kinds: readonly DeviceKind[]): Frame {
  if (buffer.byteLength < HEADER_BYTES) {
    throw new ProtocolError(`frame: ${buffer.byteLength} bytes, allowed: at least ${HEADER_BYTES}`);
  }
  const view = new DataView(buffer);
  if (view.getUint8(0) !== 0x48 || view.getUint8(1) !== 0x47)
    throw new ProtocolError('frame: does not start with "HG"');
  const kind = view.getUint8(2);
  const name = KINDS[kind];
  if (name === undefined) throw new ProtocolError(`frame kind: ${kind}, allowed: 1, 2, 3`);
  const codec = CODECS[view.getUint8(3)];
  if (codec === undefined)
    throw new ProtocolError(`frame codec: ${view.getUint8(3)}, allowed: 0 to ${CODECS.length - 1}`);
  const headerBytes = view.getUint16(4, true);
  const payloadBytes = view.getUint32(56, true);
  if (headerBytes < HEADER_BYTES || headerBytes + payloadBytes !== buffer.byteLength) {
    throw new ProtocolError(`frame: header ${headerBytes} + payload ${payloadBytes} bytes, found ${buffer.byteLength}`);
  }
  const flags = view.getUint8(6);
  const milliseconds = (offset: number): number => view.getUint32(offset, true) / 1000;
  return {
    kind: name,
    place: name === 'part' ? placeOf(view, headerBytes) : null,
    codec,
    moving: (flags & 1) !== 0,
    final: (flags & 2) !== 0,
    errorReached: (flags & 16) !== 0,
    denoised: (flags & 32) !== 0,
    path: (flags & 4) !== 0,
    key: (flags & 8) !== 0,
    exact: false, // a part is, but no picture
    quality: view.getUint8(7),
    frameId: view.getUint32(8, true),
    inputId: view.getUint32(12, true),
    generation: view.getUint32(16, true),
    width: view.getUint16(20, true),
    height: view.getUint16(22, true),
    fullWidth: view.getUint16(24, true),
    fullHeight: view.getUint16(26, true),
    samples: view.getUint32(28, true),
    relativeError: view.getFloat32(32, true),
    renderMs: milliseconds(36),
    developMs: milliseconds(40),
    encodeMs: milliseconds(44),
    queueMs: milliseconds(48),
    sendMs: milliseconds(52),
    devices: deviceNames(view.getUint32(60, true), kinds),
    payload: new Uint8Array(buffer, headerBytes, payloadBytes),
  };
}
