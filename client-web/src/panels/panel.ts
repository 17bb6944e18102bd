// A panel that floats over the picture and folds away: to its heading in a wide window, out of sight in a narrow one,
// where panels are sheets at the bottom and only one is open at a time. It stays as it was left.

import { el, icon, uniqueId } from '../page/dom.js';
import { recall, remember } from '../page/storage.js';
import './panel.css';

const NARROW = window.matchMedia('(max-width: 899px), (max-height: 479px)');

export class Panel {
  readonly element: HTMLElement;
  readonly body: HTMLElement;
  /** Beside the title, also while folded. */
  readonly summary = el('span', { class: 'panel-summary' });
  private readonly head_: HTMLButtonElement;
  private readonly listeners_: ((open: boolean) => void)[] = [];
  private open_ = false;

  constructor(
    private readonly name_: string,
    title: string,
    private readonly group_: Panel[],
    private readonly openAtFirst_ = true,
  ) {
    const id = uniqueId('panel');
    this.body = el('div', { class: 'panel-body', id });
    this.head_ = el(
      'button',
      { type: 'button', class: 'panel-head', 'aria-controls': id },
      el('span', { class: 'panel-title' }, title),
      this.summary,
      icon('chevron'),
    );
    this.element = el('section', { class: 'panel', id: `${name_}-panel`, 'aria-label': title }, this.head_, this.body);
    this.head_.addEventListener('click', () => this.setOpen(!this.open_));
    this.element.addEventListener('keydown', (event) => {
      if (event.key !== 'Escape' || event.defaultPrevented) return;
      if (NARROW.matches) this.setOpen(false); // a sheet covers the picture
      document.querySelector<HTMLElement>('body > canvas')?.focus({ preventScroll: true });
    });
    group_.push(this);
    NARROW.addEventListener('change', () => this.restore());
    this.restore();
  }

  get isOpen(): boolean {
    return this.open_;
  }

  onToggle(listener: (open: boolean) => void): void {
    this.listeners_.push(listener);
    listener(this.open_);
  }

  setOpen(open: boolean): void {
    this.show(open);
    remember(this.key(), open ? 'open' : 'folded');
    if (open && NARROW.matches) for (const other of this.group_) if (other !== this) other.setOpen(false);
  }

  private restore(): void {
    const stored = recall(this.key());
    this.show(stored === null ? this.openAtFirst_ && !NARROW.matches : stored === 'open');
  }

  private key(): string {
    return `panel.${this.name_}.${NARROW.matches ? 'narrow' : 'wide'}`;
  }

  private show(open: boolean): void {
    this.open_ = open;
    this.element.classList.toggle('folded', !open);
    this.head_.setAttribute('aria-expanded', String(open));
    this.body.hidden = !open;
    for (const listener of this.listeners_) listener(open);
  }
}
