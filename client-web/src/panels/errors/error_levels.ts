// In which steps errors are shown, and how much of a picture is at each. Knows no DOM.

import { percent } from '../../page/format.js';
import { roundPercent } from '../../picture/forecast_text.js';
import type { ErrorMap } from '../../wire/errors_message.js';

/** From which error on each step but the first begins. */
const BOUNDS = [0.005, 0.01, 0.02, 0.05, 0.1];
/** Ordered in lightness, also for who sees few colours: from matplotlib's map "plasma". */
export const LEVEL_COLORS: readonly string[] = ['#0d0887', '#6a00a8', '#b12a90', '#e16462', '#fca636', '#f0f921'];

export const levelOf = (error: number): number => BOUNDS.filter((bound) => error >= bound).length;

export const LEVEL_NAMES: readonly string[] = LEVEL_COLORS.map((_, level) => {
  if (level === 0) return `under ${roundPercent(BOUNDS[0]!)}`;
  if (level === BOUNDS.length) return `${roundPercent(BOUNDS.at(-1)!)} and more`;
  return `${roundPercent(BOUNDS[level - 1]!)} to ${roundPercent(BOUNDS[level]!)}`;
});

/** Share of the cells at each level, 0..1, of those whose error is known. */
export function levelShares({ cells }: ErrorMap): readonly number[] {
  const counts = LEVEL_COLORS.map(() => 0);
  const known = cells.filter((cell) => cell !== null);
  for (const error of known) counts[levelOf(error)]! += 1;
  return counts.map((count) => (known.length > 0 ? count / known.length : 0));
}

/** In sentences, for those who do not see it. */
export function describeErrors(map: ErrorMap): string {
  const known = map.cells.filter((cell) => cell !== null).sort((a, b) => a - b);
  if (known.length === 0) return 'Nothing is known of the error yet.';
  const [half, worst] = [known[Math.floor((known.length - 1) / 2)]!, known.at(-1)!];
  return `Half of the picture has an error of at most ${percent(half)}, the worst part ${percent(worst)}.`;
}
