// The settings of the hybrid device, and which of them count for nothing at the moment.

import type { SettingValue } from '../../wire/protocol.js';

export const HYBRID_ROWS: readonly string[] = [
  'hybridBalance',
  'hybridShare',
  'enableEmbree',
  'enableVulkan',
  'showPartition',
];

const ONLY_HYBRID = 'Only with device hybrid.';

/** Why the setting `name` changes nothing with the present values; null when it does. */
export function withoutUse(name: string, value: (name: string) => SettingValue | undefined): string | null {
  if (!HYBRID_ROWS.includes(name) || name === 'showPartition') return null;
  if (value('device') !== 'hybrid') return ONLY_HYBRID;
  if (name === 'hybridShare' && value('hybridBalance') !== 'manual') return 'Only with a manual balance.';
  return null;
}
