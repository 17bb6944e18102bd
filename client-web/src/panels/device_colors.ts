// One colour per device, the same everywhere on the page: Embree blue, Vulkan red-orange (further GPUs differ from the
// first in lightness), anything else from a series that people with any colour vision can tell apart (after M. Okabe
// and K. Ito, "Color Universal Design", 2008, lightened for a dark surface).

const EMBREE = '#4f9cff';
const VULKAN: readonly string[] = ['#ff6a3d', '#a83a1c', '#ffc4ad', '#6e2f1d'];
const SERIES: readonly string[] = ['#2f9e83', '#f0e442', '#d98cc0', '#eceef1', '#8a5fd0', '#8f8a3a'];

/** Index into SERIES of names that are neither Embree nor Vulkan, in the order in which they were met. */
const met = new Map<string, number>();

/** `#rrggbb` of a device as the server names it (`embree`, `vulkan:0`, any other). */
export function deviceColor(name: string): string {
  if (/^embree\b/.test(name)) return EMBREE;
  const vulkan = /^vulkan(?::(\d+))?$/.exec(name);
  if (vulkan !== null) return VULKAN[Number(vulkan[1] ?? 0) % VULKAN.length]!;
  if (!met.has(name)) met.set(name, met.size);
  return SERIES[met.get(name)! % SERIES.length]!;
}

/** Red, green and blue, 0..255, of `#rrggbb`. */
export function rgbOf(color: string): readonly [number, number, number] {
  const value = Number.parseInt(color.slice(1), 16);
  return [value >> 16, (value >> 8) & 255, value & 255];
}
