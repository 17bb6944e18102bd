// Who made which cell of a frame: the geometry of its display. Knows no DOM.

import { percent } from '../../page/format.js';
import { NOBODY, type Partition } from '../../wire/partition_message.js';
import { busyShare, timelineRows, type TimelineRow } from './timeline.js';

/** Share of the picture's pixels, 0..1, of each device in their order, and of nobody as the last entry. */
export function pixelShares(partition: Partition): readonly number[] {
  const { columns, rows, cellWidth, cellHeight, width, height, owners, devices } = partition;
  const pixels = new Array<number>(devices.length + 1).fill(0);
  for (let row = 0; row < rows; row += 1) {
    const tall = Math.min(cellHeight, height - row * cellHeight);
    for (let column = 0; column < columns; column += 1) {
      const wide = Math.min(cellWidth, width - column * cellWidth);
      const owner = owners[row * columns + column]!;
      pixels[owner === NOBODY ? devices.length : owner]! += wide * tall;
    }
  }
  return pixels.map((count) => count / (width * height));
}

/** A straight line between cells of different devices, in rendered pixels. */
export interface BorderLine {
  readonly x0: number;
  readonly y0: number;
  readonly x1: number;
  readonly y1: number;
}

/** The lines between cells of different devices; neighbours on one line are joined. */
export function borderLines(partition: Partition): readonly BorderLine[] {
  const { columns, rows, cellWidth, cellHeight, width, height, owners } = partition;
  const lines: BorderLine[] = [];
  const runs = (count: number, differs: (i: number) => boolean, add: (begin: number, end: number) => void): void => {
    let begin = -1;
    for (let i = 0; i <= count; i += 1) {
      const on = i < count && differs(i);
      if (on && begin < 0) begin = i;
      if (on || begin < 0) continue;
      add(begin, i);
      begin = -1;
    }
  };
  for (let column = 1; column < columns; column += 1) {
    const differs = (row: number): boolean => owners[row * columns + column - 1] !== owners[row * columns + column];
    const x = column * cellWidth;
    runs(rows, differs, (begin, end) =>
      lines.push({ x0: x, y0: begin * cellHeight, x1: x, y1: Math.min(height, end * cellHeight) }),
    );
  }
  for (let row = 1; row < rows; row += 1) {
    const differs = (column: number): boolean =>
      owners[(row - 1) * columns + column] !== owners[row * columns + column];
    const y = row * cellHeight;
    runs(columns, differs, (begin, end) =>
      lines.push({ x0: begin * cellWidth, y0: y, x1: Math.min(width, end * cellWidth), y1: y }),
    );
  }
  return lines;
}

/** The partition in sentences, for those who do not see it. */
export function describePartition(partition: Partition): string {
  const shares = pixelShares(partition);
  const { timeline } = partition;
  const rows = timeline === null ? [] : timelineRows(timeline);
  const sentences = partition.devices.map((device, index) => {
    const tracks = rows.filter((row) => row.device === device).flatMap((row) => row.tracks);
    const all: TimelineRow = { device, label: device, tracks };
    const workers = `${tracks.length} ${tracks.length === 1 ? 'worker' : 'workers'}`;
    const busy =
      timeline === null || tracks.length === 0 ? '' : `, ${workers}, busy ${percent(busyShare(all, timeline.ms))}`;
    return `${device}: ${percent(shares[index]!)} of the picture${busy}.`;
  });
  if (timeline !== null) sentences.unshift(`The frame took ${timeline.ms.toFixed(1)} ms.`);
  return sentences.join(' ');
}
