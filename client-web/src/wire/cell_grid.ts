// A frame in cells, as the messages about its parts give it.

import type { Fields } from './fields.js';
import { ProtocolError } from './frame.js';

const LARGEST_SIDE = 65_535; // pixels, as a frame's header has them

export interface CellGrid {
  readonly frameId: number;
  readonly width: number; // rendered pixels
  readonly height: number;
  readonly cellWidth: number; // pixels
  readonly cellHeight: number;
  readonly columns: number;
  readonly rows: number;
}

/** `message`: its type. Throws ProtocolError naming field, found value and what is allowed. */
export function cellGridOf(message: string, fields: Fields): CellGrid {
  const whole = (name: string, low: number, high: number): number => {
    const value = fields[name];
    if (typeof value === 'number' && Number.isInteger(value) && value >= low && value <= high) return value;
    throw new ProtocolError(`${message}.${name}: ${JSON.stringify(value)}, allowed: ${low} to ${high}`);
  };
  const [width, height] = [whole('width', 1, LARGEST_SIDE), whole('height', 1, LARGEST_SIDE)];
  const [cellWidth, cellHeight] = [whole('cellWidth', 1, LARGEST_SIDE), whole('cellHeight', 1, LARGEST_SIDE)];
  const [columns, rows] = [Math.ceil(width / cellWidth), Math.ceil(height / cellHeight)];
  return { frameId: whole('frameId', 0, 0xffffffff), width, height, cellWidth, cellHeight, columns, rows };
}
