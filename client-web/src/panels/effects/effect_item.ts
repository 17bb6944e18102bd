// One effect in the effects panel: its switch or choice, why, rays and cost, and folded under it what else belongs to it.

import { el, icon, setText, uniqueId } from '../../page/dom.js';
import type { Viewer } from '../../viewer.js';
import type { SettingRow } from '../../wire/protocol.js';
import type { SettingField } from '../settings/settings_field.js';
import { elsewhere, showField, viewerField, type OtherPanel } from '../settings/viewer_field.js';
import { effectState, hasOwnSwitch, possible, type EffectRow } from './effect_rows.js';

export class EffectItem {
  readonly element: HTMLElement;
  private readonly state_ = el('p', { class: 'effect-state', id: uniqueId('effect') });
  private readonly figures_ = el('p', { class: 'effect-figures figure' });
  private readonly fields_ = new Map<SettingRow, SettingField>();
  private readonly fold_: HTMLDetailsElement;
  private readonly foldWords_ = el('span');

  constructor(
    public row: EffectRow,
    private readonly viewer_: Viewer,
    private readonly light_: OtherPanel,
    private readonly refresh_: () => void,
  ) {
    const head = this.head();
    const fields = row.settings.map((setting) => this.field(setting).element);
    const name = el('span', { class: 'sr-only' }, ` of ${row.label}`);
    const summary = el('summary', {}, el('span', {}, this.foldWords_, name), icon('chevron'));
    this.fold_ = el('details', { class: 'effect-settings' }, summary, el('div', { class: 'fields' }, ...fields));
    this.element = el('li', { class: 'effect', 'data-effect': row.name }, head, this.state_, this.figures_);
    if (fields.length > 0) this.element.append(this.fold_);
  }

  /** Unfolds what the setting stands in, and gives it the focus; false where it is not this effect's. */
  open(name: string): boolean {
    for (const [row, field] of this.fields_) {
      if (row.name !== name) continue;
      if (row !== this.row.setting) this.fold_.open = true;
      field.focus();
      return true;
    }
    return false;
  }

  show(allowed: boolean, figures: string): void {
    const { settings } = this.viewer_;
    this.element.classList.toggle('on', possible(this.row) && allowed);
    setText(this.state_, effectState(this.row, allowed));
    setText(this.figures_, figures);
    this.figures_.hidden = figures === '';
    for (const [row, field] of this.fields_) {
      showField(this.viewer_, row, field);
      field.element.classList.toggle('idle', !allowed && row !== this.row.setting);
    }
    const count = this.row.settings.length;
    const changed = this.row.settings.filter((row) => !settings.isDefault(row)).length;
    setText(this.foldWords_, `${count} ${count === 1 ? 'setting' : 'settings'}${changed === 0 ? '' : `, ${changed} changed`}`);
  }

  /** The control, where it stands here; else the name, and with what the effect is switched. */
  private head(): HTMLElement {
    const { row } = this;
    const { setting } = row;
    const own = hasOwnSwitch(row);
    if (setting !== null && own && !this.light_.has(setting)) return this.field(setting).element;
    return el(
      'div',
      { class: 'effect-head' },
      el('span', { class: 'effect-name', title: row.help }, row.label),
      el('span', { class: 'spacer' }),
      setting === null ? null : own ? this.lead(setting) : el('span', { class: 'effect-with' }, `with ${setting.label}`),
    );
  }

  private lead(setting: SettingRow): HTMLElement {
    const button = el('button', { type: 'button', class: 'effect-lead' }, elsewhere(this.light_, setting));
    button.addEventListener('click', () => this.light_.open(setting.name));
    return button;
  }

  private field(row: SettingRow): SettingField {
    const describedBy = row === this.row.setting ? this.state_.id : '';
    const field = viewerField(this.viewer_, row, this.refresh_, undefined, describedBy);
    this.fields_.set(row, field);
    return field;
  }
}
