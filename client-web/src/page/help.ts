// The overlay that lists keys and gestures.

import { el, icon } from './dom.js';
import './help.css';

type Row = readonly [keys: readonly string[], meaning: string];

const SECTIONS: readonly { readonly title: string; readonly rows: readonly Row[] }[] = [
  {
    title: 'Move',
    rows: [
      [['W', 'A', 'S', 'D'], 'forward, left, back, right'],
      [['Space'], 'ten times faster while held'],
      [['Shift'], 'ten times slower while held'],
      [['←', '→', '↑', '↓'], 'look around'],
      [['Q', 'E'], 'roll left, right'],
      [['T', 'G'], 'wider, narrower field of view'],
    ],
  },
  {
    title: 'Mouse',
    rows: [
      [['Drag'], 'look, or turn around the scene in orbit mode'],
      [['Right drag', 'Shift drag'], 'pan'],
      [['Alt drag'], 'turn the surroundings: the light on the scene follows'],
      [['L'], 'the mouse looks without a button, until L or Esc'],
      [['Wheel'], 'come nearer, go back'],
      [['Double click'], 'what is there; measure, orbit or focus there'],
    ],
  },
  {
    title: 'Touch',
    rows: [
      [['One finger'], 'look or orbit'],
      [['Stick'], 'move, at the lower left'],
      [['Two fingers'], 'pan; pinch to come nearer'],
      [['Long press'], 'what is there; measure, orbit or focus there'],
    ],
  },
  {
    title: 'Gamepad',
    rows: [
      [['Left stick'], 'move'],
      [['Right stick'], 'look, or turn around the scene'],
      [['Triggers'], 'down, up'],
      [['Shoulders'], 'slower, faster while held'],
      [['A', 'B', 'X', 'Y'], 'what is in the middle, fly or orbit, all in view, reset the view'],
    ],
  },
  {
    title: 'Page',
    rows: [
      [['O'], 'fly or orbit mode'],
      [['R'], 'reset the view'],
      [['V'], 'all of the scene in view'],
      [['Ctrl Z'], 'take the last change of settings back'],
      [['Esc'], 'back to the picture'],
      [['I'], 'what is in the middle of the picture'],
      [['[', ']'], 'turn the surroundings by 15 degrees'],
      [['P'], 'show which device made which part'],
      [['N'], 'show where the picture still has how much error'],
      [['F1'], 'hide or show the panels'],
      [['F2'], 'start or stop the benchmark path'],
      [['F3'], 'save a PNG of the picture'],
      [['H', '?'], 'this help'],
    ],
  },
];

/** Where there is no mouse, what fingers do comes first. */
const sections = (): typeof SECTIONS =>
  window.matchMedia('(pointer: coarse)').matches
    ? [...SECTIONS.filter(({ title }) => title === 'Touch'), ...SECTIONS.filter(({ title }) => title !== 'Touch')]
    : SECTIONS;

export class HelpDialog {
  readonly element: HTMLDialogElement;

  constructor() {
    const close = el(
      'button',
      { type: 'button', class: 'ghost', 'aria-label': 'Close help', autofocus: true },
      icon('close'),
    );
    this.element = el(
      'dialog',
      { class: 'help', 'aria-labelledby': 'help-title' },
      el('header', {}, el('h2', { id: 'help-title' }, 'Keys and gestures'), close),
      el('div', { class: 'help-grid' }, ...sections().map((section) => this.section(section.title, section.rows))),
    );
    close.addEventListener('click', () => this.element.close());
    this.element.addEventListener('keydown', (event) => {
      if (event.code !== 'KeyH' && event.key !== '?') return;
      event.stopPropagation();
      this.element.close();
    });
    this.element.addEventListener('click', (event) => {
      if (event.target === this.element) this.element.close();
    });
  }

  toggle(): void {
    if (this.element.open) this.element.close();
    else this.element.showModal();
  }

  private section(title: string, rows: readonly Row[]): HTMLElement {
    const list = el('dl');
    for (const [keys, meaning] of rows) {
      list.append(el('dt', {}, ...keys.map((key) => el('kbd', {}, key))), el('dd', {}, meaning));
    }
    return el('section', {}, el('h3', {}, title), list);
  }
}
