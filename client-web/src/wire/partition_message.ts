// Who made which cell of a frame, and who worked when, as docs/reference/protocol.md tells it.

import { cellGridOf, type CellGrid } from './cell_grid.js';
import { fieldsOf, isObject, listOf, textOf, type Fields } from './fields.js';
import { ProtocolError } from './frame.js';

export interface Batch {
  readonly beginMs: number; // since the frame's begin
  readonly endMs: number;
  readonly cells: number;
}

export interface Track {
  readonly device: string;
  readonly worker: number;
  readonly batches: readonly Batch[];
}

export interface Timeline {
  readonly ms: number; // of the whole frame
  readonly workers: readonly Track[];
}

/** In `owners`: no device. */
export const NOBODY = 255;
const MOST_DEVICES = 36; // one base-36 digit

export interface Partition extends CellGrid {
  readonly type: 'partition';
  readonly devices: readonly string[];
  readonly owners: Uint8Array; // per cell, row by row: index into devices, or NOBODY
  readonly timeline: Timeline | null;
}

/** Throws ProtocolError naming field, found value and what is allowed. */
export function partitionOf(fields: Fields): Partition {
  const grid = cellGridOf('partition', fields);
  const devices = listOf(fields['devices']).map(String);
  if (devices.length > MOST_DEVICES) {
    throw new ProtocolError(`partition.devices: ${devices.length}, allowed: at most ${MOST_DEVICES}`);
  }
  return {
    type: 'partition',
    ...grid,
    devices,
    owners: ownersOf(fields['cells'], grid.columns * grid.rows, devices.length),
    timeline: timelineOf(fields['timeline']),
  };
}

function ownersOf(cells: unknown, count: number, devices: number): Uint8Array {
  if (typeof cells !== 'string' || cells.length !== count) {
    const found = typeof cells === 'string' ? `${cells.length} cells` : JSON.stringify(cells);
    throw new ProtocolError(`partition.cells: ${found}, allowed: ${count} cells`);
  }
  const owners = new Uint8Array(count);
  for (let i = 0; i < count; i += 1) {
    const digit = cells[i]!;
    const owner = digit === '.' ? NOBODY : /[0-9a-z]/.test(digit) ? Number.parseInt(digit, 36) : NaN;
    if (owner !== NOBODY && !(owner < devices)) {
      throw new ProtocolError(`partition.cells[${i}]: "${digit}", allowed: "." or a digit below ${devices}`);
    }
    owners[i] = owner;
  }
  return owners;
}

function batchOf(value: unknown): Batch {
  const [beginMs, endMs, cells] = listOf(value);
  if (typeof beginMs !== 'number' || typeof endMs !== 'number' || typeof cells !== 'number') {
    throw new ProtocolError(`partition.timeline batch: ${JSON.stringify(value)}, allowed: [begin, end, cells]`);
  }
  // Times come from devices, and one may be wrong about them: a batch that ends before it begins took no time.
  return { beginMs, endMs: Math.max(beginMs, endMs), cells };
}

/** Null where the message has none. Throws ProtocolError. */
export function timelineOf(value: unknown): Timeline | null {
  if (!isObject(value)) return null;
  const ms = value['ms'];
  if (typeof ms !== 'number' || !(ms >= 0)) {
    throw new ProtocolError(`partition.timeline.ms: ${JSON.stringify(ms)}, allowed: 0 or more`);
  }
  const workers = listOf(value['workers']).map((entry) => {
    const fields = fieldsOf(entry);
    const worker = fields['worker'];
    return {
      device: textOf(fields['device']),
      worker: typeof worker === 'number' ? worker : 0,
      batches: listOf(fields['batches']).map(batchOf),
    };
  });
  return { ms, workers };
}
