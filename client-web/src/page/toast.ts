// Short messages over the picture: notices go by themselves, errors stay until they are closed (at most a few at a
// time).

import { el, icon } from './dom.js';
import './toast.css';

const NOTICE_MS = 6000;
const MOST = 4;

export interface Toast {
  close(): void;
}

export class Toasts {
  readonly element = el('div', { class: 'toasts' });
  private readonly polite_ = el('div', { class: 'toast-list', role: 'status', 'aria-live': 'polite' });
  private readonly urgent_ = el('div', { class: 'toast-list', role: 'alert' });

  constructor() {
    this.element.append(this.urgent_, this.polite_);
  }

  /** `stay`: until closed by the caller. The same text twice is shown once. */
  show(kind: 'notice' | 'error', text: string, stay = false): Toast {
    const list = kind === 'error' ? this.urgent_ : this.polite_;
    for (const other of list.children) if (other.querySelector('p')?.textContent === text) other.remove();
    while (list.children.length >= MOST) list.firstElementChild?.remove();
    const close = el('button', { type: 'button', class: 'ghost', 'aria-label': 'Close message' }, icon('close'));
    const toast = el(
      'div',
      { class: `toast ${kind}` },
      icon(kind === 'error' ? 'warning' : 'info'),
      el('p', {}, text),
      close,
    );
    close.addEventListener('click', () => toast.remove());
    list.append(toast);
    if (kind === 'notice' && !stay) window.setTimeout(() => toast.remove(), NOTICE_MS);
    return { close: () => toast.remove() };
  }
}
