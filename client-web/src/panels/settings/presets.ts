// Settings that go together, as one table of values, and which rows of the form a search leaves. Knows no DOM.

import type { SettingRow, SettingValue, SettingValues } from '../../wire/protocol.js';

export interface Preset {
  readonly name: string;
  readonly label: string;
  /** Beside the server's own values of all other rows; a row that the server lacks is left out. */
  readonly values: SettingValues;
}

/** Balanced is what the server starts with. */
export const PRESETS: readonly Preset[] = [
  {
    name: 'fast',
    label: 'Fast',
    values: {
      renderScale: 0.5, samples: 16, softShadows: false, shadowSamples: 1, maxReflections: 1, maxRefractions: 3,
      glossyReflections: false, ambientOcclusion: false, indirectLight: false, contributionThreshold: 0.02,
    },
  },
  { name: 'balanced', label: 'Balanced', values: {} },
  {
    name: 'exact',
    label: 'Exact',
    values: {
      renderScale: 1, automaticScale: false, samples: 1024, softShadows: true, shadowSamples: 4, maxReflections: 8,
      maxRefractions: 12, glossyReflections: true, indirectLight: true, textureFilter: 'anisotropic',
      contributionThreshold: 0, exactAtRest: true, denoiser: 'off',
    },
  },
];

/** What only the picture's look or the machine decides is no preset's: it stays as the viewer set it. */
const touched = new Set(PRESETS.flatMap(({ values }) => Object.keys(values)));

/** The values that a preset gives to every row that any preset speaks of. */
export function presetValues(
  preset: Preset,
  rows: readonly SettingRow[],
  start: (row: SettingRow) => SettingValue,
): SettingValues {
  const spoken = rows.filter((row) => touched.has(row.name));
  return Object.fromEntries(spoken.map((row) => [row.name, within(row, preset.values[row.name] ?? start(row))]));
}

/** A server's limits may be tighter than the table. */
const within = (row: SettingRow, value: SettingValue): SettingValue =>
  typeof value === 'number' ? Math.min(Math.max(value, row.low), row.high) : value;

/** The preset whose values all are, or null. Numbers are compared as the server keeps them. */
export function presetOf(
  rows: readonly SettingRow[],
  start: (row: SettingRow) => SettingValue,
  value: (name: string) => SettingValue | undefined,
): Preset | null {
  const same = (a: SettingValue | undefined, b: SettingValue): boolean =>
    typeof a === 'number' && typeof b === 'number' ? Math.fround(a) === Math.fround(b) : a === b;
  const fits = (preset: Preset): boolean =>
    Object.entries(presetValues(preset, rows, start)).every(([name, wanted]) => same(value(name), wanted));
  return [...PRESETS].sort((a) => (a.name === 'balanced' ? -1 : 1)).find(fits) ?? null;
}

/** Whether every word stands in the row's name, label or help. */
export function matches(row: SettingRow, search: string): boolean {
  const text = `${row.name} ${row.label} ${row.help}`.toLowerCase();
  return search.toLowerCase().split(/\s+/).every((word) => text.includes(word));
}
