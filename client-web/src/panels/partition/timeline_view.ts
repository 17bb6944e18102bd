// Draws who worked when in a frame: one thin row per worker, in its device's colour; dark where it was idle. Pointing at
// a place says what was done there.

import { deviceColor } from '../device_colors.js';
import { el, setText } from '../../page/dom.js';
import { busyBins, describeAt, timelineRows, type TimelineRow } from './timeline.js';
import type { Timeline } from '../../wire/partition_message.js';
import { clamp } from '../../camera/vector.js';

const REACH_PIXELS = 4; // how near to a batch counts as on it
const SEPARATED_FROM = 4; // device pixels; wider batches are told apart by a gap

/** Height of a row and its gap, CSS pixels: thin rows when there are many. */
const rowHeight = (rows: number): number => (rows <= 4 ? 8 : rows <= 10 ? 6 : rows <= 20 ? 4 : 3);

export class TimelineView {
  readonly element: HTMLElement;
  private readonly canvas_ = el('canvas', { class: 'timeline-rows', role: 'img' });
  private readonly words_ = el('span', { class: 'timeline-words' });
  private readonly total_ = el('span', { class: 'figure' });
  private timeline_: Timeline | null = null;
  private rows_: readonly TimelineRow[] = [];
  private pointed_: { readonly x: number; readonly y: number } | null = null; // 0..1 of the canvas

  constructor() {
    this.element = el(
      'div',
      { class: 'timeline' },
      this.canvas_,
      el('div', { class: 'timeline-line', 'aria-hidden': 'true' }, this.words_, this.total_),
    );
    const point = (event: PointerEvent): void => {
      const box = this.canvas_.getBoundingClientRect();
      this.pointed_ = { x: (event.clientX - box.left) / box.width, y: (event.clientY - box.top) / box.height };
      this.say();
    };
    this.canvas_.addEventListener('pointerdown', point);
    this.canvas_.addEventListener('pointermove', point);
    this.canvas_.addEventListener('pointerleave', (event) => {
      if (event.pointerType === 'touch') return; // what a finger asked for stays to be read
      this.pointed_ = null;
      this.say();
    });
  }

  show(timeline: Timeline | null): void {
    this.timeline_ = timeline;
    this.rows_ = timeline === null ? [] : timelineRows(timeline);
    this.element.hidden = this.rows_.length === 0;
    if (timeline === null || this.rows_.length === 0) return;
    setText(this.total_, `${timeline.ms.toFixed(1)} ms`);
    this.say();
    this.draw(timeline.ms);
  }

  /** What a screen reader says of the rows. */
  describe(text: string): void {
    this.canvas_.setAttribute('aria-label', text);
  }

  private say(): void {
    const row = this.pointed_ === null ? undefined : this.rows_[this.rowAt(this.pointed_.y)];
    const ms = this.timeline_?.ms ?? 0;
    const reach = (REACH_PIXELS / Math.max(1, this.canvas_.clientWidth)) * ms;
    const at = clamp(this.pointed_?.x ?? 0, 0, 1) * ms;
    setText(this.words_, row === undefined ? 'Who worked when' : describeAt(row, ms, at, reach));
  }

  private rowAt(y: number): number {
    return clamp(Math.floor(y * this.rows_.length), 0, this.rows_.length - 1);
  }

  private draw(ms: number): void {
    const tall = rowHeight(this.rows_.length);
    this.canvas_.style.setProperty('--height', `${this.rows_.length * tall}px`);
    const ratio = window.devicePixelRatio;
    const width = Math.round(this.canvas_.clientWidth * ratio);
    const height = Math.round(this.rows_.length * tall * ratio);
    const context = this.canvas_.getContext('2d');
    if (context === null || width === 0) return;
    if (this.canvas_.width !== width || this.canvas_.height !== height) {
      this.canvas_.width = width;
      this.canvas_.height = height;
    }
    context.clearRect(0, 0, width, height);
    this.rows_.forEach((row, index) => {
      const top = Math.round(index * tall * ratio);
      const bottom = Math.round((index + 1) * tall * ratio) - Math.max(1, Math.floor(ratio));
      context.fillStyle = '#000';
      context.globalAlpha = 0.45;
      context.fillRect(0, top, width, bottom - top);
      this.drawRow(context, row, ms, width, top, bottom - top);
    });
  }

  private drawRow(
    context: CanvasRenderingContext2D,
    row: TimelineRow,
    ms: number,
    width: number,
    top: number,
    height: number,
  ): void {
    context.fillStyle = deviceColor(row.device);
    const busy = busyBins(row, ms, width);
    // Runs of equal busyness are one rectangle each, so whole batches cost one.
    for (let begin = 0, end = 0; begin < width; begin = end) {
      while (end < width && busy[end] === busy[begin]) end += 1;
      context.globalAlpha = busy[begin]!;
      if (busy[begin]! > 0) context.fillRect(begin, top, end - begin, height);
    }
    context.globalAlpha = 1;
    if (row.tracks.length > 1) return;
    for (const batch of row.tracks[0]!.batches) {
      const left = Math.round((batch.beginMs / ms) * width);
      if (((batch.endMs - batch.beginMs) / ms) * width >= SEPARATED_FROM) context.clearRect(left, top, 1, height);
    }
  }
}
