// What the server says of a pool of render nodes, in `stats`.

import { fieldsOf, isObject, listOf, numberOf, textOf } from './fields.js';

export interface PoolNode {
  readonly device: string; // as tiles and parts name it; '' for one that is refused
  readonly name: string;
  readonly hardware: string;
  readonly state: string; // 'ready', 'here', 'refused', or what it does with the scene
  readonly refused: string; // why; '': it is not
  readonly roundTripMs: number; // 0: not measured
  readonly mraysPerSecond: number; // 0: not measured
  readonly tiles: number; // for this server, since it joined
}

export interface PoolStats {
  readonly broker: string;
  readonly connected: boolean;
  readonly nodes: readonly PoolNode[];
}

/** Null: there is no pool. */
export function poolOf(value: unknown): PoolStats | null {
  if (!isObject(value)) return null;
  const nodes = listOf(value['nodes']).map((entry) => {
    const fields = fieldsOf(entry);
    return {
      device: textOf(fields['device']),
      name: textOf(fields['name']),
      hardware: textOf(fields['hardware']),
      state: textOf(fields['state']),
      refused: textOf(fields['refused']),
      roundTripMs: numberOf(fields['roundTripMs']),
      mraysPerSecond: numberOf(fields['mraysPerSecond']),
      tiles: numberOf(fields['tiles']),
    };
  });
  return { broker: textOf(value['broker']), connected: value['connected'] === true, nodes };
}
