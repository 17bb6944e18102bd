// Two pictures of the same view over each other, with a border between them that is moved by slider or pointer.

import { el } from '../../page/dom.js';
import type { Accuracy } from '../../wire/accuracy_message.js';

export class Wipe {
  readonly element: HTMLElement;
  private readonly exact_ = el('img', { class: 'wipe-exact', alt: 'The exact picture', draggable: 'false' });
  private readonly given_ = el('img', { alt: 'The picture with the settings as they were', draggable: 'false' });
  private readonly pictures_ = el('div', { class: 'wipe-pictures' }, this.given_, this.exact_);
  private readonly slider_ = el('input', {
    type: 'range',
    min: 0,
    max: 100,
    'aria-label': 'Border between the exact picture and that of the settings as they were',
  });

  constructor() {
    const caption = el('figcaption', {}, el('span', {}, 'Exact'), el('span', {}, 'As it was'));
    this.element = el('figure', { class: 'wipe' }, this.pictures_, this.slider_, caption);
    this.slider_.addEventListener('input', () => this.wipeTo(this.slider_.valueAsNumber));
    this.pictures_.addEventListener('pointerdown', (event) => {
      this.pictures_.setPointerCapture(event.pointerId);
      this.follow(event);
    });
    this.pictures_.addEventListener('pointermove', (event) => {
      if (this.pictures_.hasPointerCapture(event.pointerId)) this.follow(event);
    });
  }

  show({ pictures, width, height }: Accuracy): void {
    this.element.hidden = pictures === null;
    if (pictures === null) return;
    for (const [image, picture] of [[this.exact_, pictures.exact], [this.given_, pictures.given]] as const) {
      [image.width, image.height] = [width, height]; // the place is kept before it is decoded
      image.src = `data:image/png;base64,${picture}`;
    }
    this.wipeTo(50);
  }

  private follow({ clientX }: PointerEvent): void {
    const box = this.pictures_.getBoundingClientRect();
    this.wipeTo(Math.round((100 * (clientX - box.left)) / box.width));
  }

  /** `part`: of the width that shows the exact picture, per cent. */
  private wipeTo(part: number): void {
    const shown = Math.min(100, Math.max(0, part));
    this.slider_.value = String(shown);
    this.slider_.setAttribute('aria-valuetext', `${shown} % exact`);
    this.slider_.style.setProperty('--share', String(shown / 100));
    this.pictures_.style.setProperty('--wipe', `${shown}%`);
  }
}
