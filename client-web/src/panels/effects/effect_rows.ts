// What the effects panel says of each effect: whether the scene calls for it, whether the viewer allows it, what it did
// and what it costs; and which settings stand with it. Knows no DOM.

import type { Numbers } from '../../wire/fields.js';
import { count } from '../../page/format.js';
import type { EffectCost } from '../../wire/effect_costs_message.js';
import type { EffectReason, SettingRow, SettingValue } from '../../wire/protocol.js';
import { spacedWords } from '../../page/scene_name.js';
import { isLightRow } from '../light/light_rows.js';

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
  readonly said: boolean; // by the scene; else nothing but the settings speak of it
  readonly because: string;
  readonly simulated: boolean;
  /** The setting that allows it; null: nothing can forbid it. Another effect's, where that is its `effect`. */
  readonly setting: SettingRow | null;
  /** What else belongs to it, and stands in no other panel. */
  readonly settings: readonly SettingRow[];
}

/** Settings that stand in the effects panel. */
export const isEffectRow = (row: SettingRow): boolean => row.effect !== '' && !isLightRow(row);

/** Whether the setting that allows the effect is its own, not another one's that it goes with. */
export const hasOwnSwitch = ({ name, setting }: EffectRow): boolean => setting?.effect === name;

export type Section = 'on' | 'notSimulated' | 'choice' | 'idle' | 'unknown';

/** Where it stands. `unknown`: the settings speak of it, and no scene has yet. */
export function sectionOf({ calledFor, simulated, choice, said }: EffectRow): Section {
  if (calledFor) return simulated ? 'on' : 'notSimulated';
  return choice && simulated ? 'choice' : said ? 'idle' : 'unknown';
}

/**
 * One row per effect: what the scene calls for, what the viewer chooses, the rest; else in the server's order. Effects of
 * which only the settings speak stand last.
 */
export function effectRows(effects: readonly EffectReason[], schema: readonly SettingRow[]): readonly EffectRow[] {
  const named = new Set(effects.map(({ name }) => name));
  const unsaid = new Set(schema.filter((row) => isEffectRow(row) && !named.has(row.effect)).map(({ effect }) => effect));
  const rows = effects.map((effect) => effectRow(effect, schema, true));
  for (const name of unsaid) {
    const setting = schema.find((row) => row.effect === name && typeof row.default !== 'number')?.name ?? '';
    const nothing = { calledFor: false, choice: false, because: '', help: '', simulated: true };
    rows.push(effectRow({ name, setting, ...nothing }, schema, false));
  }
  const rank = (row: EffectRow): number => (row.calledFor ? 0 : row.choice ? 1 : 2);
  return rows.sort((a, b) => rank(a) - rank(b));
}

function effectRow(effect: EffectReason, schema: readonly SettingRow[], said: boolean): EffectRow {
  const { name, calledFor, choice, because, help, simulated } = effect;
  const setting = schema.find((row) => row.name === effect.setting) ?? null;
  const own = setting !== null && setting.name === name && setting.type === 'bool';
  const label = own ? setting.label : capitalised(spacedWords(name));
  const settings = schema.filter((row) => row.effect === name && row !== setting && isEffectRow(row));
  return { name, label, help, calledFor, choice, said, because, simulated, setting, settings };
}

const capitalised = (text: string): string => text.charAt(0).toUpperCase() + text.slice(1);

/** Whether a setting with this value lets its effect happen: a switch that is on, a number above 0. */
export const allows = (value: SettingValue | undefined): boolean => value !== false && value !== 0;

/** Whether an effect takes place, and why. */
export function effectState(row: EffectRow, allowed: boolean): string {
  const because = row.because === '' ? '' : `: ${row.because}`;
  if (!row.said) return '';
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
