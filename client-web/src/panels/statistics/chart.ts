// A small chart of the times between frames: one bar per frame, newest at the right, guide lines at 60 and 30 per
// second.

import { el } from '../../page/dom.js';
import { compact } from '../../page/format.js';

const BARS = 120;
const GUIDES = [1000 / 60, 1000 / 30]; // ms

export class FrameChart {
  readonly element: HTMLElement;
  private readonly canvas_ = el('canvas', { role: 'img', 'aria-label': 'Time between frames' });
  private readonly scale_ = el('span', { class: 'chart-scale' });

  constructor() {
    this.element = el('div', { class: 'chart' }, this.canvas_, this.scale_);
  }

  /** `intervals`: milliseconds, oldest first. */
  draw(intervals: readonly number[]): void {
    const ratio = window.devicePixelRatio;
    const width = Math.round(this.canvas_.clientWidth * ratio);
    const height = Math.round(this.canvas_.clientHeight * ratio);
    const context = this.canvas_.getContext('2d');
    if (context === null || width === 0 || height === 0) return;
    if (this.canvas_.width !== width || this.canvas_.height !== height) {
      this.canvas_.width = width;
      this.canvas_.height = height;
    }
    const values = intervals.slice(-BARS);
    const top = chartTop(values);
    const style = getComputedStyle(this.canvas_);
    context.clearRect(0, 0, width, height);
    context.fillStyle = style.getPropertyValue('--line');
    for (const guide of GUIDES)
      if (guide < top) context.fillRect(0, Math.round(height * (1 - guide / top)), width, Math.max(1, ratio));
    context.fillStyle = style.getPropertyValue('--accent');
    const step = width / BARS;
    values.forEach((value, index) => {
      const bar = Math.max(1, (Math.min(value, top) / top) * height);
      context.fillRect((BARS - values.length + index) * step, height - bar, Math.max(1, step - ratio), bar);
    });
    this.scale_.textContent = `${compact(top, 0)} ms`;
  }
}

/** A round upper end that 95 % of the values fit under, at least two frames of 60 per second. */
export function chartTop(values: readonly number[]): number {
  const sorted = [...values].sort((a, b) => a - b);
  const high = sorted[Math.floor(0.95 * (sorted.length - 1))] ?? 0;
  const rounds = [40, 60, 100, 150, 200, 300, 500, 1000, 2000, 5000];
  return rounds.find((round) => round >= high * 1.1) ?? 10_000;
}
