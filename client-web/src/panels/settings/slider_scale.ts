// Maps a setting's range to a slider and back. Ranges are often wide (1 to 65,536) with the useful part near one end,
// so the scale is a power curve that puts the default value at a third of the way when it lies lower than that.

import type { SettingRow } from '../../wire/protocol.js';

export const SLIDER_STEPS = 1000;
const DEFAULT_AT = 1 / 3;

export type Range = Pick<SettingRow, 'type' | 'low' | 'high' | 'default'>;

/** Exponent of the curve, at least 1 (linear). */
export function sliderExponent(row: Range): number {
  const span = row.high - row.low;
  const share = span > 0 && typeof row.default === 'number' ? (row.default - row.low) / span : 0;
  if (share <= 0 || share >= DEFAULT_AT * 0.75) return 1;
  return Math.log(share) / Math.log(DEFAULT_AT);
}

/** Slider position 0..SLIDER_STEPS of a value; values outside the range stick to the ends. */
export function toSlider(row: Range, value: number): number {
  const share = row.high > row.low ? (value - row.low) / (row.high - row.low) : 0;
  return SLIDER_STEPS * Math.pow(Math.min(1, Math.max(0, share)), 1 / sliderExponent(row));
}

/** Value of a slider position: whole for int, three significant digits for float, exact at both ends. */
export function fromSlider(row: Range, position: number): number {
  const share = Math.min(1, Math.max(0, position / SLIDER_STEPS));
  if (share === 0) return row.low;
  if (share === 1) return row.high;
  const value = row.low + (row.high - row.low) * Math.pow(share, sliderExponent(row));
  return rounded(row, value);
}

/** The next value when an arrow key is pressed; `direction` -1 or 1, `large` for page keys. */
export function stepped(row: Range, value: number, direction: number, large: boolean): number {
  const limit = (next: number): number => Math.min(row.high, Math.max(row.low, next));
  const steps = large ? 10 : 1;
  if (row.type === 'int') {
    const along = fromSlider(row, toSlider(row, value) + direction * steps * (SLIDER_STEPS / 100));
    const next = value + direction * steps;
    return limit(large && Math.abs(along - value) > Math.abs(next - value) ? along : next);
  }
  return limit(fromSlider(row, toSlider(row, value) + direction * steps * (SLIDER_STEPS / 100)));
}

function rounded(row: Range, value: number): number {
  const next = row.type === 'int' ? Math.round(value) : Number(value.toPrecision(3));
  return Math.min(row.high, Math.max(row.low, next));
}

/** How the positions of a slider stand for values. */
export interface SliderScale {
  to(row: Range, value: number): number;
  from(row: Range, position: number): number;
  stepped(row: Range, value: number, direction: number, large: boolean): number;
}

export const POWER_SCALE: SliderScale = { to: toSlider, from: fromSlider, stepped };
