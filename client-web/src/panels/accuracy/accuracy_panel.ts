// The accuracy panel: has the server measure the view, shows error against time of every setting, and sets what is chosen.

import { el, icon, setText } from '../../page/dom.js';
import { percent } from '../../page/format.js';
import { displayName } from '../../page/scene_name.js';
import { recall, remember } from '../../page/storage.js';
import type { Viewer } from '../../viewer.js';
import type { Accuracy, AccuracyRow } from '../../wire/accuracy_message.js';
import type { Panel } from '../panel.js';
import { AccuracyList } from './accuracy_list.js';
import type { AccuracyState, Measured } from './accuracy_model.js';
import { AccuracyPlot } from './accuracy_plot.js';
import { changeWords, factWords, givenRow, rowNow, rowWords, settingWords, valuesFor } from './accuracy_rows.js';
import { Wipe } from './wipe.js';

const SECONDS = [10, 30, 120];
const SECONDS_KEY = 'accuracy.seconds';
const HINT = 'Choose a row to see the view with its settings.';

export class AccuracyPanel {
  private readonly seconds_ = el('select', { 'aria-label': 'How long to measure' });
  private readonly button_ = el('button', { type: 'button', class: 'wide-button measure' });
  private readonly progress_ = el('progress', { max: 1, 'aria-label': 'Measuring', hidden: true });
  private readonly what_ = el('p', { class: 'field-note' });
  private readonly status_ = el('p', { class: 'field-note', role: 'status' });
  private readonly error_ = el('p', { class: 'field-error', role: 'alert' });
  private readonly facts_ = el('p', { class: 'field-note' });
  private readonly changed_ = el('p', { class: 'accuracy-changed' });
  private readonly words_ = el('p', { class: 'accuracy-words' });
  private readonly back_ = el('button', { type: 'button', class: 'wide-button' }, icon('reset'), 'As it was');
  private readonly plot_: AccuracyPlot;
  private readonly list_: AccuracyList;
  private readonly wipe_ = new Wipe();
  private readonly result_: HTMLElement;
  private shown_: Measured | null = null;
  private looked_: AccuracyRow | null = null;
  private marked_: readonly (AccuracyRow | null)[] = [];

  constructor(
    private readonly panel_: Panel,
    private readonly viewer_: Viewer,
  ) {
    const hooks = {
      look: (row: AccuracyRow) => this.look(row),
      leave: (row: AccuracyRow) => this.looked_ === row && this.look(null),
      choose: (row: AccuracyRow) => this.choose(row),
    };
    this.plot_ = new AccuracyPlot(hooks);
    this.list_ = new AccuracyList(hooks);
    this.seconds_.append(...SECONDS.map((seconds) => el('option', { value: seconds }, `about ${seconds} s`)));
    this.seconds_.value = SECONDS.map(String).find((seconds) => seconds === recall(SECONDS_KEY)) ?? '30';
    this.seconds_.addEventListener('change', () => remember(SECONDS_KEY, this.seconds_.value));
    this.button_.addEventListener('click', () => this.press());
    this.back_.addEventListener('click', () => this.chooseGiven());
    this.result_ = el('section', { class: 'accuracy-result', 'aria-label': 'What was measured', hidden: true });
    this.result_.append(this.changed_, this.plot_.element, this.words_, this.back_, this.list_.element);
    this.result_.append(this.wipe_.element, this.facts_);
    const controls = el('div', { class: 'accuracy-controls' }, this.button_, this.seconds_);
    panel_.body.append(controls, this.progress_, this.what_, this.status_, this.error_, this.result_);
    viewer_.on(['accuracy', 'connection', 'watching', 'scene'], () => this.refresh());
    viewer_.on(['settings', 'camera', 'resolution'], () => this.mark());
    panel_.onToggle(() => this.mark());
    this.refresh();
  }

  private press(): void {
    const { accuracy } = this.viewer_.measuring;
    if (this.button_.getAttribute('aria-disabled') === 'true') return;
    if (accuracy.waits) accuracy.giveUp();
    else this.viewer_.measuring.measureView(Number(this.seconds_.value));
  }

