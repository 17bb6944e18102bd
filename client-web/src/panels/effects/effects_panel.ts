// The effects panel: which effects the scene calls for and why, a switch for those that have one, the rays they shot and,
// on demand, the milliseconds they cost.

import { el, icon, setText, uniqueId } from '../../page/dom.js';
import { allows, effectFigures, effectRows, effectState, possible, type EffectRow } from './effect_rows.js';
import type { Panel } from '../panel.js';
import { percent } from '../../page/format.js';
import { recall, remember } from '../../page/storage.js';
import type { EffectReason, SettingRow } from '../../wire/protocol.js';
import type { Viewer } from '../../viewer.js';
import './effects_panel.css';

export class EffectsPanel {
  private readonly button_ = el('button', { type: 'button', class: 'wide-button measure' });
  private readonly progress_ = el('progress', { max: 1, 'aria-label': 'Measuring', hidden: true });
  private readonly remark_ = el('p', { class: 'field-note', role: 'status' });
  private readonly error_ = el('p', { class: 'field-error', role: 'alert', hidden: true });
  private readonly lists_ = el('div');
  private items_: readonly EffectItem[] = [];
  private builtOf_: readonly [readonly EffectReason[], readonly SettingRow[]] | null = null;

  constructor(
    private readonly panel_: Panel,
    private readonly viewer_: Viewer,
  ) {
    this.button_.addEventListener('click', () => viewer_.measureEffects());
    panel_.body.append(this.button_, this.progress_, this.error_, this.remark_, this.lists_);
    viewer_.on(['scene', 'hello', 'settings', 'stats'], () => this.refresh());
    viewer_.on(['effectCosts', 'connection'], () => this.refreshCosts());
    panel_.onToggle(() => this.refresh());
    this.refreshCosts();
  }

  private refresh(): void {
    const effects = this.viewer_.state.ready?.effects ?? [];
    const schema = this.viewer_.settings.rows;
    if (this.builtOf_?.[0] !== effects || this.builtOf_[1] !== schema) this.build(effects, schema);
    const can = this.items_.filter(({ row }) => possible(row));
    const on = can.filter(({ row }) => this.allowed(row)).length;
    setText(this.panel_.summary, effects.length === 0 ? 'no scene yet' : `${on} of ${can.length} on`);
    if (!this.panel_.isOpen) return;
    const rays = this.viewer_.state.stats?.rays ?? null;
    const { state } = this.viewer_.effectCosts;
    const costs = state.name === 'ready' ? state.costs.rows : [];
    const scale = state.name === 'ready' ? state.costs.scale : 1;
    for (const item of this.items_) {
      const cost = costs.find((entry) => entry.name === item.row.name) ?? null;
      item.show(this.allowed(item.row), effectFigures(item.row, rays, cost, scale));
    }
  }

  private allowed(row: EffectRow): boolean {
    if (row.setting === null) return true;
    const value = this.viewer_.settings.value(row.setting.name);
    return row.setting.type === 'choice' ? value !== row.setting.choices[0] : allows(value);
  }

  private build(effects: readonly EffectReason[], schema: readonly SettingRow[]): void {
    this.builtOf_ = [effects, schema];
    this.items_ = effectRows(effects, schema).map(
      (row) => new EffectItem(row, (setting, value) => this.viewer_.setSettings({ [setting]: value })),
    );
    const list = (title: string, belongs: (row: EffectRow) => boolean): HTMLElement | string => {
      const items = this.items_.filter(({ row }) => belongs(row)).map((item) => item.element);
      const id = uniqueId('effects');
      return items.length === 0
        ? ''
        : el('section', {}, el('h3', { id }, title), el('ul', { 'aria-labelledby': id }, ...items));
    };
    this.lists_.replaceChildren(
      list('Called for by this scene', (row) => row.calledFor && row.simulated),
      list('Called for, not simulated', (row) => row.calledFor && !row.simulated),
      list('Yours to choose', (row) => row.choice && row.simulated),
      folded(list('Of no use in this scene', (row) => !row.calledFor && !row.choice)),
    );
  }

