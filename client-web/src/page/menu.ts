// A button with a menu: arrow keys move, Escape closes and gives the focus back, a press elsewhere closes.

import { el, icon, uniqueId } from './dom.js';
import './menu.css';

const EMPTY = 'data:image/gif;base64,R0lGODlhAQABAAAAACH5BAEKAAEALAAAAAABAAEAAAICTAEAOw=='; // a clear pixel

export interface MenuItem {
  readonly label: string;
  readonly description?: string;
  readonly hint?: string; // a key
  readonly checked?: boolean; // given: the item is one of a choice
  readonly picture?: string | ((image: HTMLImageElement) => void); // address of a small image, or who puts it there
  readonly choose: () => void;
}

export class Menu {
  readonly element: HTMLElement;
  private readonly list_: HTMLElement;

  /** `items` is asked each time the menu opens. */
  constructor(
    readonly button: HTMLButtonElement,
    label: string,
    private readonly items_: () => readonly MenuItem[],
  ) {
    const id = uniqueId('menu');
    this.list_ = el('div', { class: 'menu', role: 'menu', id, 'aria-label': label, hidden: true });
    button.setAttribute('aria-haspopup', 'menu');
    button.setAttribute('aria-expanded', 'false');
    button.setAttribute('aria-controls', id);
    this.element = el('div', { class: 'menu-anchor' }, button, this.list_);
    button.addEventListener('click', () => (this.list_.hidden ? this.open() : this.close(false)));
    button.addEventListener('keydown', (event) => {
      if (event.code !== 'ArrowDown' && event.code !== 'ArrowUp') return;
      event.preventDefault();
      event.stopPropagation();
      this.open();
    });
    this.list_.addEventListener('keydown', (event) => this.key(event));
    document.addEventListener('pointerdown', (event) => {
      if (event.target instanceof Node && !this.element.contains(event.target)) this.close(false);
    });
    this.element.addEventListener('focusout', (event) => {
      if (event.relatedTarget instanceof Node && !this.element.contains(event.relatedTarget)) this.close(false);
    });
  }

  private open(): void {
    this.list_.replaceChildren(...this.items_().map((item) => this.row(item)));
    this.list_.hidden = false;
    this.button.setAttribute('aria-expanded', 'true');
    const rows = this.rows();
    (rows.find((row) => row.getAttribute('aria-checked') === 'true') ?? rows[0])?.focus();
  }

  private close(returnFocus: boolean): void {
    if (this.list_.hidden) return;
    this.list_.hidden = true;
    this.button.setAttribute('aria-expanded', 'false');
    if (returnFocus) this.button.focus();
  }

  private row(item: MenuItem): HTMLButtonElement {
    const radio = item.checked !== undefined;
    const row = el(
      'button',
      { type: 'button', class: 'menu-item', role: radio ? 'menuitemradio' : 'menuitem', tabindex: -1 },
      radio ? icon('check') : null,
      item.picture === undefined ? null : pictureOf(item.picture),
      el(
        'span',
        { class: 'menu-text' },
        el('span', { class: 'menu-label' }, item.label),
        item.description === undefined ? null : el('span', { class: 'menu-description' }, item.description),
      ),
      item.hint === undefined ? null : el('kbd', {}, item.hint),
    );
    if (radio) row.setAttribute('aria-checked', String(item.checked));
    row.addEventListener('click', () => {
      this.close(true);
      item.choose();
    });
    return row;
  }

  private rows(): HTMLButtonElement[] {
    return [...this.list_.querySelectorAll('button')];
  }

  private key(event: KeyboardEvent): void {
    const rows = this.rows();
    const at = rows.findIndex((row) => row === document.activeElement);
    const targets: Readonly<Record<string, number>> = {
      ArrowDown: (at + 1) % rows.length,
      ArrowUp: (at - 1 + rows.length) % rows.length,
      Home: 0,
      End: rows.length - 1,
    };
    const target = targets[event.code];
    if (event.code === 'Escape') this.close(true);
    else if (target !== undefined) rows[target]?.focus();
    else return;
    event.preventDefault();
    event.stopPropagation();
  }
}

function pictureOf(picture: NonNullable<MenuItem['picture']>): HTMLImageElement {
  if (typeof picture === 'string') return el('img', { class: 'menu-picture', src: picture, alt: '' });
  const image = el('img', { class: 'menu-picture', src: EMPTY, alt: '' });
  picture(image);
  return image;
}
