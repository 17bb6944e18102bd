// A scale of equal factors, and round values to mark on it. Knows no DOM.

/** Digits of marks, the densest first; the numbers between two powers of ten. */
const DIGITS: readonly (readonly number[])[] = [
  [1, 1.2, 1.4, 1.6, 1.8, 2, 2.5, 3, 3.5, 4, 4.5, 5, 6, 7, 8, 9],
  [1, 1.5, 2, 3, 4, 5, 7],
  [1, 2, 5],
  [1, 3],
  [1],
];
const LEAST_FACTOR = 2; // from end to end
const MARGIN = 0.06; // of the length, beyond the outermost value

export interface LogScale {
  readonly low: number;
  readonly high: number;
  /** 0..1 from low to high; what lies beyond, or is 0, sticks to the end. */
  at(value: number): number;
}

/** Holds all values above 0, with some room around them. */
export function logScale(values: readonly number[]): LogScale {
  const logs = values.filter((value) => value > 0 && Number.isFinite(value)).map(Math.log);
  const [least, most] = logs.length === 0 ? [0, 0] : [Math.min(...logs), Math.max(...logs)];
  const missing = Math.max(0, Math.log(LEAST_FACTOR) - (most - least));
  const room = MARGIN * (most - least + missing) + missing / 2;
  const [low, high] = [least - room, most + room];
  const at = (value: number): number =>
    value > 0 ? Math.min(1, Math.max(0, (Math.log(value) - low) / (high - low))) : 0;
  return { low: Math.exp(low), high: Math.exp(high), at };
}

/** Round values within the scale, `most` at most. */
export function logTicks({ low, high }: LogScale, most: number): readonly number[] {
  const first = Math.floor(Math.log10(low));
  const last = Math.ceil(Math.log10(high));
  const ticks = (digits: readonly number[], step: number): readonly number[] => {
    const found: number[] = [];
    for (let power = Math.ceil(first / step) * step; power <= last; power += step) {
      for (const digit of digits) found.push(Number(`${digit}e${power}`));
    }
    return found.filter((tick) => tick >= low && tick <= high);
  };
  const dense = DIGITS.map((digits) => ticks(digits, 1)).find((marks) => marks.length <= most);
  if (dense !== undefined) return dense;
  for (let step = 2; ; step += 1) {
    const marks = ticks([1], step);
    if (marks.length <= most) return marks;
  }
}