  private refreshCosts(): void {
    const { state } = this.viewer_.effectCosts;
    const measuring = state.name === 'measuring';
    const label = measuring
      ? `Measuring … ${percent(state.share)}`
      : state.name === 'ready'
        ? 'Measure again'
        : 'Measure what each costs';
    if (this.button_.textContent !== label) this.button_.replaceChildren(icon('clock'), label);
    this.button_.disabled = measuring || this.viewer_.state.connection.name !== 'open';
    this.progress_.hidden = !measuring;
    this.progress_.value = measuring ? state.share : 0;
    this.error_.hidden = state.name !== 'failed';
    setText(this.error_, state.name === 'failed' ? state.message : '');
    const { device, width, height, scale } =
      state.name === 'ready' ? state.costs : { device: '', width: 0, height: 0, scale: 1 };
    const scaled = scale > 1 ? '; for one sample a pixel of this view' : '';
    const measured = `Measured on ${device} at ${width} × ${height} pixels, in pairs of frames with and without each effect${scaled}.`;
    setText(this.remark_, state.name === 'ready' ? measured : '');
    this.refresh();
  }
}

/** What does nothing now takes one line until it is opened. */
function folded(section: HTMLElement | string): HTMLElement | string {
  if (typeof section === 'string') return section;
  const rows = section.querySelectorAll('li').length;
  const summary = el('summary', {}, el('span', {}, `Of no use in this scene: ${rows}`), icon('chevron'));
  section.querySelector('h3')?.setAttribute('hidden', ''); // the summary says it
  const details = el('details', { class: 'idle-effects', open: recall('effects.idle') === 'open' }, summary, section);
  details.addEventListener('toggle', () => remember('effects.idle', details.open ? 'open' : 'folded'));
  return details;
}

/** One effect in the list. */
class EffectItem {
  readonly element: HTMLElement;
  private readonly state_ = el('p', { class: 'effect-state' });
  private readonly figures_ = el('p', { class: 'effect-figures figure' });
  private readonly switch_: HTMLInputElement | null;

  constructor(
    readonly row: EffectRow,
    set: (setting: string, value: boolean) => void,
  ) {
    const { setting } = row;
    this.state_.id = uniqueId('effect');
    this.switch_ = setting?.type === 'bool' ? this.buildSwitch(setting, set) : null;
    const shared = setting !== null && setting.name !== row.name;
    this.element = el(
      'li',
      { class: 'effect', 'data-effect': row.name },
      el(
        this.switch_ === null ? 'div' : 'label', // touching anywhere in the line switches
        { class: 'effect-head' },
        el('span', { class: 'effect-name', title: row.help }, row.label),
        el('span', { class: 'spacer' }),
        shared ? el('span', { class: 'effect-with' }, `with ${setting.label}`) : null,
        this.switch_,
      ),
      this.state_,
      this.figures_,
    );
  }

  show(allowed: boolean, figures: string): void {
    if (this.switch_ !== null) this.switch_.checked = allowed;
    const on = possible(this.row) && allowed;
    this.element.classList.toggle('on', on);
    setText(this.state_, effectState(this.row, allowed));
    setText(this.figures_, figures);
    this.figures_.hidden = figures === '';
  }

  private buildSwitch(setting: SettingRow, set: (setting: string, value: boolean) => void): HTMLInputElement {
    const label = setting.name === this.row.name ? this.row.label : `${this.row.label}, switched with ${setting.label}`;
    const input = el('input', {
      type: 'checkbox',
      role: 'switch',
      class: 'switch',
      'aria-label': label,
      'aria-describedby': this.state_.id,
    });
    input.addEventListener('change', () => set(setting.name, input.checked));
    return input;
  }
}
