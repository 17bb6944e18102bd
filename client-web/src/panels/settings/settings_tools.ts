// Above the rows: presets, a search over them, and what differs from the preset.

import { el, setText } from '../../page/dom.js';
import type { SettingRow } from '../../wire/protocol.js';
import { PRESETS, type Preset } from './presets.js';
import { elsewhere, type OtherPanel } from './viewer_field.js';

export class SettingsTools {
  readonly element: HTMLElement;
  private readonly presets_ = el('select', { 'aria-label': 'Preset' });
  private readonly own_ = el('option', { value: '', disabled: true }, 'Own choice');
  private readonly search_ = el('input', { type: 'search', placeholder: 'Find a setting', 'aria-label': 'Find a setting' });
  private readonly differing_ = el('button', { type: 'button', class: 'differing', 'aria-pressed': 'false' });
  private readonly none_ = el('p', { class: 'field-note', role: 'status' });

  private readonly elsewhere_ = el('div', { class: 'elsewhere' });
  private elsewhereNames_ = '';

  constructor(
    choose: (preset: Preset) => void,
    filtered: () => void,
  ) {
    this.presets_.append(...PRESETS.map(({ name, label }) => el('option', { value: name }, label)), this.own_);
    this.presets_.addEventListener('change', () => {
      const preset = PRESETS.find(({ name }) => name === this.presets_.value);
      if (preset !== undefined) choose(preset);
    });
    this.search_.addEventListener('input', filtered);
    this.search_.addEventListener('keydown', (event) => {
      if (event.key !== 'Escape' || this.search_.value === '') return;
      event.stopPropagation(); // the first one clears the search, the next one leaves the panel
      this.search_.value = '';
      filtered();
    });
    this.differing_.addEventListener('click', () => {
      this.differing_.setAttribute('aria-pressed', String(!this.onlyDiffering));
      filtered();
    });
    const line = el('div', { class: 'settings-tools' }, this.presets_, this.differing_);
    this.element = el('div', {}, line, this.search_, this.none_, this.elsewhere_);
  }

  get search(): string {
    return this.search_.value.trim();
  }

  get onlyDiffering(): boolean {
    return this.differing_.getAttribute('aria-pressed') === 'true';
  }

  /** Rows that are meant and stand in other panels, as buttons that lead there. */
  showElsewhere(rows: readonly (readonly [OtherPanel, SettingRow])[]): void {
    const names = rows.map(([, { name }]) => name).join();
    if (names === this.elsewhereNames_) return;
    this.elsewhereNames_ = names;
    const buttons = rows.map(([panel, row]) => {
      const button = el('button', { type: 'button', class: 'wide-button' }, elsewhere(panel, row));
      button.addEventListener('click', () => panel.open(row.name));
      return button;
    });
    this.elsewhere_.replaceChildren(...buttons);
  }

  /** `preset`: that all values are of, or null; `differing`: rows that are not as the server or the preset has them. */
  show(preset: Preset | null, differing: number, shown: number, disabled: boolean): void {
    this.presets_.value = preset?.name ?? '';
    this.presets_.disabled = disabled;
    setText(this.differing_, `${differing} changed`);
    setText(this.none_, shown === 0 ? 'No such setting.' : '');
  }
}
