// One setting as a control: switch, slider with number, or choice; with its unit, help, price and error.

import { el, icon, setText, uniqueId } from '../../page/dom.js';
import { settingNumber } from '../../page/format.js';
import type { SettingRow, SettingValue } from '../../wire/protocol.js';
import { parseNumber } from './number_text.js';
import { fromSlider, SLIDER_STEPS, stepped, toSlider } from './slider_scale.js';

const PRICES: Readonly<Record<string, { readonly tag: string; readonly text: string }>> = {
  up: { tag: '↑ exact, slower', text: 'Higher is more exact and slower.' },
  down: { tag: '↓ exact, slower', text: 'Lower is more exact and slower.' },
  on: { tag: 'on: exact, slower', text: 'On is more exact and slower.' },
  off: { tag: 'off: exact, slower', text: 'Off is more exact and slower.' },
};

export interface FieldHooks {
  /** The viewer chose a value; it may lie outside the range, which the server judges. */
  changed(value: SettingValue): void;
  /** What was typed is no value at all. */
  invalid(message: string): void;
  /** What the reset button goes back to, where that is not the table's default. */
  preset?(): SettingValue;
}

export class SettingField {
  readonly element: HTMLElement;
  private readonly error_ = el('p', { class: 'field-error', role: 'alert', hidden: true });
  private readonly note_ = el('p', { class: 'field-note', hidden: true });
  private readonly reset_: HTMLButtonElement;
  private readonly show_: (value: SettingValue) => void;
  private readonly control_: HTMLElement;

  constructor(
    private readonly row_: SettingRow,
    private readonly hooks_: FieldHooks,
  ) {
    const id = uniqueId('setting');
    this.error_.id = `${id}-error`;
    this.note_.id = `${id}-note`;
    const help = this.help(id);
    this.reset_ = el(
      'button',
      {
        type: 'button',
        class: 'ghost reset',
        'aria-label': `Reset ${row_.label} to its default`,
        title: 'Reset to default',
      },
      icon('reset'),
    );
    this.reset_.addEventListener('click', () => {
      const focused = document.activeElement === this.reset_;
      hooks_.changed(hooks_.preset?.() ?? row_.default);
      if (focused) this.control_.focus(); // the button goes, and would take the focus along
    });
    const label = el('label', { for: id }, row_.label);
    const built =
      row_.type === 'bool'
        ? this.buildSwitch(id)
        : row_.type === 'choice'
          ? this.buildChoice(id)
          : this.buildNumber(id);
    this.show_ = built.show;
    this.control_ = built.control;
    this.control_.setAttribute('aria-describedby', `${id}-help ${id}-error ${id}-note`);
    const head = el(
      'div',
      { class: 'field-head' },
      label,
      help.button,
      help.price,
      el('span', { class: 'spacer' }),
      this.reset_,
      ...built.inline,
    );
    this.element = el(
      'div',
      { class: `field ${row_.type}`, 'data-setting': row_.name },
      head,
      ...built.below,
      this.error_,
      this.note_,
      help.text,
    );
  }

  /** `isDefault` hides the reset button without moving anything. */
  show(value: SettingValue, isDefault: boolean): void {
    this.show_(value);
    this.reset_.classList.toggle('invisible', isDefault);
    this.reset_.disabled = isDefault;
  }

  setError(message: string | null): void {
    if (message !== null) setText(this.error_, message);
    this.error_.hidden = message === null;
    this.control_.setAttribute('aria-invalid', String(message !== null));
  }

  /** A remark under the control, as why the scene has no use for it. */
  setNote(text: string | null): void {
    setText(this.note_, text ?? '');
    this.note_.hidden = text === null;
  }

  /** A disabled control shows its value and takes none. */
  setDisabled(disabled: boolean): void {
    for (const control of this.element.querySelectorAll<HTMLInputElement | HTMLSelectElement>('input, select')) {
      control.disabled = disabled;
    }
    this.element.classList.toggle('disabled', disabled);
  }

  private help(id: string): { button: HTMLButtonElement; price: HTMLElement | null; text: HTMLElement } {
    const price = PRICES[this.row_.price];
    const button = el(
      'button',
      {
        type: 'button',
        class: 'help-button',
        'aria-expanded': 'false',
        'aria-controls': `${id}-help`,
        'aria-label': `About ${this.row_.label}`,
        title: `${this.row_.help} ${price?.text ?? ''}`.trim(),
      },
      icon('help'),
    );
    const text = el('p', { class: 'field-help', id: `${id}-help`, hidden: true }, this.row_.help);
    if (price !== undefined) text.append(' ', el('em', {}, price.text));
    button.addEventListener('click', () => {
      text.hidden = !text.hidden;
      button.setAttribute('aria-expanded', String(!text.hidden));
    });
    const tag = price === undefined ? null : el('span', { class: 'price', 'aria-hidden': 'true' }, price.tag);
    return { button, price: tag, text };
  }

