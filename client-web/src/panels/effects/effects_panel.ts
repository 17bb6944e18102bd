// The effects panel: which effects the scene calls for and why, with all their settings, the rays they shot and, on
// demand, the milliseconds they cost.

import { el, icon, setText, uniqueId } from '../../page/dom.js';
import { EffectItem } from './effect_item.js';
import { allows, effectFigures, effectRows, possible, sectionOf, type EffectRow, type Section } from './effect_rows.js';
import type { OtherPanel } from '../settings/viewer_field.js';
import type { Panel } from '../panel.js';
import { percent } from '../../page/format.js';
import { recall, remember } from '../../page/storage.js';
import type { SettingRow } from '../../wire/protocol.js';
import type { Viewer } from '../../viewer.js';
import './effects_panel.css';

/** In their order; the last ones are folded. */
const SECTIONS: readonly (readonly [Section, string])[] = [
  ['on', 'Called for by this scene'],
  ['notSimulated', 'Called for, not simulated'],
  ['choice', 'Yours to choose'],
  ['unknown', 'Not known before a scene is there'],
  ['idle', 'Of no use in this scene'],
];

export class EffectsPanel {
  private readonly button_ = el('button', { type: 'button', class: 'wide-button measure' });
  private readonly progress_ = el('progress', { max: 1, 'aria-label': 'Measuring', hidden: true });
  private readonly remark_ = el('p', { class: 'field-note', role: 'status' });
  private readonly error_ = el('p', { class: 'field-error', role: 'alert', hidden: true });
  private readonly lists_ = el('div');
  private items_: readonly EffectItem[] = [];
  private schema_: readonly SettingRow[] = [];
  private layout_ = '';

  constructor(
    private readonly panel_: Panel,
    private readonly viewer_: Viewer,
    private readonly light_: OtherPanel,
  ) {
    this.button_.addEventListener('click', () => viewer_.measuring.measureEffects());
    panel_.body.append(this.button_, this.progress_, this.error_, this.remark_, this.lists_);
    viewer_.on(['scene', 'hello', 'settings', 'stats', 'watching'], () => this.refresh());
    viewer_.on(['effectCosts', 'connection'], () => this.refreshCosts());
    this.refreshCosts();
  }

  /** Opens the panel at a setting. */
  open(name: string): void {
    this.panel_.setOpen(true);
    this.focus(name);
  }

  private focus(name: string): void {
    for (const item of this.items_) {
      const fold = item.element.closest<HTMLDetailsElement>('.idle-effects');
      const here = [item.row.setting, ...item.row.settings].some((row) => row?.name === name);
      if (fold !== null && here) fold.open = true; // else it takes no focus
      if (item.open(name)) return;
    }
  }

  private refresh(): void {
    const effects = this.viewer_.state.ready?.effects ?? [];
    this.arrange(effectRows(effects, this.viewer_.settings.rows));
    const can = this.items_.filter(({ row }) => possible(row));
    const on = can.filter(({ row }) => this.allowed(row)).length;
    setText(this.panel_.summary, effects.length === 0 ? 'no scene yet' : `${on} of ${can.length} on`);
    const rays = this.viewer_.state.stats?.rays ?? null;
    const { state } = this.viewer_.measuring.effects;
    const costs = state.name === 'ready' ? state.costs.rows : [];
    const scale = state.name === 'ready' ? state.costs.scale : 1;
    for (const item of this.items_) {
      const cost = costs.find((entry) => entry.name === item.row.name) ?? null;
      const allowed = this.allowed(item.row);
      // Rays of the kind that something else shot (ground needs occlusion rays) are not those of what is off.
      item.show(allowed, effectFigures(item.row, allowed ? rays : null, cost, scale));
    }
  }

  private allowed(row: EffectRow): boolean {
    if (row.setting === null) return true;
    const value = this.viewer_.settings.value(row.setting.name);
    return row.setting.type === 'choice' ? value !== row.setting.choices[0] : allows(value);
  }

  /** Rows that stay where they are keep what is being typed, and the focus. */
  private arrange(rows: readonly EffectRow[]): void {
    const schema = this.viewer_.settings.rows;
    const layout = rows.map((row) => `${row.name} ${sectionOf(row)} ${row.setting?.name}`).join();
    if (layout === this.layout_ && schema === this.schema_) {
      this.items_.forEach((item, i) => (item.row = rows[i] ?? item.row));
      return;
    }
    [this.layout_, this.schema_] = [layout, schema];
    const open = this.lists_.querySelectorAll('.effect-settings[open]');
    const unfolded = [...open].map((fold) => fold.closest<HTMLElement>('.effect')?.dataset['effect']);
    const focused = document.activeElement?.closest<HTMLElement>('#effects-panel [data-setting]')?.dataset['setting'];
    this.items_ = rows.map((row) => new EffectItem(row, this.viewer_, this.light_, () => this.refresh()));
    this.lists_.replaceChildren(...SECTIONS.map(([name, title]) => this.section(name, title)));
    for (const { row, element } of this.items_) {
      const fold = element.querySelector('details');
      if (fold !== null) fold.open = unfolded.includes(row.name);
    }
    if (focused !== undefined) this.focus(focused);
  }

  private section(name: Section, title: string): HTMLElement | string {
    const items = this.items_.filter(({ row }) => sectionOf(row) === name).map(({ element }) => element);
    if (items.length === 0) return '';
    const id = uniqueId('effects');
    const list = el('ul', { 'aria-labelledby': id }, ...items);
    if (name !== 'idle') return el('section', {}, el('h3', { id }, title), list);
    const summary = el('summary', {}, el('span', { id }, `${title}: ${items.length}`), icon('chevron'));
    const details = el('details', { class: 'idle-effects', open: recall('effects.idle') === 'open' }, summary, list);
    details.addEventListener('toggle', () => remember('effects.idle', details.open ? 'open' : 'folded'));
    return details;
  }

  private refreshCosts(): void {
    const { state } = this.viewer_.measuring.effects;
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
