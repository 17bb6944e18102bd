// The last frames one beside the other, newest at the right: a column each, of the parts of its time. All that are kept can be
// reached by scrolling; who points at a column is told its figures.

import { el, setText } from '../../page/dom.js';
import { compact } from '../../page/format.js';
import { columnOf, columnText, KINDS, KIND_LABELS, type Kind } from '../../picture/frame_stack.js';
import type { FrameTimes } from '../../picture/frame_trace.js';
import { chartTop } from './chart.js';
import './frame_timeline.css';

const COLUMN = 3; // CSS pixels a frame, one of them empty

export class FrameTimeline {
  readonly element: HTMLElement;
  private readonly canvas_ = el('canvas', { role: 'img', 'aria-label': 'Where the time of each of the last frames went' });
  private readonly scroll_ = el('div', { class: 'frame-times-scroll', tabindex: 0, role: 'group', 'aria-label': 'Last frames' }, this.canvas_);
  private readonly scale_ = el('span', { class: 'chart-scale' });
  private readonly text_ = el('p', { class: 'frame-times-text muted' });
  private readonly colors_: Readonly<Record<Kind, HTMLElement>>;
  private frames_: readonly FrameTimes[] = [];
  private newest_ = -1;
  private pointed_ = false;

  constructor() {
    const swatches = KINDS.map((kind) => [kind, el('i', { class: `swatch of-${kind}` })] as const);
    this.colors_ = Object.fromEntries(swatches) as unknown as Readonly<Record<Kind, HTMLElement>>;
    const legend = swatches.map(([kind, swatch]) => el('span', { class: 'frame-times-key' }, swatch, KIND_LABELS[kind]));
    this.element = el(
      'div',
      { class: 'frame-times' },
      el('div', { class: 'frame-times-box' }, this.scroll_, this.scale_),
      el('div', { class: 'frame-times-legend' }, ...legend),
      this.text_,
    );
    this.canvas_.addEventListener('pointermove', (event) => this.point(event.offsetX));
    this.canvas_.addEventListener('pointerleave', () => {
      this.pointed_ = false;
      this.tell(this.frames_.length - 1);
    });
  }

  draw(frames: readonly FrameTimes[]): void {
    const newest = frames.at(-1)?.frame.frameId ?? -1;
    if (newest === this.newest_ && frames.length === this.frames_.length) return;
    this.newest_ = newest;
    const atEnd = this.scroll_.scrollLeft + this.scroll_.clientWidth >= this.scroll_.scrollWidth - 2 * COLUMN;
    this.frames_ = [...frames];
    this.paint();
    if (atEnd) this.scroll_.scrollLeft = this.scroll_.scrollWidth;
    if (!this.pointed_) this.tell(this.frames_.length - 1);
  }

  private paint(): void {
    const ratio = window.devicePixelRatio;
    const cssWidth = Math.max(this.scroll_.clientWidth, this.frames_.length * COLUMN);
    const [width, height] = [Math.round(cssWidth * ratio), Math.round(this.canvas_.clientHeight * ratio)];
    const context = this.canvas_.getContext('2d');
    if (context === null || width === 0 || height === 0) return;
    this.canvas_.style.width = `${cssWidth}px`;
    this.canvas_.width = width; // clears it
    this.canvas_.height = height;
    const columns = this.frames_.map(columnOf);
    const top = chartTop(columns.map(({ total }) => total));
    const step = COLUMN * ratio;
    const base = columns.map(() => height);
    const from = width - columns.length * step;
    for (const kind of KINDS) {
      context.fillStyle = getComputedStyle(this.colors_[kind]).backgroundColor;
      columns.forEach(({ parts }, i) => {
        const tall = (parts[kind] / top) * height;
        base[i]! -= tall;
        context.fillRect(from + i * step, base[i]!, step - ratio, tall);
      });
    }
    setText(this.scale_, `${compact(top, 0)} ms`);
  }

  private point(x: number): void {
    this.pointed_ = true;
    const fromRight = Math.floor((this.canvas_.clientWidth - x) / COLUMN);
    this.tell(this.frames_.length - 1 - fromRight);
  }

  private tell(index: number): void {
    const times = this.frames_[index];
    setText(this.text_, times === undefined ? 'No frame yet.' : columnText(times, columnOf(times)));
  }
}
