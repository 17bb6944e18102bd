// Scales of the light's numbers: turns that go round, and multipliers whose equal steps are equal factors. Knows no DOM.

import { SLIDER_STEPS, type Range, type SliderScale } from '../settings/slider_scale.js';

const BELOW_DEFAULT = 100; // from nought on, the least value that is shown is so many times less than the default

/** The least value above nought that the scale shows. */
function leastOf({ low, high, default: preset }: Range): number {
  if (low > 0) return low;
  return typeof preset === 'number' && preset > 0 ? preset / BELOW_DEFAULT : high / BELOW_DEFAULT ** 2;
}

const within = ({ low, high }: Range, value: number): number => Math.min(high, Math.max(low, value));

function fromPosition(row: Range, position: number): number {
  const share = Math.min(1, Math.max(0, position / SLIDER_STEPS));
  if (share === 0) return row.low;
  if (share === 1) return row.high;
  const least = leastOf(row);
  return within(row, Number((least * (row.high / least) ** share).toPrecision(2)));
}

function toPosition(row: Range, value: number): number {
  const least = leastOf(row);
  if (value <= least) return value > row.low ? 1 : 0;
  return SLIDER_STEPS * Math.min(1, Math.log(value / least) / Math.log(row.high / least));
}

/** For a range of factors: its lower end at the left, then equal factors for equal ways. Two digits. */
export const LOG_SCALE: SliderScale = {
  to: toPosition,
  from: fromPosition,
  stepped: (row, value, direction, large) => {
    if (value <= row.low && direction > 0) return leastOf(row);
    if (value <= leastOf(row) && direction < 0) return row.low;
    const steps = direction * (large ? 10 : 1) * (SLIDER_STEPS / 100);
    return fromPosition(row, Math.max(1, toPosition(row, value) + steps));
  },
};

const SMALL_TURN = 1; // degree
const LARGE_TURN = 15;

/** In whole degrees; a range of a full turn goes round, a smaller one ends. */
export function turnedTo({ low, high }: Range, degrees: number): number {
  const whole = Math.round(degrees);
  if (high - low < 360) return Math.min(high, Math.max(low, whole));
  const round = (((whole - low) % 360) + 360) % 360;
  return low + round;
}

/** For angles: a degree by the arrows, 15 by the page keys. */
export const TURN_SCALE: SliderScale = {
  to: (row, value) => (SLIDER_STEPS * (within(row, value) - row.low)) / (row.high - row.low),
  from: (row, position) => turnedTo(row, row.low + ((row.high - row.low) * position) / SLIDER_STEPS),
  stepped: (row, value, direction, large) => turnedTo(row, value + direction * (large ? LARGE_TURN : SMALL_TURN)),
};

/** Degrees clockwise from the top, of a place beside the middle of a dial; null too near to the middle to tell. */
export function angleAt(dx: number, dy: number): number | null {
  return Math.hypot(dx, dy) < 6 ? null : (Math.atan2(dx, -dy) * 180) / Math.PI;
}
