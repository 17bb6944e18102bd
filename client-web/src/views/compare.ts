// Two pictures over each other: A is frozen, B goes on; a line between them is drawn to and fro.

import { el, icon } from '../page/dom.js';
import './compare.css';

const STEP = 0.02; // of the width, by an arrow key

export class Compare {
  readonly element: HTMLElement;
  private readonly frozen_ = el('canvas', { class: 'compare-frozen', 'aria-hidden': 'true' });
  private readonly handle_: HTMLElement;
  private share_ = 0.5; // of the width that shows A

  constructor(private readonly picture_: HTMLCanvasElement) {
    this.handle_ = el('div', {
      class: 'compare-handle',
      role: 'slider',
      tabindex: 0,
      'aria-label': 'Border between the frozen picture, A, and the present one, B',
      'aria-valuemin': 0,
      'aria-valuemax': 100,
    });
    const close = el('button', { type: 'button', class: 'ghost', 'aria-label': 'End comparing' }, icon('close'));
    close.addEventListener('click', () => this.end());
    const labels = el('div', { class: 'compare-labels' }, el('b', {}, 'A'), el('span', {}, 'frozen, now'), el('b', {}, 'B'), close);
    this.element = el('div', { class: 'compare', hidden: true }, this.frozen_, this.handle_, labels);
    this.handle_.addEventListener('pointerdown', (event) => this.handle_.setPointerCapture(event.pointerId));
    this.handle_.addEventListener('pointermove', (event) => {
      if (this.handle_.hasPointerCapture(event.pointerId)) this.wipeTo(event.clientX / window.innerWidth);
    });
    this.element.addEventListener('keydown', (event) => this.key(event));
  }

  /** Freezes what is shown now. */
  begin(): void {
    const { width, height } = this.picture_;
    if (width === 0 || height === 0) return;
    [this.frozen_.width, this.frozen_.height] = [width, height];
    this.frozen_.getContext('2d')?.drawImage(this.picture_, 0, 0);
    this.element.hidden = false;
    this.wipeTo(0.5);
    this.handle_.focus();
  }

  private end(): void {
    this.element.hidden = true;
    this.picture_.focus({ preventScroll: true });
  }

  private key(event: KeyboardEvent): void {
    const steps: Readonly<Record<string, number>> = { ArrowLeft: -STEP, ArrowRight: STEP, PageUp: 0.1, PageDown: -0.1 };
    const ends: Readonly<Record<string, number>> = { Home: 0, End: 1 };
    if (event.key === 'Escape') this.end();
    else if (event.target !== this.handle_) return;
    else if (steps[event.key] !== undefined) this.wipeTo(this.share_ + steps[event.key]!);
    else if (ends[event.key] !== undefined) this.wipeTo(ends[event.key]!);
    else return;
    event.preventDefault();
    event.stopPropagation(); // arrows would look around
  }

  private wipeTo(share: number): void {
    this.share_ = Math.min(1, Math.max(0, share));
    this.element.style.setProperty('--wipe', `${this.share_ * 100}%`);
    this.handle_.setAttribute('aria-valuenow', String(Math.round(this.share_ * 100)));
  }
}
