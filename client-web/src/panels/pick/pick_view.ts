// Says what lies at the place that the viewer pointed at, in a card beside it, and marks the place in the picture: orbit
// about it, focus on it, measure from it.

import { lookingAt, placeOf } from '../../camera/camera.js';
import type { Vec3 } from '../../camera/vector.js';
import { drawn, el, icon, setText, type IconName } from '../../page/dom.js';
import { pictureBox } from '../../picture/picture_box.js';
import type { PickedSurface } from '../../wire/picked_message.js';
import type { Viewer } from '../../viewer.js';
import { lengthText, normalText, titleOf } from './pick_words.js';
import './pick_view.css';

const CARD = { width: 272, beside: 24, edge: 8, dock: 88 }; // CSS pixels

export class PickView {
  /** Lies over the picture. */
  readonly marks = drawn('svg', { class: 'pick-marks', 'aria-hidden': 'true' });
  readonly card: HTMLElement;
  private readonly title_ = el('h3');
  private readonly facts_ = el('dl', { class: 'facts' });
  private readonly hint_ = el('p', { class: 'muted' });
  private readonly orbit_ = action('orbit', 'Orbit here');
  private readonly focus_ = action('target', 'Focus here');
  private readonly measure_ = action('ruler', 'Measure from here');
  private byKey_ = false;

  /** `leave`: gives the focus back to the picture. */
  constructor(
    private readonly viewer_: Viewer,
    private readonly announce_: (text: string) => void,
    private readonly leave_: () => void,
  ) {
    const close = el('button', { type: 'button', class: 'ghost', 'aria-label': 'Close' }, icon('close'));
    const head = el('div', { class: 'pick-head' }, this.title_, close);
    const actions = el('div', { class: 'pick-actions' }, this.orbit_, this.focus_, this.measure_);
    const parts = [head, this.facts_, this.hint_, actions];
    this.card = el('section', { class: 'pick-card', 'aria-label': 'What is there', hidden: true }, ...parts);
    close.addEventListener('click', () => this.close());
    this.card.addEventListener('keydown', (event) => {
      if (event.key === 'Escape') this.close();
    });
    this.orbit_.addEventListener('click', () =>
      this.withSurface(({ position }) => viewer_.jumpTo(lookingAt(viewer_.controller.camera, position), position)),
    );
    this.focus_.addEventListener('click', () => this.withSurface((surface) => this.focus(surface)));
    this.measure_.addEventListener('click', () => viewer_.pick.measure());
    viewer_.on(['pick'], () => this.refresh());
    viewer_.on(['camera', 'frame', 'resolution', 'settings'], () => this.place());
    window.addEventListener('resize', () => this.place());
  }

  /** Asks for what is in the middle of the window, for who has no pointer. */
  pickMiddle(): void {
    this.byKey_ = true;
    this.viewer_.pickAt(window.innerWidth / 2, window.innerHeight / 2);
  }

  private close(): void {
    this.viewer_.pick.forget();
    this.leave_();
  }

  private withSurface(act: (surface: PickedSurface) => void): void {
    const { state } = this.viewer_.pick;
    if (state.name === 'found') act(state.surface);
  }

  /** Its depth along the present view; a change of settings like any other, to be taken back. */
  private focus(surface: PickedSurface): void {
    const { position, forward } = this.viewer_.controller.camera;
    const depth = surface.position.reduce((sum, value, i) => sum + (value - position[i]!) * forward[i]!, 0);
    if (!(depth > 0)) return;
    this.viewer_.setSettings({ focusDistance: depth });
    this.viewer_.pick.focusOn(surface);
  }

  private refresh(): void {
    const { pick } = this.viewer_;
    const { state } = pick;
    this.card.hidden = state.name !== 'found' && state.name !== 'nothing';
    if (state.name === 'nothing') setText(this.title_, 'Nothing is there');
    if (state.name === 'found') this.describe(state.surface);
    this.facts_.hidden = state.name !== 'found';
    for (const button of [this.orbit_, this.measure_]) button.hidden = state.name !== 'found';
    this.focus_.hidden = state.name !== 'found' || this.viewer_.settings.value('focusDistance') === undefined;
    const { measured } = pick;
    const waits = pick.from !== null && measured === null;
    setText(this.hint_, waits ? 'Double click or press long on the second point.' : '');
    this.hint_.hidden = !waits;
    this.place();
    if (this.card.hidden) return;
    const between = measured === null ? '' : ` ${lengthText(measured)} between both points.`;
    this.announce_(`${this.title_.textContent ?? ''}.${between}`);
    if (this.byKey_) (state.name === 'found' ? this.orbit_ : this.card.querySelector('button'))?.focus();
    this.byKey_ = false;
  }

