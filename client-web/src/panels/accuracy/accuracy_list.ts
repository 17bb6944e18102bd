// The price list: each row that was measured with its time, error and difference to the eye; a press chooses it.

import { el, icon, setText } from '../../page/dom.js';
import { percent, UNKNOWN } from '../../page/format.js';
import type { AccuracyRow } from '../../wire/accuracy_message.js';
import type { SettingRow } from '../../wire/protocol.js';
import type { Measured } from './accuracy_model.js';
import type { RowHooks } from './accuracy_plot.js';
import { bestRows, frameTime, otherRows, rowName, rowWords } from './accuracy_rows.js';

const HEADS = ['Time', 'Error', 'FLIP'];

interface Entry {
  readonly row: AccuracyRow;
  readonly line: HTMLElement;
  readonly button: HTMLButtonElement;
}

export class AccuracyList {
  readonly element: HTMLElement;
  private readonly best_ = el('table', { class: 'accuracy-list' });
  private readonly others_ = el('table', { class: 'accuracy-list' });
  private readonly count_ = el('span');
  private readonly fold_: HTMLDetailsElement;
  private entries_: readonly Entry[] = [];

  constructor(private readonly hooks_: RowHooks) {
    this.fold_ = el('details', {}, el('summary', {}, this.count_, icon('chevron')), this.others_);
    this.element = el('div', {}, this.best_, this.fold_);
  }

  show(measured: Measured, schema: readonly SettingRow[]): void {
    const { accuracy } = measured;
    const best = bestRows(accuracy).map((row) => this.entry(row, rowName(row, schema), measured, schema));
    const groups = otherRows(accuracy, schema).map(({ title, rows }) => {
      // Under its heading a row says its value alone.
      const named = (row: AccuracyRow): string => (row.knob === 'combination' ? rowName(row, schema) : row.value);
      return { title, entries: rows.map((row) => this.entry(row, named(row), measured, schema)) };
    });
    const others = groups.flatMap(({ entries }) => entries);
    this.entries_ = [...best, ...others];
    this.best_.replaceChildren(
      el('caption', { class: 'sr-only' }, 'The best for their time'),
      head(),
      el('tbody', {}, ...best.map(({ line }) => line)),
    );
    const bodies = groups.map(({ title, entries }) => {
      const heading = el('tr', {}, el('th', { colspan: 4, scope: 'rowgroup' }, title));
      return el('tbody', {}, heading, ...entries.map(({ line }) => line));
    });
    this.others_.replaceChildren(el('caption', { class: 'sr-only' }, 'The others, by setting'), head(), ...bodies);
    setText(this.count_, `Others, by setting: ${others.length}`);
    this.fold_.hidden = others.length === 0;
  }

  mark(looked: AccuracyRow | null, now: AccuracyRow | null): void {
    for (const { row, line, button } of this.entries_) {
      line.classList.toggle('looked', row === looked);
      line.classList.toggle('now', row === now);
      if (row === now) button.setAttribute('aria-current', 'true');
      else button.removeAttribute('aria-current');
    }
  }

  private entry(row: AccuracyRow, name: string, measured: Measured, schema: readonly SettingRow[]): Entry {
    const button = el('button', { type: 'button', 'aria-label': rowWords(row, measured, schema) }, name);
    const { scale } = measured.accuracy;
    const figures = [frameTime(scale * row.ms), row.rmse === null ? UNKNOWN : percent(row.rmse), row.flip.toFixed(3)];
    const line = el(
      'tr',
      { class: `accuracy-row${row.front ? ' best' : ''}${row.given ? ' given' : ''}` },
      el('th', { scope: 'row' }, button),
      ...figures.map((figure) => el('td', {}, figure)),
    );
    // A list that is scrolled under a resting pointer is not looked at by it.
    line.addEventListener('pointermove', () => this.hooks_.look(row));
    line.addEventListener('pointerleave', () => this.hooks_.leave(row));
    button.addEventListener('focus', () => this.hooks_.look(row));
    button.addEventListener('blur', () => this.hooks_.leave(row));
    line.addEventListener('click', () => this.hooks_.choose(row)); // of the button too
    return { row, line, button };
  }
}

const head = (): HTMLElement =>
  el(
    'thead',
    {},
    el('tr', {}, el('th', { scope: 'col' }, 'Setting'), ...HEADS.map((name) => el('th', { scope: 'col' }, name))),
  );
