// What the statistics say of each device and of the scheduler, in words and figures. Knows no DOM.

import type { Numbers } from '../../wire/fields.js';
import { compact, duration, percent, whole } from '../../page/format.js';
import type { DevicePart, SchedulerStats } from '../../wire/protocol.js';

export interface DeviceRow {
  readonly device: string;
  readonly share: number; // 0..1
  readonly text: string;
  readonly note: string;
}

/**
 * One row per device: by its share of the work where the server states that, else by its tiles. `kinds`: of the devices
 * that made the newest picture, none: not known; tiles of others are of the past.
 */
export function deviceRows(
  all: Numbers,
  parts: readonly DevicePart[],
  kinds: readonly string[] = [],
): readonly DeviceRow[] {
  const present = ([device]: readonly [string, number]): boolean =>
    kinds.length === 0 || kinds.includes(device.split(':')[0]!) || parts.some((part) => part.device === device);
  const tiles: Numbers = Object.fromEntries(Object.entries(all).filter(present));
  const total = Object.values(tiles).reduce((sum, value) => sum + value, 0);
  const stated = parts.map((part) => partRow(part, tiles[part.device] ?? 0));
  const others = Object.entries(tiles)
    .filter(([device]) => !parts.some((part) => part.device === device))
    .map(([device, value]) => ({ device, share: total > 0 ? value / total : 0, text: whole(value), note: '' }));
  return [...stated, ...others];
}

function partRow({ device, part, reason, mraysPerSecond, share, idleShare }: DevicePart, tiles: number): DeviceRow {
  const takesPart = part === 'works' || part === 'probes';
  const figures = `${whole(tiles)} ${tiles === 1 ? 'tile' : 'tiles'} · ${compact(mraysPerSecond)} Mrays/s · ${percent(idleShare)} idle`;
  return {
    device,
    share,
    text: takesPart ? percent(share) : part,
    note: part === 'works' ? figures : part === 'probes' ? `probes: ${reason}` : reason,
  };
}

/** Label and figure of each fact; null figures: there is no scheduler at work. */
export function schedulerFacts(scheduler: SchedulerStats | null): readonly (readonly [string, string | null])[] {
  const reissued = scheduler?.reissued ?? 0;
  return [
    ['Lost at the end', scheduler === null ? null : duration(scheduler.endLossMs)],
    ['Deciding', scheduler === null ? null : duration(scheduler.decisionMs)],
    ['Batches', scheduler === null ? null : whole(scheduler.batches)],
    ['Given out again', scheduler === null ? null : `${whole(reissued)} ${reissued === 1 ? 'batch' : 'batches'}`],
  ];
}
