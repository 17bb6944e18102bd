// One colour per device, the same everywhere on the page: the processor blue, GPUs red-orange (further ones differ from the
// first in lightness), anything else from a series that people with any colour vision can tell apart (after M. Okabe
// and K. Ito, "Color Universal Design", 2008, lightened for a dark surface).

import type { DeviceKind } from '../wire/protocol.js';

const PROCESSOR = '#4f9cff';
const GPUS: readonly string[] = ['#ff6a3d', '#a83a1c', '#ffc4ad', '#6e2f1d'];
const SERIES: readonly string[] = ['#2f9e83', '#f0e442', '#d98cc0', '#eceef1', '#8a5fd0', '#8f8a3a'];

/** Index into SERIES of names that are of no such kind, in the order in which they were met. */
const met = new Map<string, number>();
let kinds: readonly DeviceKind[] = [];

/** Takes what `hello` says of the kinds of devices. */
export function knowDevices(told: readonly DeviceKind[]): void {
  kinds = told;
}

/** The kind of a device as the server names it, `vulkan:0`; undefined for a name of no kind. */
export const kindOf = (name: string): DeviceKind | undefined =>
  kinds.find((kind) => kind.name === name.split(':', 1)[0]);

/** `#rrggbb` of a device as the server names it. */
export function deviceColor(name: string): string {
  const kind = kindOf(name);
  const first = kinds.find((other) => other.kind === kind?.kind);
  if (kind !== undefined && kind === first) {
    if (kind.kind === 'processor') return PROCESSOR;
    if (kind.kind === 'gpu') return GPUS[Number(name.split(':')[1] ?? 0) % GPUS.length]!;
  }
  if (!met.has(name)) met.set(name, met.size);
  return SERIES[met.get(name)! % SERIES.length]!;
}

/** Red, green and blue, 0..255, of `#rrggbb`. */
export function rgbOf(color: string): readonly [number, number, number] {
  const value = Number.parseInt(color.slice(1), 16);
  return [value >> 16, (value >> 8) & 255, value & 255];
}
