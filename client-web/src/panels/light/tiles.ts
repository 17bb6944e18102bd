// A choice of few: each stands there with a small picture and a word, as radio buttons that arrows and fingers reach.

import { drawn, el } from '../../page/dom.js';
import type { SettingRow } from '../../wire/protocol.js';
import type { ControlMaker } from '../settings/settings_field.js';
import { shortName, wordOf } from './light_rows.js';

/** Display over scene brightness, 40 x 24: how each curve goes. */
const CURVES: Readonly<Record<string, string>> = {
  automatic: 'M3 21L8 18M12 15.6L17 12.6M21 10.2L26 7.6M30 5.6L35 4',
  neutral: 'M3 21L23 7.5C28 4.4 32 3.6 37 3.2',
  filmic: 'M3 21C11 20 13 8.5 20 6C26 4 32 3.5 37 3.2',
  aces: 'M3 21C9 20.5 11 6 18 4.4C25 3.3 31 3.1 37 3',
  linear: 'M3 21L29 3H37',
};

/** A small picture of the choice, or null where a word says it better. */
function pictureOf(setting: string, choice: string): Element | null {
  if (setting === 'surroundings' || setting === 'background')
    return el('span', { class: `thumb ${setting} ${choice}`, 'aria-hidden': 'true' });
  if (setting !== 'toneCurve') return null;
  const curve = CURVES[choice];
  return drawn(
    'svg',
    { viewBox: '0 0 40 24', class: 'thumb curve', 'aria-hidden': 'true' },
    curve === undefined ? null : drawn('path', { d: curve }),
  );
}

function tile(row: SettingRow, choice: string, input: HTMLInputElement): HTMLElement {
  const word = wordOf(row.name, choice);
  return el(
    'label',
    { class: 'tile' },
    input,
    pictureOf(row.name, choice) as HTMLElement | null,
    el('span', { class: 'tile-label' }, shortName(choice)),
    word === '' ? null : el('span', { class: 'tile-word' }, word),
  );
}

export const tilesControl: ControlMaker = (row, id, hooks) => {
  const inputs = row.choices.map((choice) => el('input', { type: 'radio', name: id, value: choice }));
  const tiles = inputs.map((input) => tile(row, input.value, input));
  const attributes = { class: 'tiles', role: 'radiogroup', id, 'aria-labelledby': `${id}-label` };
  const group = el('div', attributes, ...tiles);
  group.addEventListener('change', ({ target }) => {
    if (target instanceof HTMLInputElement) hooks.changed(target.value);
  });
  return {
    control: group,
    inline: [],
    below: [group],
    show: (value) => inputs.forEach((input) => (input.checked = input.value === value)),
    focus: () => (inputs.find(({ checked }) => checked) ?? inputs[0])?.focus(),
  };
};
