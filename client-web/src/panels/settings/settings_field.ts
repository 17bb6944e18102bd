// One setting as a control: switch, slider with number, or choice; with its unit, help, price and error.

import { el, icon, setText, uniqueId } from '../../page/dom.js';
import { settingNumber, unitWord } from '../../page/format.js';
import type { SettingRow, SettingValue } from '../../wire/protocol.js';
import { parseNumber } from './number_text.js';
import { POWER_SCALE, SLIDER_STEPS, type SliderScale } from './slider_scale.js';

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
  /** Ids of what else is said of it. */
  readonly describedBy?: string;
}

/** The parts of a control: `inline` stands beside the label, `below` under it. */
export interface Built {
  readonly control: HTMLElement;
  readonly inline: readonly HTMLElement[];
  readonly below: readonly HTMLElement[];
  readonly show: (value: SettingValue) => void;
  /** Where the control itself takes no focus. */
  readonly focus?: () => void;
}

/** Makes the control of a row; `id` is for what the label names. */
export type ControlMaker = (row: SettingRow, id: string, hooks: FieldHooks) => Built;

export class SettingField {
  readonly element: HTMLElement;
  private readonly error_ = el('p', { class: 'field-error', role: 'alert', hidden: true });
  private readonly note_ = el('p', { class: 'field-note', hidden: true });
  private readonly reset_: HTMLButtonElement;
  private readonly show_: (value: SettingValue) => void;
  private readonly control_: HTMLElement;
  private readonly focus_: () => void;

  constructor(
    private readonly row_: SettingRow,
    hooks: FieldHooks,
    make: ControlMaker = makerOf(row_),
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
      hooks.changed(hooks.preset?.() ?? row_.default);
      if (focused) this.focus(); // the button goes, and would take the focus along
    });
    const built = make(row_, id, hooks);
    const group = built.control.getAttribute('role') === 'radiogroup';
    const label = el(group ? 'span' : 'label', group ? { class: 'label', id: `${id}-label` } : { for: id }, row_.label);
    this.show_ = built.show;
    this.control_ = built.control;
    this.focus_ = built.focus ?? (() => built.control.focus());
    this.control_.setAttribute('aria-describedby', `${id}-help ${id}-error ${id}-note ${hooks.describedBy ?? ''}`.trim());
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

  focus(): void {
    this.focus_();
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
    for (const dial of this.element.querySelectorAll('[role="slider"]')) dial.setAttribute('aria-disabled', String(disabled));
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
}

const switchControl: ControlMaker = (_row, id, hooks) => {
  const input = el('input', { type: 'checkbox', role: 'switch', class: 'switch', id });
  input.addEventListener('change', () => hooks.changed(input.checked));
  return { control: input, inline: [input], below: [], show: (value) => (input.checked = value === true) };
};

const choiceControl: ControlMaker = (row, id, hooks) => {
  const select = el('select', { id }, ...row.choices.map((choice) => el('option', { value: choice }, choice)));
  select.addEventListener('change', () => hooks.changed(select.value));
  return { control: select, inline: [select], below: [], show: (value) => (select.value = String(value)) };
};

/** A number to type, whose arrow keys step by the range. */
export function numberControl(row: SettingRow, id: string, hooks: FieldHooks, scale: SliderScale): NumberControl {
  const number = numberInput(row, id);
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
    if (typed !== null) return hooks.changed(typed);
    number.value = settingNumber(value);
    hooks.invalid(`${row.name}: not a number, allowed: ${settingNumber(row.low)} to ${settingNumber(row.high)}`);
  });
  const step = (event: KeyboardEvent, keys: Readonly<Record<string, number>>): void => {
    const direction = keys[event.code];
    if (direction === undefined) return;
    event.preventDefault();
    typing = false;
    hooks.changed(scale.stepped(row, value, Math.sign(direction), Math.abs(direction) > 1));
    number.value = settingNumber(value);
  };
  number.addEventListener('keydown', (event) => step(event, NUMBER_KEYS));
  const show = (next: number): void => {
    value = next;
    const shown = document.activeElement === number && parseNumber(number.value) === next;
    if (!typing && !shown) number.value = settingNumber(next);
    number.setAttribute('aria-valuenow', settingNumber(next));
  };
  return { input: number, show, value: () => value, keys: (event) => step(event, SLIDER_KEYS) };
}

/** A slider with the number beside it. */
export const sliderControl =
  (scale: SliderScale): ControlMaker =>
  (row, id, hooks) => {
    const unit = row.unit === '' ? '' : ` ${unitWord(row.unit)}`;
    const number = numberControl(row, id, hooks, scale);
    const slider = el('input', { type: 'range', min: 0, max: SLIDER_STEPS, step: 'any', 'aria-label': row.label });
    slider.addEventListener('input', () => {
      const next = scale.from(row, slider.valueAsNumber);
      if (next !== number.value()) hooks.changed(next);
    });
    slider.addEventListener('keydown', number.keys);
    const show = (next: SettingValue): void => {
      if (typeof next !== 'number') return;
      number.show(next);
      const position = scale.to(row, next);
      if (document.activeElement !== slider || Math.abs(slider.valueAsNumber - position) > 5)
        slider.value = String(position);
      slider.style.setProperty('--share', String(position / SLIDER_STEPS));
      slider.setAttribute('aria-valuetext', settingNumber(next) + unit);
    };
    const below = el('div', { class: 'number' }, slider, number.input, el('span', { class: 'unit' }, unitWord(row.unit)));
    return { control: number.input, inline: [], below: [below], show };
  };

const makerOf = (row: SettingRow): ControlMaker =>
  row.type === 'bool' ? switchControl : row.type === 'choice' ? choiceControl : sliderControl(POWER_SCALE);

export interface NumberControl {
  readonly input: HTMLInputElement;
  show(value: number): void;
  value(): number;
  /** The same steps by the keys of a slider. */
  keys(event: KeyboardEvent): void;
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


const NUMBER_KEYS: Readonly<Record<string, number>> = { ArrowDown: -1, ArrowUp: 1, PageDown: -2, PageUp: 2 };
const SLIDER_KEYS: Readonly<Record<string, number>> = { ...NUMBER_KEYS, ArrowLeft: -1, ArrowRight: 1 };