  private buildSwitch(id: string): Built {
    const input = el('input', { type: 'checkbox', role: 'switch', class: 'switch', id });
    input.addEventListener('change', () => this.hooks_.changed(input.checked));
    return { control: input, inline: [input], below: [], show: (value) => (input.checked = value === true) };
  }

  private buildChoice(id: string): Built {
    const select = el('select', { id }, ...this.row_.choices.map((choice) => el('option', { value: choice }, choice)));
    select.addEventListener('change', () => this.hooks_.changed(select.value));
    return { control: select, inline: [select], below: [], show: (value) => (select.value = String(value)) };
  }

  private buildNumber(id: string): Built {
    const row = this.row_;
    const unit = row.unit === '' ? '' : ` ${row.unit}`;
    const number = numberInput(row, id);
    const slider = el('input', { type: 'range', min: 0, max: SLIDER_STEPS, step: 'any', 'aria-label': row.label });
    let value = typeof row.default === 'number' ? row.default : row.low;
    let typing = false; // what comes from the server meanwhile does not take the text away
    number.addEventListener('input', () => (typing = true));
    number.addEventListener('blur', () => {
      if (typing) number.value = settingNumber(value); // as it was: nothing has changed
      typing = false;
    });
    number.addEventListener('change', () => {
      typing = false;
      const typed = parseNumber(number.value);
      if (typed === null) {
        number.value = settingNumber(value);
        this.hooks_.invalid(
          `${row.name}: not a number, allowed: ${settingNumber(row.low)} to ${settingNumber(row.high)}`,
        );
      } else {
        this.hooks_.changed(typed);
      }
    });
    slider.addEventListener('input', () => {
      const next = fromSlider(row, slider.valueAsNumber);
      if (next !== value) this.hooks_.changed(next);
    });
    const step = (event: KeyboardEvent, keys: Readonly<Record<string, number>>): void => {
      const direction = keys[event.code];
      if (direction === undefined) return;
      event.preventDefault();
      typing = false;
      this.hooks_.changed(stepped(row, value, Math.sign(direction), Math.abs(direction) > 1));
      number.value = settingNumber(value);
    };
    slider.addEventListener('keydown', (event) => step(event, SLIDER_KEYS));
    number.addEventListener('keydown', (event) => step(event, NUMBER_KEYS));
    const show = (next: SettingValue): void => {
      if (typeof next !== 'number') return;
      value = next;
      const shown = document.activeElement === number && parseNumber(number.value) === next;
      if (!typing && !shown) number.value = settingNumber(next);
      number.setAttribute('aria-valuenow', settingNumber(next));
      const position = toSlider(row, next);
      if (document.activeElement !== slider || Math.abs(slider.valueAsNumber - position) > 5)
        slider.value = String(position);
      slider.style.setProperty('--share', String(position / SLIDER_STEPS));
      slider.setAttribute('aria-valuetext', settingNumber(next) + unit);
    };
    const below = el('div', { class: 'number' }, slider, number, el('span', { class: 'unit' }, row.unit));
    return { control: number, inline: [], below: [below], show };
  }
}

function numberInput(row: SettingRow, id: string): HTMLInputElement {
  return el('input', {
    type: 'text', // a number field of the browser reads 0,5 as 5
    class: 'number-field',
    role: 'spinbutton',
    id,
    'aria-valuemin': row.low,
    'aria-valuemax': row.high,
    inputmode: 'decimal',
    autocomplete: 'off',
  });
}

interface Built {
  readonly control: HTMLElement;
  readonly inline: readonly HTMLElement[];
  readonly below: readonly HTMLElement[];
  readonly show: (value: SettingValue) => void;
}

const NUMBER_KEYS: Readonly<Record<string, number>> = { ArrowDown: -1, ArrowUp: 1, PageDown: -2, PageUp: 2 };
const SLIDER_KEYS: Readonly<Record<string, number>> = { ...NUMBER_KEYS, ArrowLeft: -1, ArrowRight: 1 };
