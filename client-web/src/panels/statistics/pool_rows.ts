// What the statistics say of the nodes of a pool, in words and figures. Knows no DOM.

import type { DevicePart } from '../../wire/protocol.js';
import type { PoolNode, PoolStats } from '../../wire/pool_stats.js';
import { compact, percent, whole } from '../../page/format.js';

export interface PoolRow {
  readonly key: string;
  readonly label: string;
  readonly device: string; // whose colour it has; '': none
  readonly share: number; // of the last pass, 0..1
  readonly text: string;
  readonly note: string;
}

/** One line on the pool as a whole. */
export function poolTitle({ broker, connected, nodes }: PoolStats): string {
  if (!connected) return `Pool: no line to ${broker}`;
  const there = nodes.filter((node) => node.refused === '').length;
  return there === 0 ? 'Pool: no nodes' : `Pool: ${whole(there)} ${there === 1 ? 'node' : 'nodes'}`;
}

/** One row per node. `parts`: of the last pass. */
export const poolRows = (pool: PoolStats, parts: readonly DevicePart[]): readonly PoolRow[] =>
  pool.nodes.map((node, index) => poolRow(node, index, parts.find((part) => part.device === node.device)));

function poolRow(node: PoolNode, index: number, part: DevicePart | undefined): PoolRow {
  const works = part?.part === 'works' || part?.part === 'probes';
  const share = works ? part.share : 0;
  const figures = [
    node.device === '' ? '' : node.name,
    node.mraysPerSecond > 0 ? `${compact(node.mraysPerSecond)} Mrays/s` : '',
    node.roundTripMs > 0 ? `${compact(node.roundTripMs)} ms there and back` : '',
    node.hardware,
  ].filter((figure) => figure !== '');
  return {
    key: node.device === '' ? `refused ${index}` : node.device,
    label: node.device === '' ? node.name : node.device,
    device: node.device,
    share,
    text: works ? percent(share) : node.state,
    note: node.refused === '' ? figures.join(' · ') : node.refused,
  };
}
