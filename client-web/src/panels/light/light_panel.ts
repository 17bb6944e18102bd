// What lights the scene and how bright it is shown: the server's settings of light, each with a control of its kind.

import { el, iconButton, setText } from '../../page/dom.js';
import { exposureText } from '../../picture/exposure_text.js';
import type { Viewer } from '../../viewer.js';
import type { SettingRow } from '../../wire/protocol.js';
import type { Panel } from '../panel.js';
import { sliderControl, type ControlMaker, type SettingField } from '../settings/settings_field.js';
import { POWER_SCALE } from '../settings/slider_scale.js';
import { showField, viewerField } from '../settings/viewer_field.js';
import { dialControl } from './dial.js';
import { lightRowFolded, lightRows, lightWithoutUse } from './light_rows.js';
import { LOG_SCALE, TURN_SCALE } from './light_scale.js';
import { tilesControl } from './tiles.js';
import './light_panel.css';

/** Of numbers; choices are tiles. */
const CONTROLS: Readonly<Record<string, ControlMaker>> = {
  environmentRotation: dialControl('Or Alt and drag on the picture, or the keys [ and ].'),
  environmentStrength: sliderControl(LOG_SCALE),
  sunAzimuth: dialControl('From above, the viewer below. Turns with the surroundings, too.', true),
  sunElevation: sliderControl(TURN_SCALE),
  sunStrength: sliderControl(LOG_SCALE),
};

export class LightPanel {
  private readonly fields_ = new Map<string, SettingField>();
  private rows_: readonly SettingRow[] = [];
  private readonly reset_ = iconButton('reset', 'Reset the light', '', 'wide-button');

  constructor(
    private readonly panel_: Panel,
    private readonly viewer_: Viewer,
  ) {
    panel_.body.append(el('p', { class: 'muted' }, 'The light appears when the server answers.'));
    this.reset_.addEventListener('click', () => this.reset());
    viewer_.on(['hello'], () => this.build());
    viewer_.on(['settings', 'watching'], () => this.refresh());
    viewer_.on(['stats'], () => this.refreshExposure());
  }

  /** Opens the panel at a setting; at the sun's switch where what belongs to it is folded. */
  open(name: string): void {
    this.panel_.setOpen(true);
    const folded = lightRowFolded(name, (setting) => this.viewer_.settings.value(setting));
    this.fields_.get(folded ? 'sun' : name)?.focus();
  }

  private build(): void {
    this.rows_ = lightRows(this.viewer_.settings.rows);
    this.fields_.clear();
    for (const row of this.rows_) this.fields_.set(row.name, this.field(row));
    const elements = [...this.fields_.values()].map(({ element }) => element);
    if (elements.length === 0) {
      this.panel_.body.replaceChildren(el('p', { class: 'muted' }, 'This server offers nothing to set here.'));
      return;
    }
    this.panel_.body.replaceChildren(el('div', { class: 'fields light-fields' }, ...elements), this.reset_);
    this.refresh();
  }

  private field(row: SettingRow): SettingField {
    const make = row.type === 'choice' ? tilesControl : CONTROLS[row.name];
    const control = make ?? (row.type === 'bool' ? undefined : sliderControl(POWER_SCALE));
    return viewerField(this.viewer_, row, () => this.refresh(), control);
  }

  private refresh(): void {
    const model = this.viewer_.settings;
    let differing = 0;
    for (const row of this.rows_) {
      const field = this.fields_.get(row.name);
      if (field === undefined) continue;
      const reason = lightWithoutUse(row.name, (name) => model.value(name));
      if (!model.isDefault(row)) differing += 1;
      showField(this.viewer_, row, field);
      field.setNote(reason);
      field.element.classList.toggle('idle', reason !== null);
      field.element.hidden = lightRowFolded(row.name, (name) => model.value(name));
    }
    this.reset_.disabled = differing === 0 || this.viewer_.watching.active;
    setText(this.panel_.summary, differing === 0 ? '' : `${differing} changed`);
    this.refreshExposure();
  }

  /** What the picture chose for itself, and what is added to it. */
  private refreshExposure(): void {
    const chosen = this.viewer_.state.stats?.autoExposure ?? null;
    const off = this.viewer_.settings.value('autoExposure') === 'off';
    const text = off ? null : chosen === null ? 'Not used in this view.' : `Now ${exposureText(chosen)}, the exposure above is added.`;
    this.fields_.get('autoExposure')?.setNote(text);
  }

  private reset(): void {
    const { settings } = this.viewer_;
    const focused = document.activeElement === this.reset_;
    this.viewer_.setSettings(Object.fromEntries(this.rows_.map((row) => [row.name, settings.default(row)])));
    if (focused) this.fields_.get(this.rows_[0]?.name ?? '')?.focus(); // the button is off now
  }
}
