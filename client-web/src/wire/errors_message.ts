// Where in a frame the error is, as docs/reference/protocol.md tells it.

import { listOf, type Fields } from './fields.js';
import { ProtocolError } from './frame.js';

const LARGEST_SIDE = 65_535; // pixels, as a frame's header has them

export interface ErrorMap {
  readonly type: 'errors';
  readonly frameId: number;
  readonly width: number; // rendered pixels
  readonly height: number;
  readonly cellWidth: number; // pixels
  readonly cellHeight: number;
  readonly columns: number;
  readonly rows: number;
  readonly cells: readonly (number | null)[]; // row by row: relative error; null: not known
}

/** Throws ProtocolError naming field, found value and what is allowed. */
export function errorMapOf(fields: Fields): ErrorMap {
  const whole = (name: string, low: number, high: number): number => {
    const value = fields[name];
    if (typeof value === 'number' && Number.isInteger(value) && value >= low && value <= high) return value;
    throw new ProtocolError(`errors.${name}: ${JSON.stringify(value)}, allowed: ${low} to ${high}`);
  };
  const [width, height] = [whole('width', 1, LARGEST_SIDE), whole('height', 1, LARGEST_SIDE)];
  const [cellWidth, cellHeight] = [whole('cellWidth', 1, LARGEST_SIDE), whole('cellHeight', 1, LARGEST_SIDE)];
  const [columns, rows] = [Math.ceil(width / cellWidth), Math.ceil(height / cellHeight)];
  const cells = listOf(fields['cells']).map((cell) => {
    if (cell === null) return null;
    if (typeof cell === 'number' && cell >= 0) return cell / 10_000;
    throw new ProtocolError(`errors.cells: ${JSON.stringify(cell)}, allowed: null or 0 and more`);
  });
  if (cells.length !== columns * rows) {
    throw new ProtocolError(`errors.cells: ${cells.length}, allowed: ${columns * rows}`);
  }
  return { type: 'errors', frameId: whole('frameId', 0, 0xffffffff), width, height, cellWidth, cellHeight, columns, rows, cells };
}
