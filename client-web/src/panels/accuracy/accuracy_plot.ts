// Error against time of all rows that were measured, both by equal factors: the best joined by a line, the settings as they
// were in a ring. What a pointer comes near to is looked at, a press chooses it; the list beside it serves the keyboard.

import { drawn, el } from '../../page/dom.js';
import { percent } from '../../page/format.js';
import type { AccuracyRow } from '../../wire/accuracy_message.js';
import type { Measured } from './accuracy_model.js';
import { bestRows, frameTime, givenRow, plottedRows } from './accuracy_rows.js';
import { logScale, logTicks, type LogScale } from './log_scale.js';

const WIDTH = 304;
const HEIGHT = 208;
const LEFT = 40;
const RIGHT = 8;
const TOP = 20;
const BOTTOM = 32;
const REACH = 24; // CSS pixels from which a point is meant
const MOST_TICKS = 6;
const KEY = [
  ['best', 'best for its time'],
  ['given', 'as it was'],
  ['', 'other'],
] as const;

export interface RowHooks {
  /** A row is pointed at or has the focus. */
  look(row: AccuracyRow): void;
  /** No longer; what something else looks at meanwhile stays. */
  leave(row: AccuracyRow): void;
  choose(row: AccuracyRow): void;
}

interface Point {
  readonly row: AccuracyRow;
  readonly x: number;
  readonly y: number;
  readonly dot: SVGElement;
}

const errorTick = (error: number): string => `${Number((100 * error).toPrecision(3))} %`;

export class AccuracyPlot {
  readonly element: HTMLElement;
  private readonly drawing_ = drawn('svg', { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, class: 'accuracy-drawing', role: 'img' });
  private points_: readonly Point[] = [];

  constructor(hooks: RowHooks) {
    const key = KEY.map(([kind, words]) => el('li', {}, el('span', { class: `key ${kind}` }), words));
    this.element = el('div', {}, this.drawing_, el('ul', { class: 'accuracy-key', 'aria-hidden': 'true' }, ...key));
    let pointed: AccuracyRow | null = null;
    const point = (row: AccuracyRow | null): void => {
      this.drawing_.classList.toggle('near', row !== null);
      if (row === null && pointed !== null) hooks.leave(pointed);
      if (row !== null) hooks.look(row);
      pointed = row;
    };
    this.drawing_.addEventListener('pointermove', (event) => point(this.near(event)?.row ?? null));
    this.drawing_.addEventListener('pointerleave', () => point(null));
    this.drawing_.addEventListener('click', (event) => {
      const near = this.near(event);
      if (near === null) return;
      hooks.choose(near.row);
      hooks.look(near.row); // a finger leaves before it clicks
    });
  }

  draw({ accuracy }: Measured): void {
    const rows = plottedRows(accuracy);
    const times = logScale(rows.flatMap(({ ms, low, high }) => [ms, low, high]).map((ms) => ms * accuracy.scale));
    const errors = logScale(rows.map(({ rmse }) => rmse ?? 0));
    const x = (ms: number): number => LEFT + (WIDTH - LEFT - RIGHT) * times.at(ms * accuracy.scale);
    const y = (error: number): number => HEIGHT - BOTTOM - (HEIGHT - TOP - BOTTOM) * errors.at(error);
    const given = givenRow(accuracy);
    const best = bestRows(accuracy).filter((row) => row.front && rows.includes(row));
    this.points_ = rows.map((row) => {
      const [cx, cy] = [x(row.ms), y(row.rmse ?? 0)];
      const kind = row === given ? ' given' : row.front ? ' best' : '';
      return { row, x: cx, y: cy, dot: drawn('circle', { class: `dot${kind}`, cx, cy, r: kind === '' ? 2.5 : 4 }) };
    });
    const line = best.map(({ ms, rmse }) => `${x(ms).toFixed(1)},${y(rmse ?? 0).toFixed(1)}`).join(' ');
    const spread = [...best, ...(given === null ? [] : [given])].map((row) =>
      drawn('line', { class: 'spread', x1: x(row.low), x2: x(row.high), y1: y(row.rmse ?? 0), y2: y(row.rmse ?? 0) }),
    );
    const plain = this.points_.filter(({ row }) => !row.front && row !== given);
    const marked = this.points_.filter((point) => !plain.includes(point));
    this.drawing_.replaceChildren(
      ...axes(times, errors),
      ...spread,
      drawn('polyline', { class: 'front', points: line }),
      ...[...plain, ...marked].map(({ dot }) => dot),
    );
    this.drawing_.setAttribute('aria-label', describe(rows, best, accuracy.scale));
  }

  mark(looked: AccuracyRow | null, now: AccuracyRow | null): void {
    for (const { row, dot } of this.points_) {
      dot.classList.toggle('looked', row === looked || (looked?.given === true && row.given));
      dot.classList.toggle('now', row === now || (now?.given === true && row.given));
    }
  }

  /** The point nearest to an event, within reach. */
  private near({ clientX, clientY }: MouseEvent): Point | null {
    const box = this.drawing_.getBoundingClientRect();
    const scale = box.width / WIDTH;
    const away = ({ x, y }: Point): number => Math.hypot(box.left + scale * x - clientX, box.top + scale * y - clientY);
    let nearest: Point | null = null;
    let least = REACH;
    for (const point of this.points_) if (away(point) < least) [nearest, least] = [point, away(point)];
    return nearest;
  }
}

function axes(times: LogScale, errors: LogScale): readonly SVGElement[] {
  const [unit, ms] = times.low >= 500 ? ['s', 1000] : ['ms', 1];
  const [right, bottom] = [WIDTH - RIGHT, HEIGHT - BOTTOM];
  const across = logTicks(times, MOST_TICKS).flatMap((time) => {
    const x = LEFT + (right - LEFT) * times.at(time);
    return [
      drawn('line', { class: 'grid', x1: x, x2: x, y1: TOP, y2: bottom }),
      drawn('text', { class: 'middle', x: Math.min(x, right - 12), y: bottom + 13 }, String(time / ms)),
    ];
  });
  const up = logTicks(errors, MOST_TICKS).flatMap((error) => {
    const y = bottom - (bottom - TOP) * errors.at(error);
    return [
      drawn('line', { class: 'grid', x1: LEFT, x2: right, y1: y, y2: y }),
      drawn('text', { class: 'end', x: LEFT - 4, y: y + 3.5 }, errorTick(error)),
    ];
  });
  return [
    ...across,
    ...up,
    drawn('text', { x: 0, y: 10 }, 'error'),
    drawn('text', { class: 'end', x: right, y: HEIGHT - 5 }, `time of a frame, ${unit}`),
  ];
}

/** In a sentence, for those who do not see it. */
function describe(rows: readonly AccuracyRow[], best: readonly AccuracyRow[], scale: number): string {
  const [fastest, slowest] = [best[0], best.at(-1)];
  const range =
    fastest === undefined || slowest === undefined
      ? ''
      : `, the best from ${frameTime(scale * fastest.ms)} at ${percent(fastest.rmse ?? 0)} to ` +
        `${frameTime(scale * slowest.ms)} at ${percent(slowest.rmse ?? 0)}`;
  return `Error against time of a frame: ${rows.length} settings${range}. The list below has all of them.`;
}
