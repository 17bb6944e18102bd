// A list of name, bar and figure whose rows come and go with the names; a row may have a remark under it.

import { el, setText } from '../../page/dom.js';

export interface BarRow {
  readonly label: string;
  readonly share: number | null; // 0..1 of the bar's length; null: no bar
  readonly text: string;
  readonly color?: string; // '': the plain one
  readonly keyed?: boolean; // the colour stands beside the name too, for bars of length 0
  readonly help?: string;
  readonly note?: string;
}

interface Entry {
  readonly row: HTMLElement;
  readonly bar: HTMLElement;
  readonly value: HTMLElement;
  readonly note: HTMLElement;
}

export class BarList {
  readonly element = el('div', { class: 'bar-list' });
  private readonly rows_ = new Map<string, Entry>();

  /** Adds or changes the row of that name. */
  row(name: string, { label, share, text, color = '', keyed = false, help = '', note = '' }: BarRow): void {
    const entry = this.rows_.get(name) ?? this.add(name, label, help);
    entry.bar.style.setProperty('--share', String(Math.min(1, Math.max(0, share ?? 0))));
    entry.bar.style.setProperty('background', color);
    entry.row.classList.toggle('total', share === null);
    entry.row.classList.toggle('keyed', keyed);
    entry.row.style.setProperty('--device', color);
    setText(entry.value, text);
    setText(entry.note, note);
    entry.note.hidden = note === '';
  }

  /** Removes rows that are not among `names`. */
  keep(names: readonly string[]): void {
    for (const [name, entry] of this.rows_) {
      if (names.includes(name)) continue;
      entry.row.remove();
      entry.note.remove();
      this.rows_.delete(name);
    }
  }

  private add(name: string, label: string, help: string): Entry {
    const bar = el('span', { class: 'fill' });
    const value = el('span', { class: 'figure' });
    const note = el('p', { class: 'bar-note', hidden: true });
    const row = el(
      'div',
      { class: 'bar-row', title: help },
      el('span', { class: 'bar-label' }, label),
      el('span', { class: 'bar-track' }, bar),
      value,
    );
    const entry = { row, bar, value, note };
    this.rows_.set(name, entry);
    this.element.append(row, note);
    return entry;
  }
}
