// Where in a frame the error is, as docs/reference/protocol.md tells it.

import { cellGridOf, type CellGrid } from './cell_grid.js';
import { listOf, type Fields } from './fields.js';
import { ProtocolError } from './frame.js';

export interface ErrorMap extends CellGrid {
  readonly type: 'errors';
  readonly cells: readonly (number | null)[]; // row by row: relative error; null: not known
}

/** Throws ProtocolError naming field, found value and what is allowed. */
export function errorMapOf(fields: Fields): ErrorMap {
  const grid = cellGridOf('errors', fields);
  const cells = listOf(fields['cells']).map((cell) => {
    if (cell === null) return null;
    if (typeof cell === 'number' && cell >= 0) return cell / 10_000;
    throw new ProtocolError(`errors.cells: ${JSON.stringify(cell)}, allowed: null or 0 and more`);
  });
  if (cells.length !== grid.columns * grid.rows) {
    throw new ProtocolError(`errors.cells: ${cells.length}, allowed: ${grid.columns * grid.rows}`);
  }
  return { type: 'errors', ...grid, cells };
}