  private refresh(): void {
    const { state, measured, waits } = this.viewer_.measuring.accuracy;
    const { connection, ready } = this.viewer_.state;
    const watches = this.viewer_.watching.active;
    const ending = state.name === 'ending';
    const label = ending ? 'Giving up …' : waits ? 'Give up' : measured === null ? 'Measure this view' : 'Measure again';
    if (this.button_.textContent !== label) this.button_.replaceChildren(icon(waits ? 'stop' : 'clock'), label);
    const able = waits ? !ending : connection.name === 'open' && ready !== null && !watches;
    this.button_.setAttribute('aria-disabled', String(!able)); // one that is disabled would lose the focus
    this.seconds_.disabled = waits;
    this.progress_.hidden = !waits;
    this.progress_.value = state.name === 'measuring' ? state.share : 0;
    const schema = this.viewer_.settings.rows;
    setText(this.what_, state.name === 'measuring' ? settingWords(state.what, schema) : '');
    setText(this.status_, statusWords(state, measured, watches));
    setText(this.error_, state.name === 'ended' && state.wrong ? state.text : '');
    setText(this.panel_.summary, summaryWords(state, measured));
    if (measured !== this.shown_) this.show(measured);
  }

  private show(measured: Measured | null): void {
    this.shown_ = measured;
    this.looked_ = null;
    this.marked_ = [];
    this.result_.hidden = measured === null;
    if (measured === null) return;
    setText(this.facts_, factWords(measured));
    this.plot_.draw(measured);
    this.list_.show(measured, this.viewer_.settings.rows);
    this.wipe_.show(measured.accuracy);
    this.mark();
  }

  private look(row: AccuracyRow | null): void {
    if (row === this.looked_) return;
    this.looked_ = row;
    this.mark();
  }

  private choose(row: AccuracyRow): void {
    if (this.shown_ === null) return;
    const values = valuesFor(row, this.shown_, (name) => this.viewer_.settings.value(name));
    if (Object.keys(values).length > 0) this.viewer_.setSettings(values);
  }

  private chooseGiven(): void {
    const given = this.shown_ === null ? null : givenRow(this.shown_.accuracy);
    if (given !== null) this.choose(given);
  }

  /** Shows which row is that of now, which one is looked at, and what of the view has changed. */
  private mark(): void {
    if (this.shown_ === null || !this.panel_.isOpen) return;
    const { settings, controller, state, watching } = this.viewer_;
    const now = rowNow(this.shown_, (name) => settings.value(name));
    const [looked, before] = this.marked_;
    if (looked !== this.looked_ || before !== now) {
      this.marked_ = [this.looked_, now];
      this.plot_.mark(this.looked_, now);
      this.list_.mark(this.looked_, now);
    }
    const row = this.looked_ ?? now;
    setText(this.words_, row === null ? HINT : rowWords(row, this.shown_, settings.rows));
    const given = givenRow(this.shown_.accuracy);
    this.back_.setAttribute('aria-disabled', String(given === null || now === given || watching.active));
    const view = { camera: controller.camera, values: settings.values(), size: state.resolution };
    setText(this.changed_, changeWords(this.shown_, view, settings.rows));
  }
}

/** Said once for each change, not for each step: a screen reader hears it. */
function statusWords(state: AccuracyState, measured: Measured | null, watches: boolean): string {
  if (state.name === 'asked') return 'Asked; the server has not begun yet.';
  if (state.name === 'measuring') return 'Measuring the view as it was when asked.';
  if (state.name === 'ended' && !state.wrong) return state.text;
  if (watches) return 'Only who drives this view may have it measured.';
  if (state.name === 'ready' && measured !== null) return doneWords(measured.accuracy);
  if (state.name !== 'idle') return '';
  return 'Turns each setting of this view, and tells what it costs in time and how far from exact the picture is.';
}

function doneWords({ scene, device, width, height, rows }: Accuracy): string {
  return `${displayName(scene)} on ${device}, ${width} × ${height} pixels: ${rows.length} rows.`;
}

function summaryWords(state: AccuracyState, measured: Measured | null): string {
  if (state.name === 'measuring') return percent(state.share);
  return measured === null ? '' : 'measured';
}
