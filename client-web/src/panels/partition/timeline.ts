// Who worked when in one frame: gathering it to rows that fit, and saying it in words. Knows no DOM.

import { percent, whole } from '../../page/format.js';
import type { Batch, Timeline, Track } from '../../wire/partition_message.js';

/** A row of the picture of a timeline: one worker, or all workers of a device. */
export interface TimelineRow {
  readonly device: string;
  readonly label: string;
  readonly tracks: readonly Track[];
}

/** With more workers than this, the rows are devices. */
export const MOST_ROWS = 32;

/** One row per worker, or one per device where there are too many; those of a device stand together. */
export function timelineRows(timeline: Timeline): readonly TimelineRow[] {
  const devices = new Map<string, Track[]>();
  for (const track of timeline.workers) devices.set(track.device, [...(devices.get(track.device) ?? []), track]);
  const single = (track: Track): TimelineRow => ({
    device: track.device,
    label: `${track.device} worker ${track.worker}`,
    tracks: [track],
  });
  if (timeline.workers.length <= MOST_ROWS) return [...devices.values()].flat().map(single);
  return [...devices].map(([device, tracks]) => ({
    device,
    label: tracks.length === 1 ? `${device} worker ${tracks[0]!.worker}` : `${device}, ${tracks.length} workers`,
    tracks,
  }));
}

/** Busy share, 0..1, of each of `bins` equal parts of the frame, over the row's workers. */
export function busyBins(row: TimelineRow, ms: number, bins: number): Float64Array {
  const busy = new Float64Array(bins);
  if (!(ms > 0)) return busy;
  for (const track of row.tracks) {
    const own = new Float64Array(bins);
    for (const batch of track.batches) {
      const begin = clampBin((batch.beginMs / ms) * bins, bins);
      const end = clampBin((batch.endMs / ms) * bins, bins);
      for (let bin = Math.floor(begin); bin < end; bin += 1) {
        own[bin]! += Math.min(end, bin + 1) - Math.max(begin, bin);
      }
    }
    // Batches of one worker may overlap: a GPU gets its next one before the last has ended.
    for (let bin = 0; bin < bins; bin += 1) busy[bin]! += Math.min(1, own[bin]!) / row.tracks.length;
  }
  return busy;
}

const clampBin = (value: number, bins: number): number => Math.min(bins, Math.max(0, value));

/** Share of the frame in which the row's workers were busy, 0..1. */
export function busyShare(row: TimelineRow, ms: number): number {
  if (!(ms > 0) || row.tracks.length === 0) return 0;
  const busy = row.tracks.reduce((sum, track) => sum + busyMs(track), 0);
  return Math.min(1, busy / (ms * row.tracks.length));
}

function busyMs(track: Track): number {
  let total = 0;
  let until = -Infinity;
  for (const batch of [...track.batches].sort((a, b) => a.beginMs - b.beginMs)) {
    total += Math.max(0, batch.endMs - Math.max(until, batch.beginMs));
    until = Math.max(until, batch.endMs);
  }
  return total;
}

const cellsOf = (track: Track): number => track.batches.reduce((sum, batch) => sum + batch.cells, 0);
const time = (ms: number): string => ms.toFixed(1);
const cellCount = (cells: number): string => `${whole(cells)} ${cells === 1 ? 'cell' : 'cells'}`;

/** What a row did at `atMs`; a batch that is nearer than `reachMs` counts, so that thin ones can be pointed at. */
export function describeAt(row: TimelineRow, ms: number, atMs: number, reachMs: number): string {
  const [track] = row.tracks;
  if (track === undefined || row.tracks.length > 1) {
    const cells = row.tracks.reduce((sum, entry) => sum + cellsOf(entry), 0);
    return `${row.label}: ${cellCount(cells)}, busy ${percent(busyShare(row, ms))}`;
  }
  let best: Batch | null = null;
  let distance = Infinity;
  for (const batch of track.batches) {
    const away = Math.max(0, batch.beginMs - atMs, atMs - batch.endMs);
    if (away <= reachMs && away < distance) [best, distance] = [batch, away];
  }
  if (best === null) return `${row.label}: idle at ${time(atMs)} ms`;
  return `${row.label}: ${cellCount(best.cells)}, ${time(best.beginMs)}\u2013${time(best.endMs)} ms`;
}
