// Where the time of each frame went, as a column of parts of a few kinds. Knows no DOM.

import { stretchesOf, type FrameTimes, type Stretch } from './frame_trace.js';

/** The kinds in the order in which they are stacked, the first at the bottom. */
export const KINDS = ['render', 'picture', 'waits', 'line', 'page'] as const;
export type Kind = (typeof KINDS)[number];

export const KIND_LABELS: Readonly<Record<Kind, string>> = {
  render: 'Tracing',
  picture: 'Developing and encoding',
  waits: 'Waiting at the server',
  line: 'On the line',
  page: 'This page',
};

const kindOf = ({ who, what }: Stretch): Kind => {
  if (who !== 'server') return who;
  if (what === 'render') return 'render';
  return what === 'develop' || what === 'encode' ? 'picture' : 'waits';
};

export interface Column {
  readonly parts: Readonly<Record<Kind, number>>; // ms
  readonly total: number; // ms
}

/** From the input that the frame shows first, or from the pass where it shows none, until it was on the screen. */
export function columnOf(times: FrameTimes): Column {
  const parts: Record<Kind, number> = { render: 0, picture: 0, waits: 0, line: 0, page: 0 };
  for (const stretch of stretchesOf(times)) parts[kindOf(stretch)] += stretch.end - stretch.begin;
  return { parts, total: KINDS.reduce((sum, kind) => sum + parts[kind], 0) };
}

/** One frame in words. */
export function columnText({ frame, input }: FrameTimes, { parts, total }: Column): string {
  const pieces = KINDS.map((kind) => `${KIND_LABELS[kind].toLowerCase()} ${parts[kind].toFixed(1)}`);
  const of = input === null ? 'refines' : `shows input ${frame.inputId}`;
  return `Frame ${frame.frameId}, ${frame.width} × ${frame.height}, ${of}: ${total.toFixed(1)} ms (${pieces.join(', ')})`;
}