  private describe(surface: PickedSurface): void {
    const { measured, focused } = this.viewer_.pick;
    setText(this.title_, titleOf(surface));
    const rows: (readonly [string, string])[] = [
      ['Object', surface.object === '' ? 'no name' : surface.object],
      ['Material', surface.material === '' ? 'no name' : surface.material],
      ['Distance', lengthText(surface.distance)],
      ['Normal', normalText(surface.normal)],
    ];
    if (measured !== null) rows.push(['Between both points', lengthText(measured)]);
    if (focused === surface) rows.push(['Focus', 'is here']);
    this.facts_.replaceChildren(...rows.flatMap(([name, value]) => [el('dt', {}, name), el('dd', {}, value)]));
  }

  /** Marks and card follow the camera. */
  private place(): void {
    const { pick } = this.viewer_;
    const picked = pick.state.name === 'found' ? pick.state.surface : null;
    const shown = (['from', 'focused', 'picked'] as const).map((kind) => {
      const surface = { from: pick.from, focused: pick.focused, picked }[kind];
      return { kind, at: surface === null ? null : this.inWindow(surface.position) };
    });
    const at = (kind: string): Point | null => shown.find((mark) => mark.kind === kind)?.at ?? null;
    this.marks.replaceChildren(...shown.flatMap(({ kind, at: point }) => (point === null ? [] : mark(kind, point))));
    const [from, to] = [at('from'), at('picked')];
    if (from !== null && to !== null && pick.measured !== null)
      this.marks.prepend(drawn('line', { x1: from.x, y1: from.y, x2: to.x, y2: to.y, class: 'pick-line' }));
    if (!this.card.hidden) this.placeCard(to);
  }

  private placeCard(at: Point | null): void {
    const { offsetHeight } = this.card;
    const most = { x: window.innerWidth - CARD.width - CARD.edge, y: window.innerHeight - offsetHeight - CARD.dock };
    const wanted = at ?? { x: window.innerWidth / 2 - CARD.width / 2 - CARD.beside, y: 104 };
    const fits = wanted.x + CARD.beside <= most.x;
    const x = fits ? wanted.x + CARD.beside : wanted.x - CARD.beside - CARD.width;
    this.card.style.setProperty('left', `${Math.max(CARD.edge, Math.min(most.x, x))}px`);
    this.card.style.setProperty('top', `${Math.max(CARD.edge, Math.min(most.y, wanted.y - 24))}px`);
  }

  private inWindow(point: Vec3): Point | null {
    const { resolution } = this.viewer_.state;
    const place = placeOf(this.viewer_.controller.camera, point, resolution.width / Math.max(1, resolution.height));
    if (place === null) return null;
    const box = pictureBox(resolution.width, resolution.height, window.innerWidth, window.innerHeight);
    return { x: box.x + place.x * box.width, y: box.y + place.y * box.height };
  }
}

interface Point {
  readonly x: number;
  readonly y: number;
}

function action(name: IconName, label: string): HTMLButtonElement {
  return el('button', { type: 'button', class: 'wide-button' }, icon(name), label);
}

/** A ring with a dark edge, to be seen on every picture; a cross in it where the focus is. */
function mark(kind: string, { x, y }: Point): SVGElement[] {
  const ring = (className: string): SVGElement =>
    drawn('circle', { cx: x, cy: y, r: kind === 'focused' ? 11 : 7, class: `${className} pick-${kind}` });
  const cross = drawn('path', { d: `M${x - 16} ${y}h10M${x + 6} ${y}h10M${x} ${y - 16}v10M${x} ${y + 6}v10`, class: 'pick-ring' });
  return [ring('pick-edge'), ring('pick-ring'), ...(kind === 'focused' ? [cross] : [])];
}
