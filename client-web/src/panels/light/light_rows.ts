// Which of the server's settings stand in the panel Light, a word for each of their choices, and when they count for
// nothing. Ranges, defaults and choices are the server's. Knows no DOM.

import type { SettingRow, SettingValue } from '../../wire/protocol.js';

/** In their order; what a server lacks is left out. */
const LIGHT_ROWS: readonly string[] = [
  'surroundings',
  'environmentRotation',
  'environmentStrength',
  'sun',
  'sunAzimuth',
  'sunElevation',
  'sunSize',
  'sunStrength',
  'ground',
  'background',
  'exposure',
  'autoExposure',
  'toneCurve',
];

export const isLightRow = ({ name }: Pick<SettingRow, 'name'>): boolean => LIGHT_ROWS.includes(name);

export function lightRows(rows: readonly SettingRow[]): readonly SettingRow[] {
  return rows.filter(isLightRow).sort((a, b) => LIGHT_ROWS.indexOf(a.name) - LIGHT_ROWS.indexOf(b.name));
}

const WORDS: Readonly<Record<string, Readonly<Record<string, string>>>> = {
  surroundings: { automatic: 'by scene', studio: 'lamps', sky: 'day', grey: 'even', none: 'dark' },
  background: { automatic: 'by scene', image: 'sharp', plain: 'one grey', blurred: 'soft' },
  autoExposure: { automatic: 'by scene', on: 'measured', off: 'by hand' },
  toneCurve: { automatic: 'by scene', neutral: 'true', filmic: 'contrast', aces: 'pale', linear: 'clips' },
};

/** As a tile has room for it. */
export const shortName = (choice: string): string => (choice === 'automatic' ? 'auto' : choice);

/** What a choice means, in a word or two; '' for one that this page does not know. */
export const wordOf = (setting: string, choice: string): string => WORDS[setting]?.[choice] ?? '';

const OF_SUN: readonly string[] = ['sunAzimuth', 'sunElevation', 'sunSize', 'sunStrength'];

/** Rows of what is off stay folded. */
export const lightRowFolded = (name: string, value: (name: string) => SettingValue | undefined): boolean =>
  OF_SUN.includes(name) && value('sun') !== true;

/** Why the setting changes nothing with the present values; null when it does. */
export function lightWithoutUse(
  name: string,
  value: (name: string) => SettingValue | undefined,
): string | null {
  const around = value('surroundings');
  if (name === 'environmentRotation' && around === 'grey') return 'Even light is the same from all sides.';
  if (around !== 'none') return null;
  if (name === 'environmentRotation' || name === 'environmentStrength') return 'Nothing stands around the scene.';
  return null;
}
