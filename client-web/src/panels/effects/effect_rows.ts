// What the effects panel says of each effect: whether the scene calls for it, whether the viewer allows it, what it did
// and what it costs. Knows no DOM.

import type { Numbers } from '../../wire/fields.js';
import { count } from '../../page/format.js';
import type { EffectCost } from '../../wire/effect_costs_message.js';
import type { EffectReason, SettingRow, SettingValue } from '../../wire/protocol.js';
import { spacedWords } from '../../page/scene_name.js';

/** Kinds of rays in `stats` that one effect alone shoots. */
const RAY_KINDS: Readonly<Record<string, string>> = {
  shadows: 'shadow',
  ambientOcclusion: 'ambient_occlusion',
  reflections: 'reflection',
  refractions: 'refraction',
};

export interface EffectRow {
  readonly name: string;
  readonly label: string;
  readonly help: string;
  readonly calledFor: boolean;
  readonly choice: boolean;
  readonly because: string;
  readonly simulated: boolean;
  /** The setting that allows it; null: nothing can forbid it. */
  readonly setting: SettingRow | null;
}

/** One row per effect: what the scene calls for, what the viewer chooses, the rest; else in the server's order. */
export function effectRows(effects: readonly EffectReason[], schema: readonly SettingRow[]): readonly EffectRow[] {
  const rows = effects.map((effect) => {
    const { name, calledFor, choice, because, help, simulated } = effect;
    const setting = schema.find((row) => row.name === effect.setting) ?? null;
    const own = setting !== null && setting.name === name && setting.type === 'bool';
    return { name, label: own ? setting.label : capitalised(spacedWords(name)), help, calledFor, choice, because, simulated, setting };
  });
  const rank = (row: EffectRow): number => (row.calledFor ? 0 : row.choice ? 1 : 2);
  return rows.sort((a, b) => rank(a) - rank(b));
}

const capitalised = (text: string): string => text.charAt(0).toUpperCase() + text.slice(1);

/** Whether a setting with this value lets its effect happen: a switch that is on, a number above 0. */
export const allows = (value: SettingValue | undefined): boolean => value !== false && value !== 0;

/** Whether an effect takes place, and why. */
export function effectState(row: EffectRow, allowed: boolean): string {
  const because = row.because === '' ? '' : `: ${row.because}`;
  if (row.choice) return allowed ? 'on: you chose it' : 'off: yours to choose';
  if (!row.calledFor) return `off${because}`;
  if (!row.simulated) return `not simulated${because}`;
  return allowed ? `on${because}` : `switched off, the scene calls for it${because}`;
}

/** Milliseconds between which a cost lies, in steps of one digit of how far they are apart: nothing finer was measured. */
export function costText(low: number, high: number): string {
  const apart = high - low;
  if (!(apart > 0)) return high > 0 ? `costs ${Number(high.toPrecision(1))} ms` : '';
  const exponent = Math.floor(Math.log10(apart));
  const step = 10 ** exponent;
  const shown = (ms: number): string => (Math.round(ms / step) * step).toFixed(Math.max(0, -exponent));
  if (low <= 0 && high >= 0) return `costs less than ${shown(Math.ceil(Math.max(high, -low) / step) * step)} ms, or nothing`;
  return high < 0 ? `saves ${shown(-high)} to ${shown(-low)} ms` : `costs ${shown(low)} to ${shown(high)} ms`;
}

/** Whether it takes place in this scene, if the viewer lets it. */
export const possible = (row: EffectRow): boolean => row.simulated && (row.calledFor || row.choice);

/**
 * Rays of the last pass and measured cost, as far as they are known. `scale`: pixels of the view over those that were
 * measured.
 */
export function effectFigures(row: EffectRow, rays: Numbers | null, cost: EffectCost | null, scale = 1): string {
  const kind = RAY_KINDS[row.name];
  const shot = kind === undefined || rays === null ? undefined : rays[kind];
  const rayCount = (value: number): string => `${count(value)} ${value === 1 ? 'ray' : 'rays'}`;
  const parts = shot === undefined ? [] : [rayCount(shot)];
  if (cost !== null) {
    const more = Math.round(scale * (cost.raysOn - cost.raysOff));
    const text = costText(scale * cost.lowMs, scale * cost.highMs);
    if (text !== '') parts.push(text);
    if (more !== 0) parts.push(`${rayCount(Math.abs(more))} ${more > 0 ? 'more' : 'fewer'}`);
  }
  return parts.join(' · ');
}
