// What pictures of a moving view do without for the time budget, and why. Knows no DOM.

import type { Autopilot } from '../../wire/protocol.js';
import type { BarRow } from './bar_list.js';

const ms = (value: number): string => `${value < 10 ? value.toFixed(1) : value.toFixed(0)} ms`;

/** Heading of the list; '' without a budget. */
export function autopilotTitle(autopilot: Autopilot | null): string {
  if (autopilot === null) return '';
  const now = autopilot.ms > 0 ? `: ${ms(autopilot.ms)} a picture` : '';
  return `Time budget ${ms(autopilot.budgetMs)}${now}`;
}

/** A row for each step down, the first one first: what was lowered, and what a picture would take without that. */
export function autopilotRows(autopilot: Autopilot | null, labelOf: (setting: string) => string): readonly (readonly [string, BarRow])[] {
  if (autopilot === null) return [];
  const longest = Math.max(autopilot.ms, ...autopilot.steps.map(({ msWithout }) => msWithout));
  const rows = autopilot.steps.map(({ setting, before, after, msWithout }): readonly [string, BarRow] => [
    `${setting} ${after}`,
    {
      label: `${labelOf(setting)} ${before} → ${after}`,
      share: longest > 0 ? msWithout / longest : 0,
      text: `${ms(msWithout)} without`,
    },
  ]);
  if (autopilot.scale >= 1) return rows;
  const full = autopilot.scale > 0 ? autopilot.ms / autopilot.scale ** 2 : 0;
  const scale: BarRow = {
    label: `Width ${(autopilot.scale * 100).toFixed(0)} %`,
    share: longest > 0 ? full / longest : 0,
    text: `${ms(full)} without`,
  };
  return [...rows, ['scale', scale]];
}
